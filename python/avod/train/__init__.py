"""Training: steps, schedule, checkpoints, log."""

from avod.train.run import Run, train, with_steps

__all__ = ["Run", "train", "with_steps"]
