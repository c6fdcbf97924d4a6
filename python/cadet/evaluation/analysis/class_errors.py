"""The errors of a class, side by side."""

from __future__ import annotations

from dataclasses import dataclass

from cadet.evaluation.analysis.box_errors import BandErrors
from cadet.evaluation.analysis.mending import MendedAp
from cadet.evaluation.analysis.operating import OperatingPoint


@dataclass(frozen=True)
class ClassErrors:
    """Where a class loses AP.

    Attributes:
        mended: AP by what would be right.
        operating_point: the best threshold where a center within 2 m is right; None if there is no such detection.
        false_alarms_a_frame: detections of at least its score that are near no object; None without it.
        boxes: the errors of boxes of at least its score, by distance; empty without it.
    """

    mended: MendedAp
    operating_point: OperatingPoint | None
    false_alarms_a_frame: float | None
    boxes: tuple[BandErrors, ...]
