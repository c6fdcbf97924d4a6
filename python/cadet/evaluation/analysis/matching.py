"""Which detection finds which object, by the distance of their centers: independent of size, height and heading.

nuScenes matches so (https://www.nuscenes.org/object-detection): the surest detection of a frame first, each takes the
nearest object that is left, if that lies nearer than a limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.evaluation.classes import EvalClass
from cadet.evaluation.objects import Detections, GroundTruth, is_optional
from cadet.evaluation.packed import Packed

REACH_M: Final = 2.0
"""A detection whose center is nearer to an object's than this has found it: nuScenes' limit for errors of boxes."""

X, Y, Z, L, W, H, RY = range(7)
"""Columns of `boxes_cam`."""

_COVERED_SHARE: Final = 0.5


@dataclass(frozen=True, eq=False)
class Matches:
    """What n detections found.

    Attributes:
        truth: (n,) int64, the object's index, -1 for none.
        distance_m: (n,) from the object's center, seen from above; infinite for none.
        is_near: (n,) whether any object lies within reach, taken by another detection or not.
    """

    truth: NDArray[np.int64]
    distance_m: NDArray[np.float64]
    is_near: NDArray[np.bool_]

    @property
    def is_found(self) -> NDArray[np.bool_]:
        """(n,) whether a detection found an object."""
        return self.truth >= 0


def match_centers(
    truths: Packed[GroundTruth],
    detections: Packed[Detections],
    reach_m: float,
    *,
    is_truth: NDArray[np.bool_],
    is_detection: NDArray[np.bool_],
) -> Matches:
    """Match detections with objects, frame by frame. Of equal scores the first comes first.

    Args:
        truths: the objects.
        detections: the detections.
        reach_m: how near the centers must be.
        is_truth: the objects that may be found.
        is_detection: the detections that may find them.
    """
    count = len(detections.objects.types)
    found = Matches(np.full(count, -1, np.int64), np.full(count, np.inf), np.zeros(count, np.bool_))
    scores = detections.objects.scores
    places, centers = truths.objects.boxes_cam[:, [X, Z]], detections.objects.boxes_cam[:, [X, Z]]
    for frame in range(len(truths)):
        objects = _rows(truths.starts, frame, is_truth)
        own = _rows(detections.starts, frame, is_detection)
        if len(objects) == 0 or len(own) == 0:
            continue
        apart_m = np.hypot(*(centers[own, None] - places[None, objects]).transpose(2, 0, 1))
        found.is_near[own] = apart_m.min(axis=1) < reach_m
        for row in np.argsort(-scores[own], kind="stable"):
            column = int(np.argmin(apart_m[row]))
            if apart_m[row, column] < reach_m:
                found.truth[own[row]], found.distance_m[own[row]] = objects[column], apart_m[row, column]
                apart_m[:, column] = np.inf
    return found


def distances_m(boxes_cam: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far boxes (n, 7) are from the camera, seen from above."""
    return np.hypot(boxes_cam[:, X], boxes_cam[:, Z])


def of_types(objects: Packed[GroundTruth] | Packed[Detections], types: tuple[str, ...]) -> NDArray[np.bool_]:
    """Return which objects are of some types, in any letter case as KITTI compares them."""
    wanted = {name.casefold() for name in types}
    return np.array([name.casefold() in wanted for name in objects.objects.types], np.bool_)


def are_objects(objects: Packed[GroundTruth] | Packed[Detections]) -> NDArray[np.bool_]:
    """Return which are of any type but DontCare."""
    return ~of_types(objects, ("DontCare",))


def must_be_found(truths: Packed[GroundTruth], entry: EvalClass) -> NDArray[np.bool_]:
    """Return which objects of a class must be found at all."""
    return of_types(truths, entry.types) & ~is_optional(truths.objects)


def in_unlabeled_regions(truths: Packed[GroundTruth], detections: Packed[Detections]) -> NDArray[np.bool_]:
    """Return (n,) which detections lie in a DontCare region by more than half of their boxes in the image."""
    boxes = detections.objects.boxes_img.astype(np.float64)
    regions = np.flatnonzero(of_types(truths, ("DontCare",)))
    frames = truths.frames[regions]
    # Each region with each detection of its frame.
    counts = np.diff(detections.starts)[frames]
    pairs_region = np.repeat(regions, counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    pairs_box = np.repeat(detections.starts[frames], counts) + within
    ours, theirs = boxes[pairs_box], truths.objects.boxes_img[pairs_region]
    low, high = np.maximum(ours[:, :2], theirs[:, :2]), np.minimum(ours[:, 2:], theirs[:, 2:])
    shared = np.clip(high - low, 0.0, None).prod(axis=1)
    area = np.clip(ours[:, 2:] - ours[:, :2], 0.0, None).prod(axis=1)
    inside = np.zeros(len(boxes), np.bool_)
    inside[pairs_box[shared > _COVERED_SHARE * area]] = True
    return inside


def _rows(starts: NDArray[np.int64], frame: int, is_wanted: NDArray[np.bool_]) -> NDArray[np.int64]:
    first = int(starts[frame])
    return first + np.flatnonzero(is_wanted[first : starts[frame + 1]])
