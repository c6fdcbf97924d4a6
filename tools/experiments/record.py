"""What experiments and cells were begun with, in files of their folder. Going on with anything else is refused.

OUT/experiment.json            scale, steps, sets of frames
OUT/cells/NAME/cell.json       all that the cell's numbers follow from
OUT/cells/NAME/run/            its training: run.json, log.csv, checkpoints
OUT/cells/NAME/kept/           checkpoints that other trainings go on from
OUT/cells/NAME/best/           the checkpoint that counts
OUT/cells/NAME/detections_*/   KITTI's result files on a set's validation frames
OUT/cells/NAME/test_*.json     AP on them
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from avod.config.tables import differences
from cadet._util.plain_text import json_from_text
from cadet.errors import CadetError
from cadet.formats.kitti.files.folder import write_whole
from tools.experiments.cells import Cell
from tools.experiments.scales import Scale
from tools.experiments.sets import Sets

_FORMAT: Final = "avod-paper"
_VERSION: Final = 1
EXPERIMENT_FILE: Final = "experiment.json"
CELL_FILE: Final = "cell.json"


def cell_folder(out: Path, name: str) -> Path:
    """Name the folder of a cell."""
    return out / "cells" / name


def begin_experiment(out: Path, scale: Scale, steps: int | None, sets: Sets, *, is_written: bool = True) -> None:
    """Note what experiments are begun with, or compare it with what they were begun with.

    Args:
        out: their folder.
        scale: their size.
        steps: of a training from scratch, None for the scale's own.
        sets: of frames, by name; one that is not there is no difference.
        is_written: write the note where there is none.

    Raises:
        CadetError: another scale, length, or set of frames; it is named with both values.
    """
    values: dict[str, Any] = {
        "scale": scale.name,
        "steps": steps,
        "sets": {name: item.describe() for name, item in sets.items()},
    }
    path = out / EXPERIMENT_FILE
    if path.is_file():
        old = read_note(path)
        known = old.get("sets")
        values["sets"] = {**(known if isinstance(known, dict) else {}), **values["sets"]}
        _check_same(out, old, values)
        if old == values:
            return
    if is_written:
        write_note(path, values)


def begin_cell(out: Path, cell: Cell, *, is_written: bool = True) -> None:
    """Note what a cell is begun with, or compare it with what it was begun with.

    Args:
        out: the experiments' folder.
        cell: the cell.
        is_written: write the note where there is none.

    Raises:
        CadetError: it is another cell; what differs is named with both values.
    """
    path, values = cell_folder(out, cell.name) / CELL_FILE, cell.describe()
    if path.is_file():
        _check_same(path.parent, read_note(path), values)
    elif is_written:
        write_note(path, values)


def read_note(path: Path) -> dict[str, Any]:
    """Read one of the experiments' own files.

    Raises:
        CadetError: a damaged one, or one of another version.
    """
    table = json_from_text(path.read_bytes(), str(path))
    if not isinstance(table, dict) or table.pop("format", None) != _FORMAT:
        raise CadetError(f"{path}: not a file of the experiments")
    version = table.pop("version", None)
    if version != _VERSION:
        raise CadetError(f"{path}: version {version!r}, expected {_VERSION}")
    return table


def write_note(path: Path, values: Mapping[str, Any]) -> None:
    """Write one of the experiments' own files, whole or not at all."""
    table = {"format": _FORMAT, "version": _VERSION, **values}
    write_whole({path: (json.dumps(table, indent=1, allow_nan=False) + "\n").encode("ascii")})


def _check_same(folder: Path, old: dict[str, Any], new: dict[str, Any]) -> None:
    # JSON has no tuples.
    for name, was, now in differences(old, json.loads(json.dumps(new))):
        if was is None and name.startswith("sets."):
            continue
        raise CadetError(
            f"{folder}: begun with {name} = {was!r}, and is to go on with {now!r}: name a new folder with --out"
        )
