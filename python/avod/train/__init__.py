"""Training: steps, schedule, checkpoints, log."""

from avod.train.run import train, with_steps
from avod.train.settings import Run

__all__ = ["Run", "train", "with_steps"]
