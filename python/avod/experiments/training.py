"""The training of a cell, by `avod.train`: begun, gone on with, and kept where another one goes on from it."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from torch import Tensor

from avod.experiments.cells import Cell
from avod.experiments.machine import Machine
from avod.experiments.record import cell_folder
from avod.experiments.sets import TRAIN, Sets
from avod.train import Run, train, with_steps
from avod.train.checkpoint import checkpoints, keep_checkpoint

_KEPT = "kept"
BEST = "best"
"""The folder of the checkpoint that counts."""


def train_cell(cell: Cell, out: Path, sets: Sets, machine: Machine) -> bool:
    """Train a cell to its end, from where it stopped.

    Args:
        cell: with a training.
        out: the experiments' folder.
        sets: of frames, by name.
        machine: that it runs on.

    Returns:
        Whether it came to its end; else it was told to stop, and goes on another time.
    """
    folder = cell_folder(out, cell.name)
    for stop in cell.stops:
        written = checkpoints(folder / "run" / "checkpoints")
        if not written or int(written[-1].name) < stop:
            _train_to(stop, cell, out, sets, machine, is_new=not written)
            written = checkpoints(folder / "run" / "checkpoints")
            if int(written[-1].name) < stop:
                return False
        if stop != cell.stops[-1] and int(written[-1].name) == stop and machine.processes.is_first:
            keep_checkpoint(written[-1], folder / _KEPT / written[-1].name, has_optimizer=True)
        machine.processes.any(False)  # Nobody goes on before it is kept.
    return True


def candidates(cell: Cell, out: Path) -> list[Path]:
    """Return the checkpoints that the one that counts is chosen from."""
    if cell.init is not None and not cell.stops:
        return [cell.init]
    return checkpoints(cell_folder(out, cell.name) / "run" / "checkpoints")[-cell.last :]


def beginning(cell: Cell, out: Path) -> dict[str, Path]:
    """Return the checkpoint that a training begins with, as `Run` takes it: none, its weights, or all of it."""
    if cell.source is None:
        return {} if cell.init is None else {"init": cell.init}
    source = cell_folder(out, cell.source)
    if cell.branch_step is None:
        return {"init": source / BEST}
    return {"resume_from": source / _KEPT / f"{cell.branch_step:09d}"}


def _train_to(stop: int, cell: Cell, out: Path, sets: Sets, machine: Machine, *, is_new: bool) -> None:
    folder = cell_folder(out, cell.name) / "run"
    if is_new and folder.exists() and machine.processes.is_first:
        # Killed before its first checkpoint: nothing to go on from.
        shutil.rmtree(folder)
    machine.processes.any(False)
    begin: dict[str, Any] = beginning(cell, out) if is_new else {"resume": True}
    run = Run(
        data=sets[cell.data].folder,
        out=folder,
        split=TRAIN,
        seed=cell.seed,
        keep=cell.last,
        device=machine.processes.device,
        precision=machine.precision,
        workers=machine.workers,
        is_compiled=machine.is_compiled,
        frames=cell.frames,
        **begin,
    )
    with machine.progress(stop, cell.name, "steps") as advance:

        def on_step(done: int, losses: dict[str, Tensor]) -> None:
            advance(done, f"loss {float(losses['total']):.3f}" if losses else "left out")

        train(with_steps(cell.config, stop), run, on_step=on_step, should_stop=machine.should_stop)
