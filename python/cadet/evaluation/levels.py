"""Levels of difficulty: which objects must be found."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from cadet._util.checks import as_tuple, check_flag, check_number, check_text, make_plain, shown
from cadet.errors import CadetError

# KITTI's mark for "unknown" is -1.
_LOWEST: Final = 10.0


@dataclass(frozen=True)
class Level:
    """Limits of what must be found. Finding a harder object is neither right nor wrong, nor is a lower detection.

    Attributes:
        name: the level's name in reports.
        min_height_px: least height of the 2D box in pixels.
        inclusive: whether an object of exactly the least height belongs to the level. In KITTI it does not; a detection
            of exactly the least height always counts.
        max_occlusion: the largest occlusion level; None, which infinity becomes, for no limit.
        max_truncation: the largest truncation, None likewise.

    Raises:
        CadetError: an empty name, a negative or infinite height, NaN, or what is not a number.
    """

    name: str
    min_height_px: float
    inclusive: bool = False
    max_occlusion: float | None = None
    max_truncation: float | None = None

    def __post_init__(self) -> None:
        check_text("Level", "name", self.name)
        if not self.name:
            raise CadetError("level: its name is empty")
        owner = f"level {self.name}"
        check_number(owner, "min_height_px", self.min_height_px, 0)
        check_flag(owner, "inclusive", self.inclusive)
        make_plain(self)
        for name in ("max_occlusion", "max_truncation"):
            value = getattr(self, name)
            if isinstance(value, float) and value == math.inf:
                object.__setattr__(self, name, None)
            elif value is not None:
                check_number(owner, name, value, -_LOWEST)

    def limits(self) -> tuple[float, bool, float, float]:
        """Return the limits as the core takes them."""
        occlusion = math.inf if self.max_occlusion is None else float(self.max_occlusion)
        truncation = math.inf if self.max_truncation is None else float(self.max_truncation)
        return float(self.min_height_px), bool(self.inclusive), occlusion, truncation


LEVELS: Final[Mapping[str, tuple[Level, ...]]] = {
    "kitti": (
        Level("Easy", 40.0, max_occlusion=0, max_truncation=0.15),
        Level("Moderate", 25.0, max_occlusion=1, max_truncation=0.30),
        Level("Hard", 25.0, max_occlusion=2, max_truncation=0.50),
    ),
    "large_small": (Level("Large", 40.0, inclusive=True), Level("Small", 25.0, inclusive=True)),
}
"""The sets of levels by name: KITTI's, and that of labels without occlusion and truncation, "Small" with the large."""


def resolve_levels(levels: str | Sequence[Level]) -> tuple[Level, ...]:
    """Return the levels that a name stands for, or those given.

    Raises:
        CadetError: an unknown name, no level, a name twice, something that is no `Level`.
    """
    if isinstance(levels, str):
        if levels not in LEVELS:
            raise CadetError(
                f"levels: unknown set {shown(levels)}, expected one of {', '.join(LEVELS)}, or Level objects"
            )
        return LEVELS[levels]
    chosen = as_tuple("", "levels", levels, "Level objects")
    for level in chosen:
        if not isinstance(level, Level):
            raise CadetError(f"levels: expected Level objects, got {type(level).__name__}")
    names = [level.name for level in chosen]
    if not names or len(set(names)) < len(names):
        raise CadetError(f"levels: expected at least one, each name once, got {names}")
    return chosen
