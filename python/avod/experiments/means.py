"""Outcomes of several seeds, brought together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from avod.experiments.outcome import Outcome
from avod.experiments.statistics import Mean, mean_of


@dataclass(frozen=True)
class Group:
    """Outcomes that differ in their seed alone.

    Attributes:
        class_name: that was to be found.
        maps: of the bird's-eye view.
        trained: "sim", "real", "tuned" or "given".
        frames: how many real frames were learned from; None for all.
        tested: the set.
        outcomes: by seed.
    """

    class_name: str
    maps: str
    trained: str
    frames: int | None
    tested: str
    outcomes: tuple[Outcome, ...]

    def ap(self, metric: str, level: str, rule: str) -> Mean:
        """Return the mean AP in percent."""
        return mean_of([outcome.ap[metric][level][rule] for outcome in self.outcomes])

    @property
    def has_levels(self) -> frozenset[str]:
        """The levels that all outcomes have."""
        return frozenset.intersection(*(frozenset(outcome.ap["3d"]) for outcome in self.outcomes))


def grouped(outcomes: Sequence[Outcome]) -> list[Group]:
    """Bring the seeds together, in the order in which their groups come first."""
    groups: dict[tuple[str, str, str, int | None, str], list[Outcome]] = {}
    for item in sorted(outcomes, key=lambda item: item.seed):
        key = (item.class_name, item.maps, item.trained, item.frames, item.tested)
        groups.setdefault(key, []).append(item)
    return [Group(*key, tuple(items)) for key, items in groups.items()]
