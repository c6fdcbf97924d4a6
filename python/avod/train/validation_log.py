"""How a training does on frames that it does not learn from: `val.csv`, a row for each validation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from avod.train.log import TERMS, read_table, table_line, text_of
from cadet._util.user_files import names_file
from cadet.errors import CadetError
from cadet.formats.kitti.files.folder import write_whole

_FIRST: Final = ("step", *TERMS, "ap")


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
    """`val.csv`. Rows past the step that a training goes on from are cut off first.

    Args:
        folder: holds `val.csv`.
        first_step: where training begins or goes on.
        class_names: of the detector.
    """

    def __init__(self, folder: Path, first_step: int, class_names: tuple[str, ...]) -> None:
        self.path = folder / "val.csv"
        self._columns = (*_FIRST, *(f"ap_{name}" for name in class_names))
        rows = read_validations(self.path) if self.path.is_file() else []
        self._rows = [row for row in rows if row["step"] <= first_step]
        for row in self._rows:
            if tuple(row) != self._columns:
                raise CadetError(f"{self.path}: expected the columns {', '.join(self._columns)}")
        text = "".join(table_line(self._texts(row)) for row in self._rows)
        write_whole({self.path: (table_line(self._columns) + text).encode("ascii")})

    @property
    def steps(self) -> list[int]:
        """The steps after which the training was validated."""
        return [int(row["step"]) for row in self._rows]

    def add(self, step: int, found: Validated) -> bool:
        """Write a row, and say whether no earlier one has a higher AP."""
        row = {"step": step, **found.losses, "ap": found.ap}
        row |= {f"ap_{name}": value for name, value in found.ap_by_class.items()}
        is_best = all(float(f"{found.ap:.6g}") >= other["ap"] for other in self._rows)
        self._rows.append({name: float(row[name]) for name in self._columns})
        with names_file(self.path), self.path.open("a", encoding="ascii") as file:
            file.write(table_line(self._texts(self._rows[-1])))
        return is_best

    def _texts(self, row: Mapping[str, float]) -> list[str]:
        return [text_of(name, row[name]) for name in self._columns]


def read_validations(path: Path) -> list[dict[str, float]]:
    """Read a `val.csv`.

    Raises:
        MissingFileError: no such file.
        CadetError: another header, another number of fields, or one that is no finite number; the line is named.
    """
    return read_table(path, _FIRST, is_longer_allowed=True)
