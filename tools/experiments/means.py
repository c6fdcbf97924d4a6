"""Outcomes of several seeds, brought together: means, and how sure they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

from scipy import stats

from tools.experiments.outcome import Outcome


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
    """Return the mean and its 95 % interval by Student's t, for one value or more."""
    count = len(values)
    half_width = None if count == 1 else float(stats.t.ppf(0.975, count - 1) * stats.sem(values))
    return Mean(fmean(values), half_width, count)


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

    def gain(self, base: Group, metric: str, level: str, rule: str) -> Mean:
        """Return the mean gain in AP over another group, seed by seed; both have one seed in common at least."""
        mine, theirs = (
            {outcome.seed: outcome.ap[metric][level][rule] for outcome in group.outcomes} for group in (self, base)
        )
        return mean_of([mine[seed] - theirs[seed] for seed in mine if seed in theirs])

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
