"""The experiments: cell after cell, and after each the tables and figures of all that is finished."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Final

from cadet._util.operating_system import FolderInUseError, locked_folder
from cadet.errors import CadetError
from cadet.formats.kitti.files.folder import write_whole
from tools.experiments.cells import Cell
from tools.experiments.figure import few_frames_figure, matrix_figure, png_of
from tools.experiments.machine import Machine
from tools.experiments.means import grouped
from tools.experiments.outcome import is_finished, read_outcomes
from tools.experiments.record import EXPERIMENT_FILE, begin_cell, cell_folder, read_note, write_note
from tools.experiments.sets import Sets
from tools.experiments.table import plain_rows, tables
from tools.experiments.testing import run_tests
from tools.experiments.training import train_cell

WAIT_S: Final = 20.0
"""How long a cell is waited for: the workers of a process that was killed notice it after 5 s, and hold its lock."""


def selected(cells: Sequence[Cell], patterns: Sequence[str], out: Path) -> tuple[Cell, ...]:
    """Return the cells that patterns name, in their order; all where there are no patterns.

    Args:
        cells: all of the experiments.
        patterns: such as "car-*", as shells have them.
        out: the experiments' folder.

    Raises:
        CadetError: a pattern that names none, or a cell that begins with another one's weights, which is neither among
            them nor finished.
    """
    for pattern in patterns:
        if not any(fnmatchcase(cell.name, pattern) for cell in cells):
            raise CadetError(f"--cells {pattern}: names none of {', '.join(cell.name for cell in cells)}")
    chosen = tuple(c for c in cells if not patterns or any(fnmatchcase(c.name, pattern) for pattern in patterns))
    names = {cell.name for cell in chosen}
    by_name = {cell.name: cell for cell in cells}
    for cell in chosen:
        if cell.source is not None and cell.source not in names and not is_finished(out, by_name[cell.source]):
            raise CadetError(
                f"--cells: {cell.name} begins with the weights of {cell.source}, which is not finished: "
                "name that one too, or wait for it"
            )
    return chosen


def run_cells(
    cells: Sequence[Cell], out: Path, sets: Sets, machine: Machine, on_finished: Callable[[str], None]
) -> bool:
    """Run the cells that are not finished, in their order.

    Args:
        cells: of the experiments.
        out: their folder.
        sets: of frames, by name.
        machine: that they run on.
        on_finished: hears the name of each cell that is done.

    Returns:
        Whether all are finished; else it was told to stop.

    Raises:
        CadetError: another process is at work on a cell, or a cell was begun as another one.
    """
    for cell in cells:
        if is_finished(out, cell):
            continue
        with _held(cell_folder(out, cell.name), machine):
            if machine.processes.is_first:
                begin_cell(out, cell)
            machine.processes.any(False)
            if not train_cell(cell, out, sets, machine) or not run_tests(cell, out, sets, machine):
                return False
        if machine.processes.is_first:
            write_results(out)
            on_finished(cell.name)
    return True


def write_results(out: Path) -> str:
    """Write `results.json`, `table.md` and the figures of all that is finished; each whole or not at all.

    Returns:
        The tables.
    """
    groups = grouped(read_outcomes(out))
    text = tables(groups)
    write_note(out / "results.json", {**read_note(out / EXPERIMENT_FILE), "rows": plain_rows(groups)})
    write_whole({out / "table.md": text.encode()})
    for name, figure in (("matrix.png", matrix_figure(groups)), ("few_frames.png", few_frames_figure(groups))):
        if figure is not None:
            write_whole({out / name: png_of(figure)})
    return text


@contextlib.contextmanager
def _held(folder: Path, machine: Machine) -> Iterator[None]:
    """Keep others out of a cell's folder meanwhile."""
    if not machine.processes.is_first:
        yield
        return
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.ExitStack() as held:
        end_s = time.monotonic() + WAIT_S
        while True:
            try:
                held.enter_context(locked_folder(folder, folder / ".lock"))
                break
            except FolderInUseError:
                if time.monotonic() >= end_s:
                    where = f"{folder}: another process is at work on this cell"
                    raise CadetError(f"{where}: choose others by --cells") from None
            time.sleep(0.25)
        yield
