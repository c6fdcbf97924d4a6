"""The log of a training: `log.csv`, and TensorBoard's files where it is installed and asked for."""

from __future__ import annotations

import importlib.util
import re
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from torch import Tensor

from cadet.errors import CadetError, MissingFileError
from cadet.kitti.files import write_whole

TERMS: Final = ("objectness", "anchor", "classification", "box", "orientation", "total")
COLUMNS: Final = ("step", "learning_rate", *TERMS, "seconds_per_step")

_NUMBER: Final = re.compile(r"[+-]?\d{1,40}(\.\d{0,40})?(e[+-]?\d{1,3})?", re.ASCII)
_STEP: Final = re.compile(r"\d{1,15}", re.ASCII)
_LARGEST: Final = 3.4028235e38


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
        write_whole({self.path: "".join([_line(COLUMNS), *(_line(_texts(row)) for row in rows)]).encode("ascii")})
        self._board = _board(folder) if has_tensorboard else None

    def on_step(self, step: int, losses: Mapping[str, Tensor], rate: float, *, is_last: bool = False) -> None:
        """Record a step's losses; `step` is how many steps are done, the last one's row is written in any case."""
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
        with self.path.open("a", encoding="ascii") as file:
            file.write(_line(_texts(values)))
        if self._board is not None:
            for name in COLUMNS[1:]:
                self._board.add_scalar(name, values[name], step)
        self._sums, self._count, self._start_s = {}, 0, now_s


def read_log(path: Path) -> list[dict[str, float]]:
    """Read a `log.csv`.

    Raises:
        MissingFileError: no such file.
        CadetError: another header, another number of fields, or one that is no finite number; the line is named.
    """
    if not path.is_file():
        raise MissingFileError(f"{path}: no such file")
    # What stands behind the last end of a line was being written when a training was killed.
    header, *lines = path.read_text(encoding="utf-8", errors="replace").split("\n")
    if header != ",".join(COLUMNS):
        raise CadetError(f"{path}:1: expected the columns {', '.join(COLUMNS)}")
    return [_row(line, f"{path}:{number}") for number, line in enumerate(lines[:-1], start=2)]


def _row(line: str, where: str) -> dict[str, float]:
    fields = line.split(",")
    if len(fields) != len(COLUMNS):
        raise CadetError(f"{where}: expected {len(COLUMNS)} fields, got {len(fields)}")
    row = {}
    for name, text in zip(COLUMNS, fields, strict=True):
        if name == "step" and not _STEP.fullmatch(text):
            raise CadetError(f"{where}: {name}: expected a whole number, got {text[:40]!r}")
        # No larger than float32, as all that is logged: figures add some up.
        if not _NUMBER.fullmatch(text) or abs(float(text)) > _LARGEST:
            raise CadetError(f"{where}: {name}: expected a finite number, got {text[:40]!r}")
        row[name] = float(text)
    return row


def _texts(row: Mapping[str, float]) -> list[str]:
    return [str(int(row[name])) if name == "step" else f"{row[name]:.6g}" for name in COLUMNS]


def _line(fields: Iterable[str]) -> str:
    return ",".join(fields) + "\n"


def _board(folder: Path) -> Any:
    if importlib.util.find_spec("tensorboard") is None:
        raise CadetError("--tensorboard needs tensorboard: pip install tensorboard")
    from torch.utils.tensorboard import SummaryWriter

    return SummaryWriter(folder / "tensorboard")
