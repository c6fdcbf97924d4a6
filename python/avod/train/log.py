"""The log of a training: `log.csv`, and TensorBoard's files where it is installed and asked for."""

from __future__ import annotations

import importlib.util
import re
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from torch import Tensor

from cadet._util.user_files import names_file
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.folder import write_whole

TERMS: Final = ("objectness", "anchor", "classification", "box", "orientation", "total")
COLUMNS: Final = ("step", "learning_rate", *TERMS, "seconds_per_step")

_COUNT: Final = "count"
_NUMBER: Final = re.compile(r"[+-]?\d{1,40}(\.\d{0,40})?(e[+-]?\d{1,3})?", re.ASCII)
_STEP: Final = re.compile(r"\d{1,15}", re.ASCII)
_LARGEST: Final = 3.4028235e38


class TrainingLog:
    """Means of the losses, a row every few steps. Rows past the step that a training goes on from are cut off first.

    Args:
        folder: holds `log.csv`.
        first_step: where training begins or goes on.
        every: steps between two rows.
        pending: what `pending` gave when training stopped between two rows.
        has_tensorboard: write TensorBoard's files too.

    Raises:
        CadetError: TensorBoard is asked for and not installed.
    """

    def __init__(
        self,
        folder: Path,
        first_step: int,
        every: int = 10,
        *,
        pending: Mapping[str, float] | None = None,
        has_tensorboard: bool = False,
    ) -> None:
        self.path = folder / "log.csv"
        self._every = every
        self._sums = {name: value for name, value in (pending or {}).items() if name in TERMS}
        self._count = int((pending or {}).get(_COUNT, 0))
        self._num_timed = 0
        self._start_s = time.monotonic()
        rows = [row for row in read_log(self.path) if row["step"] <= first_step] if self.path.is_file() else []
        write_whole(
            {self.path: "".join([table_line(COLUMNS), *(table_line(_texts(row)) for row in rows)]).encode("ascii")}
        )
        self._board = _board(folder) if has_tensorboard else None

    def on_step(self, step: int, losses: Mapping[str, Tensor], rate: float, *, is_last: bool = False) -> None:
        """Record a step's losses; `step` is how many steps are done, the last one's row is written in any case.

        A step that was left out has no losses and does not count; a row without any step is left out too.
        """
        if losses:
            for name in TERMS:
                self._sums[name] = self._sums.get(name, 0.0) + float(losses[name])
            self._count += 1
            self._num_timed += 1
        if self._count and (step % self._every == 0 or is_last):
            self._write(step, rate)

    @property
    def pending(self) -> dict[str, float]:
        """The sums of the row that is not written yet, for a training that stops here and goes on."""
        return {_COUNT: self._count, **self._sums} if self._count else {}

    def add_scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Hand further numbers to TensorBoard, where it is asked for."""
        if self._board is not None:
            for name, value in values.items():
                self._board.add_scalar(name, value, step)

    def _write(self, step: int, rate: float) -> None:
        now_s = time.monotonic()
        values: dict[str, float] = {"step": step, "learning_rate": rate}
        values |= {name: total / self._count for name, total in self._sums.items()}
        # Of the steps of this process: those before a stop were timed by another.
        values["seconds_per_step"] = (now_s - self._start_s) / max(self._num_timed, 1)
        with names_file(self.path), self.path.open("a", encoding="ascii") as file:
            file.write(table_line(_texts(values)))
        self.add_scalars(step, {name: values[name] for name in COLUMNS[1:]})
        self._sums, self._count, self._num_timed, self._start_s = {}, 0, 0, now_s


def read_log(path: Path) -> list[dict[str, float]]:
    """Read a `log.csv`.

    Raises:
        MissingFileError: no such file.
        CadetError: another header, another number of fields, or one that is no finite number; the line is named.
    """
    return read_table(path, COLUMNS)


def read_table(path: Path, columns: tuple[str, ...], *, is_longer_allowed: bool = False) -> list[dict[str, float]]:
    """Read a table of finite numbers, the first of each row a step.

    Args:
        path: the file.
        columns: of its header.
        is_longer_allowed: whether more columns may follow these.

    Raises:
        MissingFileError: no such file.
        CadetError: another header, another number of fields, or one that is no finite number; the line is named.
    """
    if not path.is_file():
        raise MissingFileError(f"{path}: no such file")
    # What stands behind the last end of a line was being written when a training was killed.
    header, *lines = path.read_text(encoding="utf-8", errors="replace").split("\n")
    names = tuple(header.split(","))
    if names[: len(columns)] != columns or (len(names) > len(columns) and not is_longer_allowed):
        raise CadetError(f"{path}:1: expected the columns {', '.join(columns)}")
    return [_row(names, line, f"{path}:{number}") for number, line in enumerate(lines[:-1], start=2)]


def text_of(name: str, value: float) -> str:
    """Write a number as it stands in a table's column."""
    return str(int(value)) if name == "step" else f"{value:.6g}"


def table_line(fields: Iterable[str]) -> str:
    """Join a row of a table."""
    return ",".join(fields) + "\n"


def _row(names: tuple[str, ...], line: str, where: str) -> dict[str, float]:
    fields = line.split(",")
    if len(fields) != len(names):
        raise CadetError(f"{where}: expected {len(names)} fields, got {len(fields)}")
    row = {}
    for name, text in zip(names, fields, strict=True):
        if name == "step" and not _STEP.fullmatch(text):
            raise CadetError(f"{where}: {name}: expected a whole number, got {text[:40]!r}")
        # No larger than float32, as all that is logged: figures add some up.
        if not _NUMBER.fullmatch(text) or abs(float(text)) > _LARGEST:
            raise CadetError(f"{where}: {name}: expected a finite number, got {text[:40]!r}")
        row[name] = float(text)
    return row


def _texts(row: Mapping[str, float]) -> list[str]:
    return [text_of(name, row[name]) for name in COLUMNS]


def _board(folder: Path) -> Any:
    if importlib.util.find_spec("tensorboard") is None:
        raise CadetError("--tensorboard needs tensorboard: pip install tensorboard")
    from torch.utils.tensorboard import SummaryWriter

    return SummaryWriter(folder / "tensorboard")
