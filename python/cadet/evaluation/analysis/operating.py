"""The threshold of scores at which a detector balances misses and false alarms best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadet.evaluation.analysis.centers import ranked_by_center
from cadet.evaluation.analysis.matching import REACH_M
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.curve import Curve
from cadet.evaluation.objects import Detections, GroundTruth
from cadet.evaluation.packed import Packed


@dataclass(frozen=True)
class OperatingPoint:
    """The threshold with the best F1, the harmonic mean of precision and recall.

    Attributes:
        score: detections with this score or a higher one are kept.
        precision: the share of them that is right.
        recall: the share of objects that are found.
        f1: 2 precision recall / (precision + recall).
        n_tp: true positives.
        n_fp: false positives.
    """

    score: float
    precision: float
    recall: float
    f1: float
    n_tp: int
    n_fp: int


def best_of_curve(curve: Curve) -> OperatingPoint | None:
    """Choose among KITTI's thresholds, at most 41, by KITTI's counts; None where nothing was found."""
    counts = zip(curve.scores, curve.num_tp, curve.num_fp, strict=True)
    points = [_point(score, tp, fp, curve.n_gt) for score, tp, fp in counts if tp > 0]
    return max(points, key=lambda point: point.f1, default=None)


def best_by_center(
    truths: Packed[GroundTruth], detections: Packed[Detections], entry: EvalClass
) -> OperatingPoint | None:
    """Choose among all scores, where a detection is right that is within 2 m of an object; None if none is."""
    ranked = ranked_by_center(truths, detections, entry, REACH_M)
    num_tp = np.cumsum(ranked.truth >= 0)
    if len(num_tp) == 0 or num_tp[-1] == 0:
        return None
    # Equal scores come in together.
    is_last = np.append(np.diff(ranked.scores) != 0.0, True)
    f1 = np.where(is_last, 2.0 * num_tp / (np.arange(1, len(num_tp) + 1) + ranked.n_gt), -1.0)
    best = int(np.argmax(f1))
    return _point(float(ranked.scores[best]), int(num_tp[best]), best + 1 - int(num_tp[best]), ranked.n_gt)


def _point(score: float, n_tp: int, n_fp: int, n_gt: int) -> OperatingPoint:
    return OperatingPoint(
        score=score,
        precision=n_tp / (n_tp + n_fp),
        recall=n_tp / n_gt,
        f1=2.0 * n_tp / (n_tp + n_fp + n_gt),
        n_tp=n_tp,
        n_fp=n_fp,
    )
