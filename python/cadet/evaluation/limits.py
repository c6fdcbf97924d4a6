"""Classes, and how far a detection must overlap an object to find it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from cadet._util.checks import shown
from cadet.errors import CadetError
from cadet.formats.kitti.label import TYPES, is_object_type, kitti_spelling

METRICS: Final = ("2d", "bev", "3d")
"""How overlap is measured: boxes in the image, seen from above, volumes."""

HEADING: Final[Mapping[str, str]] = {"2d": "aos", "bev": "ahs_bev", "3d": "ahs_3d"}
"""The heading similarity that goes with each metric."""

CLASSES: Final = ("Car", "Pedestrian", "Cyclist")
"""The classes that KITTI evaluates."""

MIN_OVERLAP: Final[Mapping[str, Mapping[str, tuple[float, float, float]]]] = {
    "strict": {"Car": (0.7, 0.7, 0.7), "Pedestrian": (0.5, 0.5, 0.5), "Cyclist": (0.5, 0.5, 0.5)},
    "loose": {"Car": (0.7, 0.5, 0.5), "Pedestrian": (0.5, 0.25, 0.25), "Cyclist": (0.5, 0.25, 0.25)},
}
"""Sets of limits by name: 2D, BEV and 3D of each class. "strict" is KITTI's own."""

ClassOverlap: TypeAlias = float | Sequence[float] | Mapping[str, float]
MinOverlap: TypeAlias = str | Mapping[str, ClassOverlap]


def resolve_limits(classes: Sequence[str], min_overlap: MinOverlap) -> dict[str, tuple[float, float, float]]:
    """Find the limits of each class.

    Args:
        classes: types of labels.
        min_overlap: "strict", "loose", or a dictionary that gives a class one limit, three (2D, BEV, 3D), or a
            dictionary by metric; classes and metrics that it leaves out take the strict limits.

    Returns:
        2D, BEV and 3D limit of each class.

    Raises:
        CadetError: no name of a class, an unknown set, a class for which KITTI sets no limit, a limit outside
            0 <= limit < 1.
    """
    for name in classes:
        if not is_object_type(name):
            raise CadetError(f"classes: expected types of labels such as Car, got {shown(name)}")
    if isinstance(min_overlap, str):
        if min_overlap not in MIN_OVERLAP:
            names = ", ".join(MIN_OVERLAP)
            raise CadetError(f"min_overlap: unknown set {shown(min_overlap)}, expected one of {names}, or a dictionary")
        given: Mapping[str, ClassOverlap] = MIN_OVERLAP[min_overlap]
    else:
        if not isinstance(min_overlap, Mapping):
            names = ", ".join(MIN_OVERLAP)
            raise CadetError(f"min_overlap: expected one of {names}, or a dictionary, got {shown(min_overlap)}")
        given = {kitti_spelling(name) if isinstance(name, str) else name: limit for name, limit in min_overlap.items()}
        for name in given:
            if name not in TYPES and name not in classes:
                raise CadetError(f"min_overlap: {shown(name)} is not one of the classes {', '.join(classes)}")
    strict = MIN_OVERLAP["strict"]
    return {name: class_limits(f"min_overlap[{name!r}]", given.get(name, {}), strict.get(name)) for name in classes}


def class_limits(
    owner: str, given: ClassOverlap, strict: tuple[float, float, float] | None
) -> tuple[float, float, float]:
    """Check the limits of one class.

    Args:
        owner: whose limits they are, for messages.
        given: one limit, three (2D, BEV, 3D), or a dictionary by metric.
        strict: takes the place of metrics that the dictionary leaves out; None where all must be there.

    Raises:
        CadetError: not three limits with 0 <= limit < 1.
    """
    if isinstance(given, Mapping):
        values = _by_metric(owner, given, strict)
    elif isinstance(given, (list, tuple)):
        values = list(given)
        if len(values) != len(METRICS):
            raise CadetError(f"{owner}: expected 3 limits (2D, BEV, 3D), got {len(values)}")
    else:
        values = [given] * len(METRICS)
    for value in values:
        is_number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
        if not is_number or not 0.0 <= value < 1.0:
            raise CadetError(f"{owner}: {shown(value)} is not a limit, expected 0 <= limit < 1")
    return float(values[0]), float(values[1]), float(values[2])


def _by_metric(owner: str, given: Mapping[str, float], strict: tuple[float, float, float] | None) -> list[Any]:
    unknown = [metric for metric in given if metric not in METRICS]
    if unknown:
        raise CadetError(f"{owner}: unknown metric {unknown[0]!r}, expected some of {', '.join(METRICS)}")
    missing = [metric for metric in METRICS if metric not in given]
    if missing and strict is None:
        raise CadetError(f"{owner}: no limit for {missing[0]}, and KITTI sets none; give one, such as 0.7")
    return [given[metric] if strict is None or metric in given else strict[i] for i, metric in enumerate(METRICS)]
