"""Whether one detector is better than another: a paired bootstrap of the difference in AP."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadet.evaluation.analysis.bootstrap import DrawnAp, middle
from cadet.evaluation.analysis.groups import Groups
from cadet.evaluation.curve import METRIC_TITLES, ByLevel
from cadet.evaluation.report import Report

VERDICT_METRIC = "3d"


@dataclass(frozen=True)
class Difference:
    """AP of B less that of A.

    Attributes:
        a: AP of A.
        b: AP of B.
        difference: b - a.
        low: 2.5 % of draws are below.
        high: 97.5 % of draws are below.
        share_better: the share of draws in which B is better; draws without a difference count half.
        n_draws: draws that have an object to find.
    """

    a: float
    b: float
    difference: float
    low: float
    high: float
    share_better: float
    n_draws: int


@dataclass(frozen=True)
class Comparison:
    """Whether B is better than A.

    Attributes:
        num_draws: how often frames were drawn, the same for both.
        seed: of the draws.
        unit: what was drawn.
        num_units: how many there are.
        differences: by class, metric and level; a metric in which one detected nothing counts as 0.
        mean: of AP 3D at the main level, averaged over the classes: what the verdict is about.
        level: the main level.
        verdict: one line.
        report_b: B's own report.
    """

    num_draws: int
    seed: int
    unit: str
    num_units: int
    differences: ByLevel[Difference]
    mean: Difference
    level: str
    verdict: str
    report_b: Report


def compare_draws(
    reports: tuple[Report, Report], drawn: tuple[DrawnAp, DrawnAp], groups: Groups, num_draws: int, seed: int
) -> Comparison:
    """Compare two detectors draw by draw; the frames of a draw are the same for both."""
    level = main_level(reports[0])
    table: dict[str, dict[str, dict[str, Difference]]] = {}
    for entry in reports[0].classes:
        metrics = [set(report.ap.get(entry.name, {})) for report in reports]
        for metric in (metric for metric in METRIC_TITLES if metric in metrics[0] | metrics[1]):
            for name in (one.name for one in reports[0].levels):
                key = (entry.name, metric, name)
                a, b = (_values(report, draws, *key, num_draws) for report, draws in zip(reports, drawn, strict=True))
                table.setdefault(entry.name, {}).setdefault(metric, {})[name] = _difference(a, b)
    keys = [(entry.name, VERDICT_METRIC, level) for entry in reports[0].classes]
    # A class without objects says nothing about either.
    known = [key for key in keys if any(_n_gt(report, key) for report in reports)] or keys
    means = []
    for report, draws in zip(reports, drawn, strict=True):
        sides = [_values(report, draws, *key, num_draws) for key in known]
        means.append((float(np.mean([value for value, _ in sides])), _mean_draws([each for _, each in sides])))
    mean = _difference(means[0], means[1])
    verdict = _verdict(mean, level, len(known), groups, num_draws)
    return Comparison(num_draws, seed, groups.unit, len(groups), table, mean, level, verdict, reports[1])


def main_level(report: Report) -> str:
    """Name the level that one number is given for: the second, Moderate or Small, or the only one."""
    return report.levels[min(1, len(report.levels) - 1)].name


def _values(
    report: Report, drawn: DrawnAp, name: str, metric: str, level: str, num_draws: int
) -> tuple[float, NDArray[np.float64]]:
    value = report.ap.get(name, {}).get(metric, {}).get(level, 0.0)
    return value, drawn.get((name, metric, level), np.zeros(num_draws))


def _n_gt(report: Report, key: tuple[str, str, str]) -> int:
    name, metric, level = key
    return report.n_gt.get(name, {}).get(metric, {}).get(level, 0)


def _mean_draws(each: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Average classes draw by draw; a class that a draw has no object of is left out there."""
    values = np.array(each)
    is_known = ~np.isnan(values)
    count = is_known.sum(axis=0)
    total = np.where(is_known, values, 0.0).sum(axis=0)
    mean: NDArray[np.float64] = np.divide(total, count, out=np.full(len(total), np.nan), where=count > 0)
    return mean


def _difference(a: tuple[float, NDArray[np.float64]], b: tuple[float, NDArray[np.float64]]) -> Difference:
    differences = b[1] - a[1]
    # Both see the same objects, so where one has none to find neither has the other.
    differences = differences[~np.isnan(differences)]
    low, high = middle(differences) if len(differences) else (b[0] - a[0], b[0] - a[0])
    better = (differences > 0.0).sum() + 0.5 * (differences == 0.0).sum()
    share = float(better / len(differences)) if len(differences) else 0.5
    return Difference(a[0], b[0], b[0] - a[0], low, high, share, len(differences))


def _verdict(mean: Difference, level: str, num_classes: int, groups: Groups, num_draws: int) -> str:
    what = f"AP 3D {level}" if num_classes == 1 else f"mean AP 3D {level} of {num_classes} classes"
    numbers = f"{what} {mean.difference:+.2f} (95 %: {mean.low:+.2f} to {mean.high:+.2f})"
    if mean.low > 0.0:
        said = "B is better"
    elif mean.high < 0.0:
        said = "A is better"
    else:
        said = "no difference can be told"
    return f"{said}: {numbers}, B better in {100.0 * mean.share_better:.1f} % of {num_draws} draws of {groups.unit}"
