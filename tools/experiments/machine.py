"""Where trainings and tests run, and who hears how far they are."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

import torch

from avod.device import Processes

Progress = Callable[[int, str, str], AbstractContextManager[Callable[[int, str], None]]]
"""Takes a total, a name, and a unit, and gives what hears of the number done and a note meanwhile."""


@dataclass(frozen=True, kw_only=True)
class Machine:
    """What runs the experiments.

    Attributes:
        processes: this process among those that `torchrun` has started.
        precision: of the arithmetic of layers, None for float32.
        workers: processes that read frames; 0 reads them in between.
        is_compiled: compile the pyramids in training.
        should_stop: is asked after each step and each frame.
        progress: hears how far trainings and tests are.
    """

    processes: Processes
    precision: torch.dtype | None = None
    workers: int = 0
    is_compiled: bool = False
    should_stop: Callable[[], bool]
    progress: Progress
