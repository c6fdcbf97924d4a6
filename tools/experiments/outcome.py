"""What a cell's tests have found, and the files that hold it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cadet.errors import CadetError
from cadet.evaluation import Report
from tools.experiments.cells import Cell
from tools.experiments.record import CELL_FILE, cell_folder, read_note, write_note

METRICS: Final = ("3d", "bev")
RULES: Final = ("r11", "r40")
LEVELS: Final = {
    "kitti": ("Easy", "Moderate", "Hard"),
    "large_small": ("Large", "Small"),
}
"""Names of levels by their set. The paper has the second of its own set, whose labels know no occlusion."""

Numbers = dict[str, dict[str, dict[str, float]]]
"""AP in percent by metric, level, and rule."""


@dataclass(frozen=True)
class Outcome:
    """A test of a cell.

    Attributes:
        class_name: of the cell.
        maps: of the cell.
        trained: "sim", "real", "tuned" or "given".
        frames: how many real frames it learned from; None for all.
        seed: of the training.
        tested: the set it was tested on.
        step: of the checkpoint that was tested.
        num_frames: that it was tested on.
        ap: AP in percent by metric, level and rule; 0 where nothing was found.
    """

    class_name: str
    maps: str
    trained: str
    frames: int | None
    seed: int
    tested: str
    step: int
    num_frames: int
    ap: Numbers


def numbers_of(reports: dict[str, Report], class_name: str) -> Numbers:
    """Take AP out of reports, one for each set of levels; 0 for a class that was never found."""
    found: Numbers = {metric: {} for metric in METRICS}
    for levels, report in reports.items():
        for metric in METRICS:
            curves = report.curves.get(class_name, {}).get(metric, {})
            for level in LEVELS[levels]:
                curve = curves.get(level)
                found[metric][level] = {rule: 0.0 if curve is None else getattr(curve, rule) for rule in RULES}
    return found


def outcome_file(folder: Path, tested: str) -> Path:
    """Name the file of a test of the cell of a folder."""
    return folder / f"test_{tested}.json"


def write_outcome(folder: Path, tested: str, step: int, num_frames: int, ap: Numbers) -> None:
    """Write what a test has found, whole or not at all."""
    write_note(outcome_file(folder, tested), {"step": step, "num_frames": num_frames, "ap": ap})


def is_finished(out: Path, cell: Cell) -> bool:
    """Tell whether all tests of a cell are done."""
    folder = cell_folder(out, cell.name)
    return all(outcome_file(folder, tested).is_file() for tested in cell.tests)


def read_outcomes(out: Path) -> list[Outcome]:
    """Read all tests of a folder of experiments, by the cells' names.

    Raises:
        CadetError: a damaged file.
    """
    return [outcome for path in sorted((out / "cells").glob(f"*/{CELL_FILE}")) for outcome in _outcomes(path)]


def _outcomes(path: Path) -> Iterator[Outcome]:
    cell = read_note(path)
    try:
        for tested in cell["tests"]:
            file = outcome_file(path.parent, tested)
            if file.is_file():
                values = read_note(file)
                yield Outcome(
                    class_name=cell["class"],
                    maps=cell["maps"],
                    trained=cell["trained"],
                    frames=cell["frames"],
                    seed=cell["seed"],
                    tested=tested,
                    step=values["step"],
                    num_frames=values["num_frames"],
                    ap=_checked(values["ap"]),
                )
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise CadetError(f"{path.parent}: damaged: {type(error).__name__}: {error}") from None


def _checked(ap: Any) -> Numbers:
    return {
        metric: {level: {rule: float(rules[rule]) for rule in RULES} for level, rules in ap[metric].items()}
        for metric in METRICS
    }
