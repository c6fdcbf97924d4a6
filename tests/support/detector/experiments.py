"""Small experiments for tests: one class, one configuration of the maps, trainings of a few steps."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from avod.device import Processes
from detector.runs import TEXT, write_set
from tools.experiments.cells import Cell
from tools.experiments.experiment import run_cells
from tools.experiments.machine import Machine
from tools.experiments.plans import matrix_cells
from tools.experiments.record import begin_experiment
from tools.experiments.scales import Scale, Tuning
from tools.experiments.sets import FrameSet, Sets

STEPS = 4
TUNING = Tuning(steps=2, learning_rate=5e-4, decay_factor=0.5, decay_steps=2)


def micro_scale(folder: Path, *, branch_step: int | None = None, last: int = 1) -> Scale:
    """Make a scale of trainings of `STEPS` steps, with a checkpoint every second one."""
    file = folder / "micro.toml"
    text = TEXT.replace("steps = 8", f"steps = {STEPS}").replace("checkpoint_steps = 3", "checkpoint_steps = 2")
    file.write_text(text)
    tuning = Tuning(steps=2, learning_rate=5e-4, decay_factor=0.5, decay_steps=2, branch_step=branch_step)
    return Scale(name="micro", configs={("Car", "default"): str(file)}, tuning=tuning, few_steps=3, last=last)


def micro_sets(folder: Path) -> Sets:
    """Write and read two sets: the real one has more frames."""
    return {
        "real": FrameSet.read(write_set(folder / "real", num_train=4, num_val=2)),
        "sim": FrameSet.read(write_set(folder / "sim", num_train=3, num_val=2)),
    }


def run_micro(
    out: Path, cells: Sequence[Cell], scale: Scale, sets: Sets, should_stop: Callable[[], bool] = lambda: False
) -> bool:
    """Run cells until they are finished or told to stop."""
    begin_experiment(out, scale, None, sets)
    machine = Machine(processes=Processes(), should_stop=should_stop, progress=silent)
    return run_cells(cells, out, sets, machine, lambda name: None)


def micro_cells(scale: Scale) -> tuple[Cell, ...]:
    """List the cells of one seed: on simulated frames, on real ones, and tuned."""
    return matrix_cells(scale, ("Car",), ("default",), 1)


@contextlib.contextmanager
def silent(total: int, name: str, unit: str) -> Iterator[Callable[[int, str], None]]:
    """Show no progress."""
    yield lambda done, note: None
