"""Random draws of the reset policy that are the same on every machine and with every NumPy.

NumPy promises that its bit generators keep their streams, not that its distributions do, and those call the
platform's logarithm. So numbers are made here from the raw bits, with additions and multiplications alone.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

T = TypeVar("T")


class Draws:
    """A random stream named by (seed, episode, attempt, name), never drawn in turn with another.

    Args:
        seed: the dataset's seed, at least 0.
        episode: the episode, at least 0.
        attempt: how often the world was redrawn inside the episode.
        name: what the stream is for.
    """

    def __init__(self, seed: int, episode: int, attempt: int, name: str) -> None:
        words = [seed, episode, attempt, zlib.crc32(name.encode())]
        self._bits = np.random.PCG64(np.random.SeedSequence(words))

    def unit(self) -> float:
        """Return a number in [0, 1), a multiple of 2**-53."""
        return (int(self._bits.random_raw()) >> 11) * 2.0**-53

    def between(self, low: float, high: float) -> float:
        """Return a number in [low, high), rounded to 1e-6 so that it reads well in metadata."""
        return round(low + (high - low) * self.unit(), 6)

    def count(self, low: int, high: int) -> int:
        """Return a whole number from low to high, both included."""
        return low + int(self.unit() * (high - low + 1))

    def bell(self) -> float:
        """Return a number of mean 0 and standard deviation 1 from a bell that ends at 2.45: the sum of two draws."""
        return (self.unit() + self.unit() - 1.0) * math.sqrt(6.0)

    def weighted(self, items: Sequence[tuple[T, float]]) -> T:
        """Return one of the items, each with its weight; weights need not add up to 1."""
        left = self.unit() * sum(weight for _, weight in items)
        for item, weight in items:
            left -= weight
            if left < 0.0:
                return item
        return items[-1][0]
