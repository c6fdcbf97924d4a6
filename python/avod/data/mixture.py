"""Several sets in fixed shares: which set comes when, as a function of seed and place alone."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from avod.data.order import Entry, Order, stream_seed
from cadet._util.checks import as_pairs, as_path, check_number
from cadet.errors import CadetError

Folders = str | Path | Sequence[tuple[str | Path, float]]
"""A KITTI folder, or several, each with its share."""

_BLOCK: Final = 1000
"""Places that hold each set exactly as often as its share says."""


def shares_of(data: Folders) -> tuple[tuple[Path, float], ...]:
    """Return folders with their shares, which sum to 1.

    Raises:
        CadetError: no folder, no number, or a share below a thousandth of the whole.
    """
    if isinstance(data, str | Path):
        return ((as_path("data", data), 1.0),)
    pairs = as_pairs("", "data", data, "(folder, share)")
    if not pairs:
        raise CadetError("data: expected at least one folder, got none")
    for _, share in pairs:
        check_number("", "data: share", share, 0, 1e6)
    total = sum(share for _, share in pairs)
    for folder, share in pairs:
        if not share * _BLOCK >= total > 0.0:
            raise CadetError(f"{folder}: its share {share:g} of {total:g} is less than one in {_BLOCK}")
    return tuple((as_path("data", folder), share / total) for folder, share in pairs)


class Turns:
    """Which of several sets comes when, without end.

    Of every thousand places each set has its share, rounded to whole places; which they are is drawn for each thousand.

    Args:
        shares: of the sets; they sum to 1.
        seed: of the draws.
    """

    def __init__(self, shares: Sequence[float], seed: int) -> None:
        self._counts = _whole(shares)
        self._seed = seed

    def turn(self, index: int) -> tuple[int, int]:
        """Return the set's number at an index, and how often it came before."""
        block, place = divmod(index, _BLOCK)
        number = int(_sets(self._seed, block, self._counts)[place])
        return number, self.before(index, number)

    def before(self, index: int, number: int) -> int:
        """Return how often a set comes before an index."""
        block, place = divmod(index, _BLOCK)
        sets = _sets(self._seed, block, self._counts)
        return block * self._counts[number] + int(np.count_nonzero(sets[:place] == number))


class Mixture:
    """An endless order over several sets, each in epochs of its own.

    Args:
        orders: of the sets.
        shares: of the sets; they sum to 1.
        seed: of the draws.
    """

    def __init__(self, orders: Sequence[Order], shares: Sequence[float], seed: int) -> None:
        self._orders = tuple(orders)
        self._turns = Turns(shares, seed)

    def entry(self, index: int) -> tuple[int, Entry]:
        """Return the set's number and what is read of it at an index, counted from the start of training."""
        number, place = (0, index) if len(self._orders) == 1 else self._turns.turn(index)
        return number, self._orders[number].entry(place)


def set_seed(seed: int, number: int, count: int) -> int:
    """Return the seed of one set's own order: the training's, where it is the only one."""
    return seed if count == 1 else stream_seed(seed, "set", number)


def _whole(shares: Sequence[float]) -> tuple[int, ...]:
    """Round shares to whole places of a block by the largest remainders."""
    places = np.array(shares) * _BLOCK
    counts = np.floor(places + 1e-9).astype(int)
    order = np.argsort(counts - places, kind="stable")
    counts[order[: _BLOCK - int(counts.sum())]] += 1
    return tuple(counts.tolist())


@lru_cache(maxsize=4)
def _sets(seed: int, block: int, counts: tuple[int, ...]) -> NDArray[np.intp]:
    in_turn = np.repeat(np.arange(len(counts)), counts)
    return np.random.default_rng(stream_seed(seed, "mixture", block)).permutation(in_turn)
