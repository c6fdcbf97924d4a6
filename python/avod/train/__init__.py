"""Training: steps, schedule, checkpoints, log."""

from avod.train.run import train

__all__ = ["train"]
