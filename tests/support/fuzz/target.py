"""What reads damaged input."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass

Input = str | bytes


@dataclass(frozen=True)
class Target:
    """Something that reads: `read` gets what `make` makes, and returns or raises a CadetError."""

    name: str
    make: Callable[[random.Random], Input]
    read: Callable[[Input], object]
