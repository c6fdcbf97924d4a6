"""The logs of a training: `log.csv`, `val.csv`, and TensorBoard's files where it is installed and asked for."""

from __future__ import annotations

import importlib.util
import re
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from torch import Tensor

from cadet._util.user_files import names_file
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.folder import write_whole

TOTAL: Final = "total"
"""The last of the losses, each of which has a column of its name."""

_FIRST: Final = ("step", "learning_rate")
_LAST: Final = "seconds_per_step"
_COUNT: Final = "count"
_NUMBER: Final = re.compile(r"[+-]?\d{1,40}(\.\d{0,40})?(e[+-]?\d{1,3})?", re.ASCII)
_STEP: Final = re.compile(r"\d{1,15}", re.ASCII)
_LARGEST: Final = 3.4028235e38


class _Table:
    """A file of finite numbers that grows row by row; rows past the step that a training goes on from are cut off.

    Args:
        path: of the file.
        columns: of its header, the first of them "step".
        first_step: where training begins or goes on.

    Attributes:
        rows: as they stand in the file.
    """

    def __init__(self, path: Path, columns: tuple[str, ...], first_step: int) -> None:
        self._path, self._columns = path, columns
        rows = read_table(path, columns, is_more_allowed=False) if path.is_file() else []
        self.rows = [row for row in rows if row["step"] <= first_step]
        lines = [",".join(columns) + "\n", *map(self._line, self.rows)]
        write_whole({path: "".join(lines).encode("ascii")})

    def add(self, row: Mapping[str, float]) -> dict[str, float]:
        """Write a row, and return it as it stands in the file."""
        line = self._line(row)
        with names_file(self._path), self._path.open("a", encoding="ascii") as file:
            file.write(line)
        self.rows.append(dict(zip(self._columns, map(float, line.split(",")), strict=True)))
        return self.rows[-1]

    def _line(self, row: Mapping[str, float]) -> str:
        return ",".join(f"{row[name]:.6g}" if name != "step" else f"{row[name]:.0f}" for name in self._columns) + "\n"


class TrainingLog:
    """Means of the losses, a row every few steps.

    Args:
        folder: holds `log.csv`.
        first_step: where training begins or goes on.
        terms: names of the losses, the total last.
        every: steps between two rows.
        pending: what `pending` gave when training stopped between two rows.
        tensorboard: write TensorBoard's files too.

    Raises:
        CadetError: TensorBoard is asked for and not installed.
    """

    def __init__(
        self,
        folder: Path,
        first_step: int,
        terms: tuple[str, ...],
        every: int = 10,
        *,
        pending: Mapping[str, float] | None = None,
        tensorboard: bool = False,
    ) -> None:
        self._table = _Table(folder / "log.csv", (*_FIRST, *terms, _LAST), first_step)
        self._terms = terms
        self._every = every
        self._sums = {name: value for name, value in (pending or {}).items() if name in terms}
        self._count = int((pending or {}).get(_COUNT, 0))
        self._num_timed = 0
        self._start_s = time.monotonic()
        self._board = _board(folder) if tensorboard else None

    def on_step(self, step: int, losses: Mapping[str, Tensor], rate: float, *, is_last: bool = False) -> None:
        """Record a step's losses; `step` is how many steps are done, the last one's row is written in any case.

        A step that was left out has no losses and does not count; a row without any step is left out too.
        """
        if losses:
            for name in self._terms:
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
        values[_LAST] = (now_s - self._start_s) / max(self._num_timed, 1)
        self._table.add(values)
        self.add_scalars(step, {name: value for name, value in values.items() if name != "step"})
        self._sums, self._count, self._num_timed, self._start_s = {}, 0, 0, now_s


@dataclass(frozen=True)
class Validated:
    """What a validation found.

    Attributes:
        losses: means over the frames, by term, "total" among them.
        ap: percent: AP 3D of the second level (Moderate), R40, averaged over the classes; 0 for a class that was never
            found.
        ap_by_class: percent, likewise, by class.
    """

    losses: Mapping[str, float]
    ap: float
    ap_by_class: Mapping[str, float]


class ValidationLog:
    """How a training does on frames that it does not learn from: `val.csv`, a row for each validation.

    Args:
        folder: holds `val.csv`.
        first_step: where training begins or goes on.
        terms: names of the losses, the total last.
        class_names: of the detector.
    """

    def __init__(self, folder: Path, first_step: int, terms: tuple[str, ...], class_names: tuple[str, ...]) -> None:
        columns = ("step", *terms, "ap", *(f"ap_{name}" for name in class_names))
        self._table = _Table(folder / "val.csv", columns, first_step)

    @property
    def steps(self) -> list[int]:
        """The steps after which the training was validated."""
        return [int(row["step"]) for row in self._table.rows]

    def add(self, step: int, found: Validated) -> bool:
        """Write a row, and say whether no earlier one has a higher AP as the file has it."""
        before = [row["ap"] for row in self._table.rows]
        by_class = {f"ap_{name}": value for name, value in found.ap_by_class.items()}
        row = self._table.add({"step": step, **found.losses, "ap": found.ap, **by_class})
        return all(row["ap"] >= other for other in before)


def read_log(path: Path) -> list[dict[str, float]]:
    """Read a `log.csv`.

    Raises:
        MissingFileError: no such file.
        CadetError: another header, another number of fields, or one that is no finite number; the line is named.
    """
    return read_table(path, (*_FIRST, TOTAL, _LAST))


def terms_of(row: Mapping[str, float]) -> tuple[str, ...]:
    """Name the losses of a row of `log.csv`, the total last."""
    return tuple(name for name in row if name not in (*_FIRST, _LAST))


def read_validations(path: Path) -> list[dict[str, float]]:
    """Read a `val.csv`.

    Raises:
        MissingFileError: no such file.
        CadetError: another header, another number of fields, or one that is no finite number; the line is named.
    """
    return read_table(path, ("step", TOTAL, "ap"))


def read_table(path: Path, columns: tuple[str, ...], *, is_more_allowed: bool = True) -> list[dict[str, float]]:
    """Read a table of finite numbers, the first of each row a step.

    Args:
        path: the file.
        columns: that its header has, in this order.
        is_more_allowed: whether it may have others between and behind them.

    Raises:
        MissingFileError: no such file.
        CadetError: another header, another number of fields, or one that is no finite number; the line is named.
    """
    if not path.is_file():
        raise MissingFileError(f"{path}: no such file")
    # What stands behind the last end of a line was being written when a training was killed.
    header, *lines = path.read_text(encoding="utf-8", errors="replace").split("\n")
    names = tuple(header.split(","))
    if tuple(name for name in names if name in columns or not is_more_allowed) != columns:
        raise CadetError(f"{path}:1: expected the columns {', '.join(columns)}")
    return [_row(names, line, f"{path}:{number}") for number, line in enumerate(lines[:-1], start=2)]


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


def _board(folder: Path) -> Any:
    if importlib.util.find_spec("tensorboard") is None:
        raise CadetError("--tensorboard needs tensorboard: pip install tensorboard")
    from torch.utils.tensorboard import SummaryWriter

    return SummaryWriter(folder / "tensorboard")
