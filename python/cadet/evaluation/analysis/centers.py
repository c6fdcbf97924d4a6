"""nuScenes' average precision by the distance of centers, and its errors of matched boxes.

The rules are those of the nuScenes detection task (https://www.nuscenes.org/object-detection; Caesar et al., CVPR 2020,
section 3.1); what KITTI's labels ask for besides is in `docs/evaluation.md`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

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
    Z,
    distances_m,
    in_unlabeled_regions,
    match_centers,
    must_be_found,
    of_types,
)
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.objects import Detections, GroundTruth
from cadet.evaluation.packed import Packed
from cadet.formats.kitti.boxes import wrap_angle

LIMITS_M: Final = (0.5, 1.0, 2.0, 4.0)
"""How near centers must be: AP is computed for each and averaged."""
_RANGES_M: Final = {"Pedestrian": 40.0, "Person_sitting": 40.0, "Cyclist": 40.0} | {
    "bicycle": 40.0,
    "motorcycle": 40.0,
    "barrier": 30.0,
    "traffic_cone": 30.0,
}
_FAR_M: Final = 50.0
_MIN_RECALL, _MIN_PRECISION = 0.1, 0.1
_RECALLS: Final = np.linspace(0.0, 1.0, 101)
_FIRST: Final = round(100 * _MIN_RECALL) + 1


@dataclass(frozen=True)
class CenterAp:
    """What nuScenes' rules say about a class.

    Attributes:
        ap: AP in percent by the distance in meters that centers must be within.
        mean_ap: their mean.
        ate_m: mean distance of the centers of what was found, seen from above.
        ase: mean of 1 - IoU of the boxes laid over one another.
        aoe_rad: mean difference of headings, 0 to pi.
        n_gt: objects that must be found.
        n_detections: detections that count.
        range_m: how far objects and detections count.

    The three errors are those of matches within 2 m, averaged over recall above 0.1; 1 where that is not reached.
    """

    ap: dict[str, float]
    mean_ap: float
    ate_m: float
    ase: float
    aoe_rad: float
    n_gt: int
    n_detections: int
    range_m: float


@dataclass(frozen=True, eq=False)
class _Ranked:
    """A class's detections, surest first, without those that are neither right nor wrong."""

    scores: NDArray[np.float64]
    truth: NDArray[np.int64]
    index: NDArray[np.int64]
    n_gt: int

    def curve(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return recall and precision down the ranking."""
        num_tp = np.cumsum(self.truth >= 0)
        return num_tp / self.n_gt, num_tp / np.arange(1, len(num_tp) + 1)


def center_ap(truths: Packed[GroundTruth], detections: Packed[Detections], entry: EvalClass) -> CenterAp | None:
    """Compute nuScenes' AP and errors of a class; None where there is no object to find within range."""
    range_m = max(_RANGES_M.get(name, _FAR_M) for name in entry.types)
    ranked = {limit_m: ranked_by_center(truths, detections, entry, limit_m, range_m) for limit_m in LIMITS_M}
    n_gt = ranked[REACH_M].n_gt
    if n_gt == 0:
        return None
    ap = {f"{limit_m:g}": 100.0 * _average_precision(ranking) for limit_m, ranking in ranked.items()}
    ate_m, ase, aoe_rad = _errors(ranked[REACH_M], truths.objects.boxes_cam, detections.objects.boxes_cam)
    return CenterAp(
        ap=ap,
        mean_ap=float(np.mean(list(ap.values()))),
        ate_m=ate_m,
        ase=ase,
        aoe_rad=aoe_rad,
        n_gt=n_gt,
        n_detections=len(ranked[REACH_M].scores),
        range_m=range_m,
    )


def ranked_by_center(
    truths: Packed[GroundTruth],
    detections: Packed[Detections],
    entry: EvalClass,
    limit_m: float,
    range_m: float = np.inf,
) -> _Ranked:
    """Match a class's detections, leave out those that are neither right nor wrong, and rank the others."""
    is_truth_near = is_within(truths.objects.boxes_cam, range_m)
    must = must_be_found(truths, entry) & is_truth_near
    own = of_types(detections, entry.types) & is_within(detections.objects.boxes_cam, range_m)
    may = of_types(truths, (*entry.types, *entry.neighbors)) & is_truth_near
    matches = match_centers(truths, detections, limit_m, is_truth=may, is_detection=own)
    counts = own & ~_is_excused(matches, must, in_unlabeled_regions(truths, detections))
    index = np.flatnonzero(counts)
    index = index[np.argsort(-detections.objects.scores[index], kind="stable")]
    return _Ranked(detections.objects.scores[index].astype(np.float64), matches.truth[index], index, int(must.sum()))


def is_within(boxes_cam: NDArray[np.float64], range_m: float) -> NDArray[np.bool_]:
    """Return which boxes' centers are nearer to the camera than a range, seen from above."""
    return distances_m(boxes_cam) < range_m


def _is_excused(matches: Matches, must: NDArray[np.bool_], is_in_region: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which detections found what need not be found, or found nothing in a region that nobody labeled."""
    found_optional = matches.is_found.copy()
    found_optional[matches.is_found] = ~must[matches.truth[matches.is_found]]
    return found_optional | (~matches.is_found & is_in_region)


def _average_precision(ranked: _Ranked) -> float:
    """Average precision above 0.1 over recall above 0.1, stretched to 0..1."""
    if len(ranked.scores) == 0:
        return 0.0
    recall, precision = ranked.curve()
    sampled = np.interp(_RECALLS, recall, precision, right=0.0)[_FIRST:]
    return float(np.clip(sampled - _MIN_PRECISION, 0.0, None).mean() / (1.0 - _MIN_PRECISION))


def _errors(
    ranked: _Ranked, boxes_cam: NDArray[np.float64], found_cam: NDArray[np.float64]
) -> tuple[float, float, float]:
    is_found = ranked.truth >= 0
    if not is_found.any():
        return 1.0, 1.0, 1.0
    recall, _ = ranked.curve()
    # Scores at even steps of recall, then what the mean error was when the ranking had come down to that score.
    reached = _RECALLS[: int(np.searchsorted(_RECALLS, recall[-1], side="right"))]
    if len(reached) <= _FIRST:
        return 1.0, 1.0, 1.0
    at_scores = np.interp(reached, recall, ranked.scores)[_FIRST:]
    scores = ranked.scores[is_found]
    each = box_differences(boxes_cam[ranked.truth[is_found]], found_cam[ranked.index[is_found]])
    means = [np.cumsum(values) / np.arange(1, len(values) + 1) for values in each]
    ate_m, ase, aoe_rad = (float(np.interp(at_scores[::-1], scores[::-1], mean[::-1]).mean()) for mean in means)
    return ate_m, ase, aoe_rad


def box_differences(
    truth_cam: NDArray[np.float64], found_cam: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Compare pairs of boxes.

    Returns:
        (n,) each: distance of the centers from above in meters, 1 - IoU of boxes laid over one another, difference of
        headings from 0 to pi.
    """
    apart_m = np.hypot(found_cam[:, X] - truth_cam[:, X], found_cam[:, Z] - truth_cam[:, Z])
    sizes, others = truth_cam[:, [L, W, H]], found_cam[:, [L, W, H]]
    shared = np.minimum(sizes, others).prod(axis=1)
    union = sizes.prod(axis=1) + others.prod(axis=1) - shared
    scale = 1.0 - np.divide(shared, union, out=np.zeros_like(shared), where=union > 0.0)
    turn_rad = np.abs(wrap_angle(found_cam[:, RY] - truth_cam[:, RY]))
    return apart_m, scale, turn_rad
