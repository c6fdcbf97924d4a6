"""AP of part of the objects: by distance, by LIDAR points in the box, by occlusion."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import as_tuple, check_number, shown
from cadet.errors import CadetError, MissingFileError
from cadet.evaluation.analysis.matching import distances_m
from cadet.evaluation.analysis.scan_points import count_points
from cadet.evaluation.curve import ByLevel
from cadet.evaluation.objects import is_optional
from cadet.evaluation.run import EvalSettings, report_of
from cadet.evaluation.sources import Chosen

EDGES: Final[Mapping[str, tuple[float, ...]]] = {
    "distance": (0.0, 15.0, 30.0, 45.0),
    "points": (0.0, 5.0, 20.0, 100.0, 500.0),
    "occlusion": (0.0, 1.0, 2.0, 3.0),
}
"""What objects may be told apart by, and where the bins begin; the last has no end."""

UNITS: Final[Mapping[str, str]] = {"distance": " m", "points": " points", "occlusion": ""}


@dataclass(frozen=True)
class BinAp:
    """AP of the objects in one bin.

    Attributes:
        low: the bin's objects have at least this.
        high: they have less than this; None in the last bin.
        ap: AP in percent by class, metric and level.
        n_gt: objects that must be found, by class and level.
        best_ap: what a perfect result would get, likewise.
    """

    low: float
    high: float | None
    ap: ByLevel[float]
    n_gt: Mapping[str, Mapping[str, int]]
    best_ap: Mapping[str, Mapping[str, float]]


def check_edges(by: str, edges: object) -> tuple[float, ...]:
    """Return where bins begin.

    Args:
        by: what objects are told apart by, one of `EDGES`.
        edges: rising numbers of at least 0, the last bin's too; None for those of `EDGES`.

    Raises:
        CadetError: an unknown quantity, or numbers that do not rise.
    """
    if by not in EDGES:
        raise CadetError(f"by: unknown {shown(by)}, expected some of {', '.join(EDGES)}")
    if edges is None:
        return EDGES[by]
    values = as_tuple("", f"by[{by!r}]", edges, "numbers")
    for value in values:
        check_number("", f"by[{by!r}]", value, 0)
    if not values or any(low >= high for low, high in itertools.pairwise(values)):
        raise CadetError(f"by[{by!r}]: expected rising numbers, got {shown(values)}")
    return tuple(float(value) for value in values)


def ap_by(
    chosen: Chosen, settings: EvalSettings, by: str, edges: tuple[float, ...], scans: Path | None
) -> tuple[BinAp, ...]:
    """Evaluate bin by bin: objects of other bins may be found but need not.

    A detection that finds nothing is a false positive of the bin in which it lies itself; since it has no occlusion, of
    every bin where objects are told apart by that. Levels then ask for no occlusion.

    Args:
        chosen: the frames, with both sides in memory.
        settings: of the evaluation.
        by: one of `EDGES`.
        edges: where the bins begin.
        scans: the folder that holds `velodyne` and `calib`, for points.

    Raises:
        CadetError: points, but no scans.
    """
    truths, detections = chosen.loaded()
    if by == "occlusion":
        levels = tuple(replace(level, max_occlusion=None) for level in settings.levels)
        settings = replace(settings, levels=levels)
    values, found = _values(chosen, by, scans)
    bins = []
    for low, high in zip(edges, (*edges[1:], np.inf), strict=True):
        is_other = ~((values >= low) & (values < high))
        other_found = np.zeros(len(detections.objects.types), np.bool_)
        if found is not None:
            other_found = ~((found >= low) & (found < high))
        part = replace(
            chosen,
            truths=truths.changed(optional=is_optional(truths.objects) | is_other),
            detections=detections.changed(optional=is_optional(detections.objects) | other_found),
        )
        report = report_of(part, settings)
        n_gt = {name: dict(next(iter(metrics.values()))) for name, metrics in report.n_gt.items()}
        bins.append(BinAp(low, None if high == np.inf else high, report.ap, n_gt, report.best_ap))
    return tuple(bins)


def _values(chosen: Chosen, by: str, scans: Path | None) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Return what each object has, and each detection if that can be said."""
    truths, detections = chosen.loaded()
    if by == "occlusion":
        return truths.objects.occluded.astype(np.float64), None
    if by == "distance":
        return distances_m(truths.objects.boxes_cam), distances_m(detections.objects.boxes_cam)
    if scans is None:
        raise CadetError("by points: the ground truth is not a KITTI folder, so there are no scans to count points in")
    if not (scans / "velodyne").is_dir() or not (scans / "calib").is_dir():
        raise MissingFileError(f"{scans}: no velodyne and calib beside the labels, so no points can be counted")
    counts = count_points(scans, chosen.ids, (truths, detections))
    return counts[0].astype(np.float64), counts[1].astype(np.float64)


def label_of(one: BinAp, by: str) -> str:
    """Name a bin, such as "15-30 m"."""
    if by == "occlusion" and (one.high is None or one.high == one.low + 1):
        return f"{one.low:g}"
    text = f"{one.low:g}+" if one.high is None else f"{one.low:g}-{one.high:g}"
    return text + UNITS[by]


def parse_by(texts: Sequence[str]) -> dict[str, tuple[float, ...] | None]:
    """Read what a command was given: names, each with edges or without, such as `distance=0,20,40`.

    Raises:
        CadetError: an unknown name, or what is not a number.
    """
    parsed: dict[str, tuple[float, ...] | None] = {}
    for text in texts:
        name, has_edges, numbers = text.partition("=")
        edges = None
        if has_edges:
            try:
                edges = tuple(float(number) for number in numbers.split(","))
            except ValueError:
                raise CadetError(f"--by: expected numbers such as {name}=0,20,40, got {text!r}") from None
        parsed[name] = check_edges(name, edges)
    return parsed
