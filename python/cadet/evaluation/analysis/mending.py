"""AP as it would be if one kind of error did not happen: what rises most is the first thing to mend.

Errors of boxes are mended by giving a detection what the object that it found has. The other kinds, and what mending
them means, are those of TIDE (Bolya et al., "TIDE: A General Toolbox for Identifying Object Detection Errors", 2020).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cadet.evaluation.analysis.matching import (
    REACH_M,
    RY,
    H,
    L,
    Matches,
    W,
    X,
    Y,
    Z,
    are_objects,
    in_unlabeled_regions,
    match_centers,
    of_types,
)
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.objects import Detections, GroundTruth, is_optional
from cadet.evaluation.packed import Packed
from cadet.evaluation.run import EvalSettings, report_of
from cadet.evaluation.sources import Chosen

MendedAp: TypeAlias = Mapping[str, Mapping[str, Mapping[str, float]]]
"""AP in percent by what was mended, metric and level."""

AS_IT_IS: Final = "as it is"
MENDED: Final[Mapping[str, str]] = {
    AS_IT_IS: "nothing is corrected",
    "size": "length and width are the object's; the corner nearest to the camera stays",
    "vertical": "height and bottom are the object's",
    "heading": "rotation_y is the object's",
    "size, heading": "size as with the object's heading",
    "place": "the center, seen from above, is the object's",
    "all but place": "size, vertical and heading",
    "whole box": "place and all of these, the observation angle, and the box in the image",
    "class": "the type is that of the object, of whatever class, that lies there",
    "no duplicates": "without detections of an object that a better-scored one has found",
    "no false alarms": "without detections that no object lies near",
    "no misses": "without objects that no detection lies near",
}
"""Each way of mending and what it changes, in the order of reports."""


@dataclass(frozen=True, eq=False)
class _Case:
    """One class of a set: both sides, and which detection found what within 2 m."""

    truths: Packed[GroundTruth]
    detections: Packed[Detections]
    entry: EvalClass
    matches: Matches


def mended_ap(chosen: Chosen, settings: EvalSettings, entry: EvalClass) -> MendedAp:
    """Mend one kind of error after the other and evaluate again.

    Args:
        chosen: the frames, with both sides in memory.
        settings: of the evaluation.
        entry: one of its classes.

    Returns:
        AP by what was mended; a metric in which nothing is detected is left out.
    """
    truths, detections = chosen.loaded()
    may = of_types(truths, (*entry.types, *entry.neighbors))
    own = of_types(detections, entry.types)
    case = _Case(truths, detections, entry, match_centers(truths, detections, REACH_M, is_truth=may, is_detection=own))
    alone = replace(settings, classes=(entry,))
    mended: dict[str, Mapping[str, Mapping[str, float]]] = {}
    for name, mend in _MENDERS.items():
        better_truths, better_detections = mend(case)
        report = report_of(replace(chosen, truths=better_truths, detections=better_detections), alone)
        mended[name] = {
            metric: row for metric, row in report.ap.get(entry.name, {}).items() if metric in ("2d", "bev", "3d")
        }
    return mended


_Sides: TypeAlias = tuple[Packed[GroundTruth], Packed[Detections]]


def _boxes(*parts: str) -> Callable[[_Case], _Sides]:
    def mend(case: _Case) -> _Sides:
        is_found = case.matches.is_found
        boxes_cam = case.detections.objects.boxes_cam.astype(np.float64)
        truth_cam = case.truths.objects.boxes_cam[case.matches.truth[is_found]].astype(np.float64)
        boxes_cam[is_found] = mend_boxes(boxes_cam[is_found], truth_cam, parts)
        return case.truths, case.detections.changed(boxes_cam=boxes_cam)

    return mend


def mend_boxes(
    boxes_cam: NDArray[np.float64], truth_cam: NDArray[np.float64], parts: tuple[str, ...]
) -> NDArray[np.float64]:
    """Give boxes some of what the true ones have, each row from its own.

    Args:
        boxes_cam: (n, 7).
        truth_cam: (n, 7).
        parts: some of "size", "vertical", "heading", "place", in any order.
    """
    mended = boxes_cam.copy()
    if "heading" in parts:
        mended[:, RY] = truth_cam[:, RY]
    if "size" in parts:
        # Seen from the camera a box is anchored at its near faces: the far ones are guessed.
        turn = mended[:, RY]
        axes = ((np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn)))
        for (along_x, along_z), column in zip(axes, (L, W), strict=True):
            side = np.sign(mended[:, X] * along_x + mended[:, Z] * along_z)
            shift = 0.5 * side * (truth_cam[:, column] - mended[:, column])
            mended[:, X] += shift * along_x
            mended[:, Z] += shift * along_z
            mended[:, column] = truth_cam[:, column]
    if "vertical" in parts:
        mended[:, [Y, H]] = truth_cam[:, [Y, H]]
    if "place" in parts:
        mended[:, [X, Z]] = truth_cam[:, [X, Z]]
    return mended


def _whole_boxes(case: _Case) -> _Sides:
    is_found = case.matches.is_found
    columns = {}
    for name in ("boxes_cam", "boxes_img", "alphas"):
        values = getattr(case.detections.objects, name).astype(np.float64)
        values[is_found] = getattr(case.truths.objects, name)[case.matches.truth[is_found]]
        columns[name] = values
    return case.truths, case.detections.changed(**columns)


def _class(case: _Case) -> _Sides:
    everything, known = are_objects(case.truths), are_objects(case.detections)
    found = match_centers(case.truths, case.detections, REACH_M, is_truth=everything, is_detection=known)
    types = case.detections.types.astype(object)
    types[found.is_found] = case.truths.types[found.truth[found.is_found]]
    return case.truths, case.detections.changed(types=tuple(map(str, types)))


def _without(is_dropped: Callable[[_Case], NDArray[np.bool_]]) -> Callable[[_Case], _Sides]:
    def mend(case: _Case) -> _Sides:
        is_own = of_types(case.detections, case.entry.types)
        return case.truths, case.detections.kept(~(is_own & is_dropped(case)))

    return mend


def _without_misses(case: _Case) -> _Sides:
    is_found = np.zeros(len(case.truths.objects.types), np.bool_)
    is_found[case.matches.truth[case.matches.is_found]] = True
    return case.truths.changed(optional=is_optional(case.truths.objects) | ~is_found), case.detections


_MENDERS: Final[Mapping[str, Callable[[_Case], _Sides]]] = {
    AS_IT_IS: _boxes(),
    "size": _boxes("size"),
    "vertical": _boxes("vertical"),
    "heading": _boxes("heading"),
    "size, heading": _boxes("size", "heading"),
    "place": _boxes("place"),
    "all but place": _boxes("size", "vertical", "heading"),
    "whole box": _whole_boxes,
    "class": _class,
    "no duplicates": _without(lambda case: case.matches.is_near & ~case.matches.is_found),
    "no false alarms": _without(lambda case: ~case.matches.is_near),
    "no misses": _without_misses,
}
assert tuple(_MENDERS) == tuple(MENDED)


def false_alarms_a_frame(
    truths: Packed[GroundTruth], detections: Packed[Detections], entry: EvalClass, least_score: float
) -> float:
    """Count a class's detections of at least a score that lie near no object, nor in a DontCare region, a frame."""
    may = of_types(truths, (*entry.types, *entry.neighbors))
    own = of_types(detections, entry.types) & (detections.objects.scores >= least_score)
    matches = match_centers(truths, detections, REACH_M, is_truth=may, is_detection=own)
    is_false = own & ~matches.is_near & ~in_unlabeled_regions(truths, detections)
    return float(is_false.sum()) / max(len(truths), 1)
