"""Precision over recall, by class, metric and level."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, TypeVar

from cadet._util.summary import summary

METRIC_TITLES: Final[Mapping[str, str]] = {
    "2d": "2D",
    "bev": "BEV",
    "3d": "3D",
    "aos": "AOS",
    "ahs_bev": "AHS BEV",
    "ahs_3d": "AHS 3D",
}
"""The metrics in the order of reports, and what they are called there."""

Value = TypeVar("Value")
ByLevel = Mapping[str, Mapping[str, Mapping[str, Value]]]


@dataclass(frozen=True)
class Curve:
    """Precision over recall of one class, metric and level.

    Attributes:
        precision: 41 values at recall 0, 1/40, ..., 1 made to fall, 0 beyond what was found; for AOS and AHS each true
            positive is worth (1 + cos d) / 2 of its heading's error d. Nothing over nothing is 0.
        scores: the thresholds, falling, at most 41; the last is the lowest score of a true positive.
        num_tp: true positives at each threshold.
        num_fp: false positives at each threshold.
        n_gt: objects that must be found.
        r11: the mean over recall 0, 0.1, ..., 1 in percent.
        r40: the mean over recall 1/40, ..., 1 in percent.
    """

    precision: tuple[float, ...]
    scores: tuple[float, ...]
    num_tp: tuple[int, ...]
    num_fp: tuple[int, ...]
    n_gt: int
    r11: float
    r40: float

    def __repr__(self) -> str:
        return summary(self, f"{len(self.scores)} thresholds", n_gt=self.n_gt, r11=self.r11, r40=self.r40)


def by_level(curves: ByLevel[Curve], value: Callable[[Curve], Value]) -> ByLevel[Value]:
    """Take a value out of each curve."""
    return {
        name: {metric: {level: value(curve) for level, curve in row.items()} for metric, row in metrics.items()}
        for name, metrics in curves.items()
    }
