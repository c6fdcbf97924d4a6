"""Other programs' dialects of KITTI's formats: read where the meaning is clear, and said.

A reader that accepts what KITTI would write otherwise calls `accept`. `cadet check` collects these as findings;
everywhere else the first of each kind is a warning, once a process.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Final

from cadet._util.notices import notice


@dataclass(frozen=True)
class Dialect:
    """Something that was read though KITTI writes it otherwise.

    Attributes:
        kind: which kind of thing, such as "calib-imu-key": the same for every file that has it.
        message: what was found and how it was read.
        file: the file's name for messages.
        line: the line from 1; None where the file as a whole is meant.
    """

    kind: str
    message: str
    file: str
    line: int | None = None

    def __str__(self) -> str:
        where = self.file if self.line is None else f"{self.file}:{self.line}"
        return f"{where}: {self.message}"


_Key = tuple[str, str, str]
_collected: Final[ContextVar[tuple[list[Dialect], set[_Key]] | None]] = ContextVar("_collected", default=None)


def accept(kind: str, message: str, file: str, line: int | None = None) -> None:
    """Record that a dialect was read: in the list of `collected`, or as a warning, the first of its kind alone.

    A message that comes again in the same file, such as on each of its lines, is recorded once.
    """
    found = Dialect(kind, message, file, line)
    collecting = _collected.get()
    if collecting is None:
        notice([str(found)], about="dialect", key=kind)
        return
    dialects, seen = collecting
    if (kind, message, file) not in seen:
        seen.add((kind, message, file))
        dialects.append(found)


@contextmanager
def collected() -> Iterator[list[Dialect]]:
    """Gather the dialects that are read meanwhile in place of warning of them."""
    found: list[Dialect] = []
    token = _collected.set((found, set()))
    try:
        yield found
    finally:
        _collected.reset(token)
