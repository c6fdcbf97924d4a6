"""Means over seeds, and how sure they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

MAX_SEEDS: Final = 31

# Student's t at 0.975, for 1 to 30 degrees of freedom.
_T: Final = (
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
    2.201, 2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
    2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
)  # fmt: skip


@dataclass(frozen=True)
class Mean:
    """A mean over seeds.

    Attributes:
        value: the mean.
        half_width: of the 95 % interval of the mean; None for a single seed.
        count: how many seeds.
    """

    value: float
    half_width: float | None
    count: int

    def __str__(self) -> str:
        return f"{self.value:.2f}" if self.half_width is None else f"{self.value:.2f} ±{self.half_width:.2f}"


def mean_of(values: Sequence[float]) -> Mean:
    """Return the mean and its 95 % interval by Student's t, for 1 to `MAX_SEEDS` values."""
    count = len(values)
    mean = math.fsum(values) / count
    if count == 1:
        return Mean(mean, None, 1)
    variance = math.fsum((value - mean) ** 2 for value in values) / (count - 1)
    return Mean(mean, _T[count - 2] * math.sqrt(variance / count), count)
