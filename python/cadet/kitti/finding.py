"""What the lint says about a dataset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

Severity = Literal["error", "warning"]


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a dataset.

    Attributes:
        file: the file, relative to the folder that holds `calib`, or to the dataset's root.
        line: the line from 1; None where the file as a whole is meant.
        message: what is wrong, with the value and what was expected.
        severity: "error", or "warning" for what human-made labels get away with.
    """

    file: str
    line: int | None
    message: str
    severity: Severity = "error"

    def __str__(self) -> str:
        where = self.file if self.line is None else f"{self.file}:{self.line}"
        return f"{where}: {self.severity}: {self.message}"


class Problem(NamedTuple):
    """What is wrong with a file that the caller knows: see `Finding`."""

    line: int | None
    message: str
    severity: Severity = "error"
