"""The tables of an analysis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cadet._util.text_tables import aligned, markdown
from cadet.evaluation.analysis.bins import BinAp, label_of
from cadet.evaluation.analysis.bootstrap import Bootstrap
from cadet.evaluation.analysis.box_errors import QUANTITIES, BandErrors, Spread
from cadet.evaluation.analysis.centers import LIMITS_M, CenterAp
from cadet.evaluation.analysis.class_errors import ClassErrors
from cadet.evaluation.analysis.comparison import Comparison
from cadet.evaluation.analysis.confusion import Confusion
from cadet.evaluation.analysis.mending import AS_IT_IS
from cadet.evaluation.analysis.operating import OperatingPoint
from cadet.evaluation.curve import METRIC_TITLES, ByLevel
from cadet.evaluation.report import Report

_SHOWN = ("bev", "3d")
"""The metrics of tables that have no room for more; JSON has all."""
_FULL = 100.0 - 1e-9


@dataclass(frozen=True)
class Section:
    """A table with a title above and a note below.

    Attributes:
        title: what the numbers are.
        rows: the header first.
        note: what a reader must know; empty for nothing.
        num_left: how many columns are names, set to the left.
    """

    title: str
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    num_left: int = 1

    def to_text(self) -> str:
        """Return aligned lines; wider than a terminal rather than cut off."""
        lines = [self.title, *(f"  {line}" for line in aligned(self.rows, self.num_left))]
        return "\n".join([*lines, self.note] if self.note else lines)

    def to_markdown(self) -> str:
        """Return a Markdown table."""
        lines = [f"**{self.title}**", "", *markdown(self.rows, self.num_left)]
        return "\n".join([*lines, "", self.note, ""] if self.note else [*lines, ""])


def operating_table(points: ByLevel[OperatingPoint], level: str) -> Section:
    """Tabulate the best thresholds of a level."""
    rows: list[tuple[str, ...]] = [("Class", "Metric", "score >=", "precision", "recall", "F1")]
    for name, metrics in points.items():
        for metric, by_level in metrics.items():
            if level in by_level:
                p = by_level[level]
                shares = (f"{100.0 * share:.1f}" for share in (p.precision, p.recall, p.f1))
                rows.append((name, METRIC_TITLES[metric], f"{p.score:.3f}", *shares))
    return Section(f"Best operating point, {level}, percent", tuple(rows), num_left=2)


def mended_table(name: str, errors: ClassErrors, report: Report, level: str) -> Section:
    """Tabulate a class's AP without one kind of error after another."""
    base = errors.mended[AS_IT_IS]
    rows: list[tuple[str, ...]] = [
        ("If this were right", *(text for metric in _SHOWN for text in (METRIC_TITLES[metric], "change")))
    ]
    for what, metrics in errors.mended.items():
        cells = []
        for metric in _SHOWN:
            value, before = (side.get(metric, {}).get(level, 0.0) for side in (metrics, base))
            cells += [f"{value:.2f}", "" if what == AS_IT_IS else f"{value - before:+.2f}"]
        rows.append((what, *cells))
    limits = report.min_overlap[name]
    overlaps = "/".join(f"{limits[metric]:g}" for metric in _SHOWN)
    note = ""
    if errors.operating_point is not None:
        p = errors.operating_point
        note = (
            f"Within 2 m: best at scores of {p.score:.3f}: precision {100.0 * p.precision:.1f}, recall "
            f"{100.0 * p.recall:.1f}, {errors.false_alarms_a_frame:.2f} false alarms a frame."
        )
    return Section(f"{name}: AP if one kind of error were corrected, {level}, overlap > {overlaps}", tuple(rows), note)


def boxes_table(name: str, errors: ClassErrors) -> Section:
    """Tabulate the errors of a class's boxes by distance."""
    bands = [band for band in errors.boxes if band.n_objects > 0]
    rows: list[tuple[str, ...]] = [
        ("", *(_band(band) for band in bands)),
        ("found", *(f"{band.n} of {band.n_objects}" for band in bands)),
    ]
    for quantity in QUANTITIES:
        digits = 1 if quantity.endswith("deg") else 2
        cells = [_spread(band.errors[quantity], digits) if band.errors else "" for band in bands]
        what, _, unit = quantity.rpartition("_")
        rows.append((f"{what} [{unit}]", *cells))
    rows.append(("reversed", *(str(band.n_reversed) for band in bands)))
    return Section(f"{name}: found minus true, median (16 to 84 %) by distance", tuple(rows))


def _spread(spread: Spread, digits: int) -> str:
    # Adding 0 turns -0 to 0.
    median, p16, p84 = (f"{round(v, digits) + 0.0:+.{digits}f}" for v in (spread.median, spread.p16, spread.p84))
    return f"{median} ({p16} to {p84})"


def _band(band: BandErrors) -> str:
    return f"{band.from_m:g}+ m" if band.to_m is None else f"{band.from_m:g}-{band.to_m:g} m"


def bins_table(by: str, bins: tuple[BinAp, ...], report: Report, level: str) -> Section:
    """Tabulate AP bin by bin."""
    rows: list[tuple[str, ...]] = [("Class", by, "objects", *(METRIC_TITLES[metric] for metric in _SHOWN), "perfect")]
    for name in report.ap:
        for one in bins:
            n_gt = one.n_gt.get(name, {}).get(level, 0)
            metrics = one.ap.get(name, {})
            values = [f"{metrics[metric][level]:.2f}" if n_gt and metric in metrics else "-" for metric in _SHOWN]
            best = one.best_ap.get(name, {}).get(level, 0.0)
            rows.append((name, label_of(one, by), str(n_gt), *values, f"{best:.2f}" if n_gt and best < _FULL else ""))
    note = "Perfect: what a perfect result has, where objects are too few for 100."
    if by == "occlusion":
        note += " False positives have no occlusion and count in every row."
    what = f"{level} without its limit of occlusion" if by == "occlusion" else level
    return Section(f"AP by {by}, {what}", tuple(rows), note, num_left=2)


def confusion_table(found: Confusion) -> Section:
    """Tabulate which class is taken for which."""
    columns = list(next(iter(found.counts.values()), {}))
    rows: list[tuple[str, ...]] = [("There / found as", *columns)]
    for name, counts in found.counts.items():
        rows.append((name, *(str(counts[column]) if counts[column] else "." for column in columns)))
    least = ", ".join(f"{name} {score:.3f}" for name, score in found.least_scores.items())
    note = f"Centers within 2 m; scores of at least: {least}." if least else "Centers within 2 m."
    return Section("Confusion, objects", tuple(rows), note)


def centers_table(centers: Mapping[str, CenterAp]) -> Section:
    """Tabulate nuScenes' AP and errors."""
    limits = [f"{limit:g}" for limit in LIMITS_M]
    rows: list[tuple[str, ...]] = [
        ("Class", *(f"AP {limit} m" for limit in limits), "mean", "ATE m", "ASE", "AOE rad", "objects")
    ]
    for name, found in centers.items():
        errors = (f"{value:.3f}" for value in (found.ate_m, found.ase, found.aoe_rad))
        values = (*(found.ap[limit] for limit in limits), found.mean_ap)
        rows.append((name, *(f"{value:.2f}" for value in values), *errors, str(found.n_gt)))
    return Section("nuScenes' AP in percent by distance of centers, and errors of what was found", tuple(rows))


def intervals_table(found: Bootstrap) -> Section:
    """Tabulate AP with its intervals."""
    levels = list(next(iter(next(iter(found.ap.values())).values()))) if found.ap else []
    rows: list[tuple[str, ...]] = [("Class", "Metric", *levels)]
    for name, metrics in found.ap.items():
        for metric, by_level in metrics.items():
            cells = [f"{i.value:.2f} ({i.low:.2f} to {i.high:.2f})" for i in by_level.values()]
            rows.append((name, METRIC_TITLES[metric], *cells))
    title = f"AP (95 % interval) of {found.num_draws} draws of {found.num_units} {found.unit}, seed {found.seed}"
    return Section(title, tuple(rows), num_left=2)


def comparison_table(found: Comparison) -> Section:
    """Tabulate the differences between two sets of detections."""
    rows: list[tuple[str, ...]] = [("Class", "Metric", "A", "B", "B - A", "95 % interval", "B better")]
    for name, metrics in found.differences.items():
        for metric, by_level in metrics.items():
            d = by_level[found.level]
            interval = f"{d.low:+.2f} to {d.high:+.2f}"
            share = f"{100.0 * d.share_better:.1f} %"
            values = (f"{d.a:.2f}", f"{d.b:.2f}", f"{d.difference:+.2f}")
            rows.append((name, METRIC_TITLES[metric], *values, interval, share))
    title = f"A against B, AP {found.level}, {found.num_draws} draws of {found.num_units} {found.unit}"
    return Section(title, tuple(rows), f"Verdict: {found.verdict}", num_left=2)
