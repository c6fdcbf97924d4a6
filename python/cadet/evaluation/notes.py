"""The notes of a report: what a reader should know before comparing its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from cadet.evaluation.curve import METRIC_TITLES, ByLevel, Curve
from cadet.evaluation.limits import METRICS

_NAMES_SHOWN: Final = 5
# A full curve's mean may round below 100.
_FULL: Final = 100.0 - 1e-9


def notes_of(
    classes: tuple[str, ...],
    curves: ByLevel[Curve],
    best: dict[str, dict[str, float]],
    recall: str,
    result: Mapping[str, Any],
    *,
    num_frames: int,
    least_height_px: float,
) -> tuple[str, ...]:
    """Say what a reader should know before comparing numbers.

    Args:
        classes: their names.
        curves: what was found.
        best: AP of a perfect result, by class and level.
        recall: "r40" or "r11".
        result: what the core counted.
        num_frames: frames that were evaluated.
        least_height_px: the least height that any level asks for.
    """
    warnings = []
    for name in classes:
        if name in curves:
            warnings += _class_warnings(name, curves[name], best[name], recall)
        else:
            warnings.append(f"{name}: no usable detection in {num_frames} frames, so it is left out.")
    measured = [metrics for metrics in curves.values() if "2d" in metrics]
    if measured and not any("aos" in metrics for metrics in measured):
        warnings.append("AOS is left out: a detection has alpha -10, unknown.")
    for what, others in (("objects", result["other_truths"]), ("detections", result["other_detections"])):
        if others:
            total, names = sum(count for _, count in others), _names(others)
            warnings.append(f"{total} {what} are of types that KITTI does not have, and take no part: {names}.")
    return (*warnings, *_unseen(result, least_height_px))


def _names(others: Sequence[tuple[str, int]]) -> str:
    """Name types and how many there are of each, the most frequent first."""
    listed = [f"{name} ({count})" for name, count in sorted(others, key=lambda one: (-one[1], one[0]))]
    return ", ".join(listed[:_NAMES_SHOWN] + ["..."] * (len(listed) > _NAMES_SHOWN))


def _unseen(result: Mapping[str, Any], least_height_px: float) -> list[str]:
    """Say how many objects and detections count nothing for want of height in the image, if it may be a mistake."""
    remedy = '--boxes-2d project (boxes_2d="project") makes 2D boxes from 3D boxes and calib'
    notes = []
    if result["num_truths_without_box"]:
        count = f"{result['num_truths_without_box']} of {result['num_own_truths']} objects"
        notes.append(f"{count} have no 2D box (such as 0 0 0 0), so that no level asks for them; {remedy}.")
    low, of_all = result["num_low_detections"], result["num_own_detections"]
    empty = result["num_detections_without_box"]
    if empty or 2 * low > of_all:
        reason = f"less than {least_height_px:g} px high in the image and count nothing"
        without = f"; {empty} have no 2D box (such as 0 0 0 0): {remedy}" if empty else ""
        notes.append(f"{low} of {of_all} detections are {reason}{without}.")
    return notes


def _class_warnings(
    name: str, metrics: Mapping[str, Mapping[str, Curve]], best: dict[str, float], recall: str
) -> list[str]:
    counts = {level: curve.n_gt for level, curve in next(iter(metrics.values())).items()}
    few = [
        f"{name} {level}: only {counts[level]} objects; a perfect result has AP|{recall.upper()} {most:.2f}."
        for level, most in best.items()
        if most < _FULL
    ]
    unmeasured = [
        f"{name}: no detection has what {METRIC_TITLES[metric]} needs, so that is left out."
        for metric in METRICS
        if metric not in metrics
    ]
    return few + unmeasured
