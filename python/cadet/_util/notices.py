"""What users should know and can do without: warnings, each said once a process."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Hashable, Iterable

from cadet.errors import CadetWarning

_PACKAGE = __name__.split(".")[0]
_said: set[tuple[str, Hashable]] = set()


def notice(lines: Iterable[str], about: Hashable, *, key: str | None = None) -> None:
    """Warn with each line, at the place outside of cadet that led here, unless it was said of the same thing before.

    Args:
        lines: the warnings.
        about: what they speak of.
        key: what makes two lines the same; the line itself where it is None.
    """
    for line in lines:
        said = (line if key is None else key, about)
        if said not in _said:
            _said.add(said)
            warnings.warn(line, CadetWarning, stacklevel=_level_outside())


def _level_outside() -> int:
    """Return the stack level, as `notice` counts it, of the first caller outside of this package."""
    level, frame = 1, sys._getframe(1)
    # By the module's name, since the constructors that dataclasses write have no file.
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).split(".")[0] == _PACKAGE:
        level, frame = level + 1, frame.f_back
    return level
