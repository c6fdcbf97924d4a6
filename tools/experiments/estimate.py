"""How long the experiments will take: from a few steps and frames that are timed on this machine."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from avod.config import Config
from avod.detector import Detector
from avod.predict import predict
from avod.train import Run, train, with_steps
from tools.experiments.cells import Cell
from tools.experiments.machine import Machine
from tools.experiments.sets import TRAIN, FrameSet

WARM_UP: Final = 3
TIMED: Final = 7


@dataclass(frozen=True)
class Speed:
    """What one step of training and one frame of detection take.

    Attributes:
        step_s: seconds, reading the next step's frames included.
        frame_s: seconds, likewise.
    """

    step_s: float
    frame_s: float


def measure_speed(config: Config, frames: FrameSet, machine: Machine) -> Speed:
    """Time `TIMED` steps and frames, after `WARM_UP` that are not counted.

    Args:
        config: of the detector; its training is cut short.
        frames: to learn from and to detect in; the first come again where they are fewer.
        machine: that it runs on.
    """
    steps = [0.0]

    def on_step(done: int, losses: dict[str, Any]) -> None:
        steps.append(time.perf_counter())

    processes = machine.processes
    with tempfile.TemporaryDirectory() as own:
        (folder, *_) = processes.gathered(own)
        run = Run(
            data=frames.folder,
            out=folder,
            split=TRAIN,
            device=processes.device,
            precision=machine.precision,
            workers=machine.workers,
            compile=machine.compile,
        )
        # The last step writes a checkpoint before it is heard of.
        last = train(with_steps(config, WARM_UP + TIMED + 1), run, on_step=on_step)
        detector = Detector(last, device=processes.device, precision=machine.precision)
        processes.any(False)  # The first process removes its folder when all have read.
    ids = frames.val_ids[: WARM_UP + TIMED]
    marks = [time.perf_counter()]
    for _ in predict(detector, frames.folder, ids, workers=machine.workers):
        marks.append(time.perf_counter())
    warm = min(WARM_UP, len(ids) - 1)
    frame_s = (marks[-1] - marks[warm]) / (len(ids) - warm)
    return Speed((steps[WARM_UP + TIMED] - steps[WARM_UP]) / TIMED, frame_s)


def cell_seconds(cell: Cell, speed: Speed, num_val: Mapping[str, int]) -> float:
    """Return what a cell takes: its steps, and its validation frames, the first set's for each checkpoint to choose.

    Args:
        cell: from its beginning.
        speed: of its class.
        num_val: validation frames by set.
    """
    num_frames = sum(num_val[tested] for tested in cell.tests)
    # A training has no more checkpoints than it writes.
    candidates = min(cell.last, max(1, -(-cell.num_steps // cell.config.training.checkpoint_steps)))
    num_frames += (candidates - 1) * num_val[cell.tests[0]]
    return cell.num_steps * speed.step_s + num_frames * speed.frame_s


def shared_seconds(cells: Sequence[Cell], seconds: Mapping[str, float], num_devices: int) -> float:
    """Return when the last cell ends if devices that are free take the next cell, once its source is finished.

    Args:
        cells: those to be run, in their order.
        seconds: of each, by name.
        num_devices: that share the cells.
    """
    free_s = [0.0] * num_devices
    ends_s: dict[str, float] = {}
    for cell in cells:
        ready_s = ends_s.get(cell.source or "", 0.0)
        device = min(range(num_devices), key=lambda index: (max(free_s[index], ready_s), index))
        ends_s[cell.name] = free_s[device] = max(free_s[device], ready_s) + seconds[cell.name]
    return max(ends_s.values(), default=0.0)


def hours(seconds: float) -> str:
    """Write seconds as hours."""
    return f"{seconds / 3600.0:.1f} h" if seconds >= 360.0 else f"{seconds / 60.0:.1f} min"
