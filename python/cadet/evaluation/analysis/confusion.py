"""Which class is taken for which, what is missed, and what is found where nothing is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cadet.evaluation.analysis.matching import REACH_M, are_objects, in_unlabeled_regions, match_centers, of_types
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.objects import Detections, GroundTruth, is_optional
from cadet.evaluation.packed import Packed
from cadet.formats.kitti.label import TYPES, kitti_spelling

BACKGROUND = "background"
MISSED = "missed"


@dataclass(frozen=True)
class Confusion:
    """How often what is there was found as what.

    Attributes:
        counts: by the true type, or "background", and by the detected type, or "missed". Types that do not occur are
            left out. Nothing counts where background is missed.
        least_scores: what detections of each type had to reach: the best operating point of their class within 2 m;
            all detections of other types count.
    """

    counts: Mapping[str, Mapping[str, int]]
    least_scores: Mapping[str, float]


def confusion(
    truths: Packed[GroundTruth],
    detections: Packed[Detections],
    classes: tuple[EvalClass, ...],
    least_scores: Mapping[str, float],
) -> Confusion:
    """Match all types with all types by the distance of centers, within 2 m, and count.

    What is found in a region that nobody labeled does not count, nor do optional objects and what finds them.

    Args:
        truths: the objects.
        detections: the detections.
        classes: the classes that were evaluated.
        least_scores: by class; one without has no true positive, and all its detections count.
    """
    by_type = {
        name: least_scores[entry.name]
        for entry in reversed(classes)
        for name in entry.types
        if entry.name in least_scores
    }
    is_sure = np.ones(len(detections.objects.types), np.bool_)
    for name, least in by_type.items():
        is_sure &= ~of_types(detections, (name,)) | (detections.objects.scores >= least)
    is_known = are_objects(detections) & is_sure
    is_object = are_objects(truths)
    matches = match_centers(truths, detections, REACH_M, is_truth=is_object, is_detection=is_known)
    optional = is_optional(truths.objects)
    in_region = in_unlabeled_regions(truths, detections)
    names = dict.fromkeys(map(kitti_spelling, (*TYPES, *sorted({*truths.objects.types, *detections.objects.types}))))
    # Letter case tells no types apart.
    spelled = {name.casefold(): name for name in reversed(names)}
    there = [spelled[name.casefold()] for name in truths.objects.types]
    found = [spelled[name.casefold()] for name in detections.objects.types]
    counts: dict[tuple[str, str], int] = {}
    is_missed = is_object & ~optional
    for index in np.flatnonzero(is_known):
        truth = int(matches.truth[index])
        if truth >= 0:
            is_missed[truth] = False
        if optional[truth] if truth >= 0 else in_region[index]:
            continue
        pair = (there[truth] if truth >= 0 else BACKGROUND, found[index])
        counts[pair] = counts.get(pair, 0) + 1
    for truth in np.flatnonzero(is_missed).tolist():
        counts[there[truth], MISSED] = counts.get((there[truth], MISSED), 0) + 1
    rows = [name for name in (*names, BACKGROUND) if any(row == name for row, _ in counts)]
    columns = [name for name in (*names, MISSED) if any(column == name for _, column in counts)]
    table = {row: {column: counts.get((row, column), 0) for column in columns} for row in rows}
    return Confusion(table, by_type)
