"""The training of a cell, by `avod.train`: begun, gone on with, and kept where another one continues from it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from torch import Tensor

from avod.train import Run, train, with_steps
from avod.train.checkpoint import checkpoints, keep_checkpoint
from avod.train.settings import has_record
from tools.experiments.cells import Cell
from tools.experiments.machine import Machine
from tools.experiments.record import cell_folder
from tools.experiments.sets import TRAIN, Sets

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
            _train_to(stop, cell, out, sets, machine)
            written = checkpoints(folder / "run" / "checkpoints")
            if int(written[-1].name) < stop:
                return False
        if stop != cell.stops[-1] and int(written[-1].name) == stop and machine.processes.is_first:
            keep_checkpoint(written[-1], folder / _KEPT / written[-1].name, has_optimizer=True)
        machine.processes.any(False)  # Nobody goes on before it is kept.
    return True


def candidates(cell: Cell, out: Path) -> list[Path]:
    """Return the checkpoints that the one that counts is chosen from: none that merely a stop has left."""
    if cell.init is not None and not cell.stops:
        return [cell.init]
    every = cell.config.training.checkpoint_steps
    written = checkpoints(cell_folder(out, cell.name) / "run" / "checkpoints")
    return [path for path in written if int(path.name) % every == 0 or int(path.name) in cell.stops][-cell.last :]


def beginning(cell: Cell, out: Path) -> dict[str, Path]:
    """Return the checkpoint that a training begins with, as `Run` takes it: none, its weights, or all of it."""
    if cell.source is None:
        return {} if cell.init is None else {"init": cell.init}
    source = cell_folder(out, cell.source)
    if cell.branch_step is None:
        return {"init": source / BEST}
    return {"resume_from": source / _KEPT / f"{cell.branch_step:09d}"}


def _train_to(stop: int, cell: Cell, out: Path, sets: Sets, machine: Machine) -> None:
    folder = cell_folder(out, cell.name) / "run"
    # Decided by one for all: the first to begin writes what the others would find.
    (is_begun, *_) = machine.processes.gathered(has_record(folder))
    begin: dict[str, Any] = {"resume": True} if is_begun else beginning(cell, out)
    folders = [sets[name].folder for name in cell.data]
    run = Run(
        data=folders[0] if len(folders) == 1 else [(path, 1.0) for path in folders],
        out=folder,
        split=TRAIN,
        seed=cell.seed,
        keep=1 if cell.last == 1 else None,
        device=machine.processes.device,
        precision=machine.precision,
        workers=machine.workers,
        compile=machine.compile,
        num_frames=cell.frames,
        **begin,
    )
    with machine.progress(stop, cell.name, "steps") as advance:

        def on_step(done: int, losses: dict[str, Tensor]) -> None:
            advance(done, f"loss {float(losses['total']):.3f}" if losses else "left out")

        train(with_steps(cell.config, stop), run, on_step=on_step, should_stop=machine.should_stop)
