"""Numbers are held to the limits that their fields state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import pytest

from cadet._util.checks import Limits, check_fields
from cadet.errors import CadetError


@dataclass(frozen=True)
class Settings:
    share: Annotated[float, Limits(0, 1)] = 1
    keep: Annotated[int | None, Limits(2)] = None
    sizes: Annotated[tuple[tuple[float, float], ...], Limits(-1, 1)] = ()
    free: float = 1e300


def test_numbers_are_held_to_the_limits_of_their_fields() -> None:
    for name, good, bad, expected in (
        ("share", 0.0, None, "a number from 0 to 1, got None"),
        ("keep", 10**9, 2.5, "a whole number of at least 2, got 2.5"),
        ("sizes", ((-1, 1), (0.5, 0)), ((0.0, 0.0), (0.0, 1.1)), "a number from -1 to 1, got 1.1"),
    ):
        check_fields(Settings(**{name: good}))  # type: ignore[arg-type]
        for owner in (None, "mine"):
            with pytest.raises(CadetError, match=f"^{owner or 'Settings'}.{name}: expected {expected}$"):
                check_fields(Settings(**{name: bad}), owner)  # type: ignore[arg-type]
