"""The log of a training: `log.csv`, and TensorBoard's files where it is installed and asked for."""

from __future__ import annotations

import csv
import importlib.util
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from torch import Tensor

from cadet.errors import CadetError

TERMS: Final = ("objectness", "anchor", "classification", "box", "orientation", "total")
COLUMNS: Final = ("step", "learning_rate", *TERMS, "seconds_per_step")


class TrainingLog:
    """Means of the losses, a row every few steps. Rows past the step that a training goes on from are cut off first.

    Args:
        folder: holds `log.csv`.
        first_step: where training begins or goes on.
        every: steps between two rows.
        has_tensorboard: write TensorBoard's files too.

    Raises:
        CadetError: TensorBoard is asked for and not installed.
    """

    def __init__(self, folder: Path, first_step: int, every: int = 10, *, has_tensorboard: bool = False) -> None:
        self.path = folder / "log.csv"
        self._every = every
        self._sums: dict[str, float] = {}
        self._count = 0
        self._start_s = time.monotonic()
        rows = [row for row in read_log(self.path) if row["step"] <= first_step] if self.path.is_file() else []
        with self.path.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            writer.writerows([_text(name, row[name]) for name in COLUMNS] for row in rows)
        self._board = _board(folder) if has_tensorboard else None

    def on_step(self, step: int, losses: Mapping[str, Tensor], rate: float, *, is_last: bool = False) -> None:
        """Hear of a step's losses; `step` is how many steps are done, the last one's row is written in any case."""
        for name in TERMS:
            self._sums[name] = self._sums.get(name, 0.0) + float(losses[name])
        self._count += 1
        if step % self._every == 0 or is_last:
            self._write(step, rate)

    def _write(self, step: int, rate: float) -> None:
        now_s = time.monotonic()
        values: dict[str, float] = {"step": step, "learning_rate": rate}
        values |= {name: total / self._count for name, total in self._sums.items()}
        values["seconds_per_step"] = (now_s - self._start_s) / self._count
        with self.path.open("a", newline="") as file:
            csv.writer(file).writerow([_text(name, values[name]) for name in COLUMNS])
        if self._board is not None:
            for name in COLUMNS[1:]:
                self._board.add_scalar(name, values[name], step)
        self._sums, self._count, self._start_s = {}, 0, now_s


def read_log(path: Path) -> list[dict[str, float]]:
    """Read a `log.csv`.

    Raises:
        CadetError: another header, or a field that is no number.
    """
    with path.open(newline="") as file:
        reader = csv.DictReader(file)
        if tuple(reader.fieldnames or ()) != COLUMNS:
            raise CadetError(f"{path}: expected the columns {', '.join(COLUMNS)}")
        try:
            return [{name: float(row[name]) for name in COLUMNS} for row in reader]
        except (TypeError, ValueError) as error:
            raise CadetError(f"{path}:{reader.line_num}: {error}") from None


def _text(name: str, value: float) -> str:
    return str(int(value)) if name == "step" else f"{value:.6g}"


def _board(folder: Path) -> Any:
    if importlib.util.find_spec("tensorboard") is None:
        raise CadetError("--tensorboard needs tensorboard: pip install tensorboard")
    from torch.utils.tensorboard import SummaryWriter

    return SummaryWriter(folder / "tensorboard")
