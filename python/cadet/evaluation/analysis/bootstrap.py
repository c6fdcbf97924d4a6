"""How far AP would scatter from one set of frames to the next: percentile intervals of a bootstrap.

Groups of frames are drawn with replacement, as many as there are, and evaluated again (Efron and Tibshirani, "An
Introduction to the Bootstrap", 1993, chapters 13 and 8.6 for data in groups).
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet.evaluation.analysis.groups import Groups
from cadet.evaluation.curve import METRIC_TITLES, ByLevel
from cadet.evaluation.limits import HEADING, METRICS
from cadet.evaluation.report import Report
from cadet.evaluation.run import EvalSettings
from cadet.evaluation.sources import Chosen

SHARE: Final = 0.95
"""How much of the draws an interval holds."""
FEW_GROUPS: Final = 10
"""With fewer groups an interval is too narrow to be trusted."""

DrawnAp = Mapping[tuple[str, str, str], NDArray[np.float64]]
"""AP in each draw by class, metric and level; NaN where a draw has nothing to find."""


@dataclass(frozen=True)
class Interval:
    """A value and where it lies in the middle 95 % of draws.

    Attributes:
        value: of all frames.
        low: 2.5 % of draws are below.
        high: 97.5 % of draws are below.
        n_draws: draws that have an object to find; the others say nothing.
    """

    value: float
    low: float
    high: float
    n_draws: int


@dataclass(frozen=True)
class Bootstrap:
    """Intervals of AP.

    Attributes:
        num_draws: how often frames were drawn.
        seed: of the draws.
        unit: what was drawn: "frames", "episodes" or "groups".
        num_units: how many there are.
        ap: intervals by class, metric and level.
    """

    num_draws: int
    seed: int
    unit: str
    num_units: int
    ap: ByLevel[Interval]


def draw_frames(groups: Groups, num_draws: int, seed: int) -> tuple[list[int], NDArray[np.uint32]]:
    """Draw groups with replacement.

    Returns:
        Where each draw begins and the end, and the frames' indices, one draw after the other.
    """
    # From raw bits, which NumPy keeps as they are, as all draws of this package.
    words = [seed, zlib.crc32(b"bootstrap")]
    raw = np.random.PCG64(np.random.SeedSequence(words)).random_raw(num_draws * len(groups))
    chosen = ((raw >> np.uint64(11)).astype(np.float64) * 2.0**-53 * len(groups)).astype(np.int64)
    lengths = np.array([len(members) for members in groups.members], np.int64)
    per_draw = lengths[chosen].reshape(num_draws, -1).sum(axis=1)
    starts = np.concatenate([[0], np.cumsum(per_draw)])
    # All members of the drawn groups, without a loop over draws.
    flat = np.concatenate(groups.members)
    firsts = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    counts = lengths[chosen]
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    frames = flat[np.repeat(firsts[chosen], counts) + within]
    return starts.tolist(), frames.astype(np.uint32)


def drawn_ap(chosen: Chosen, settings: EvalSettings, draws: tuple[Sequence[int], NDArray[np.uint32]]) -> DrawnAp:
    """Evaluate each draw."""
    raw_curves: list[dict[str, Any]] = _cadet.evaluate_draws(*chosen.sources(), **settings.core(), draws=draws)
    column = 1 if settings.recall == "r40" else 0
    drawn = {}
    for raw in raw_curves:
        metric, level = METRICS[raw["metric"]], settings.levels[raw["level"]].name
        name = settings.classes[raw["class"]].name
        for key, values in ((metric, raw["ap"]), (HEADING[metric], raw["heading"])):
            if values is not None:
                drawn[name, key, level] = values[:, column]
    return drawn


def intervals(report: Report, drawn: DrawnAp, groups: Groups, num_draws: int, seed: int) -> Bootstrap:
    """Take intervals from draws."""
    found: dict[str, dict[str, dict[str, Interval]]] = {}
    for name, metrics in report.ap.items():
        for metric in (metric for metric in METRIC_TITLES if metric in metrics):
            for level, value in metrics[metric].items():
                values = drawn[name, metric, level]
                values = values[~np.isnan(values)]
                low, high = middle(values) if len(values) else (value, value)
                row = found.setdefault(name, {}).setdefault(metric, {})
                row[level] = Interval(value, low, high, len(values))
    return Bootstrap(num_draws, seed, groups.unit, len(groups), found)


def middle(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return what bounds the middle 95 % of values."""
    low, high = np.percentile(values, (50.0 * (1.0 - SHARE), 50.0 * (1.0 + SHARE)))
    return float(low), float(high)
