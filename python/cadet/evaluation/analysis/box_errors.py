"""The systematic errors of boxes: by how much what was found differs from what is there."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.evaluation.analysis.matching import (
    REACH_M,
    RY,
    H,
    L,
    W,
    X,
    Y,
    Z,
    distances_m,
    match_centers,
    must_be_found,
    of_types,
)
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.objects import Detections, GroundTruth
from cadet.evaluation.packed import Packed

BANDS_M: Final = (0.0, 15.0, 30.0, 45.0, np.inf)
"""Limits of the bands of distance."""

QUANTITIES: Final = ("along_m", "across_m", "away_m", "bottom_m", "length_m", "width_m", "height_m", "heading_deg")
"""Found minus true: the center along and across the object's heading and away from the camera, the bottom (down is
positive), the sizes, and the heading, where the wrong way round counts as right."""


@dataclass(frozen=True)
class Spread:
    """The middle of differences, and where two thirds of them lie.

    Attributes:
        median: the median.
        p16: 16 % are below.
        p84: 84 % are below.
    """

    median: float
    p16: float
    p84: float


@dataclass(frozen=True)
class BandErrors:
    """The errors of one class in a band of distance.

    Attributes:
        from_m: objects are at least this far from the camera.
        to_m: they are nearer than this; None for the last band.
        n_objects: how many there are.
        n: how many of them were found.
        n_reversed: how many of them the wrong way round: headings more than 90 degrees off.
        errors: by quantity; empty where nothing was found.
    """

    from_m: float
    to_m: float | None
    n_objects: int
    n: int
    n_reversed: int
    errors: dict[str, Spread]


def box_errors(
    truths: Packed[GroundTruth], detections: Packed[Detections], entry: EvalClass, least_score: float
) -> tuple[BandErrors, ...]:
    """Compare the boxes of a class with those of the objects that they found, within 2 m.

    Args:
        truths: the objects.
        detections: the detections.
        entry: the class; its neighbors may be found, but say nothing about errors.
        least_score: of detections.
    """
    own = of_types(detections, entry.types) & (detections.objects.scores >= least_score)
    may = of_types(truths, (*entry.types, *entry.neighbors))
    matches = match_centers(truths, detections, REACH_M, is_truth=may, is_detection=own)
    is_used = matches.is_found.copy()
    must = must_be_found(truths, entry)
    is_used[matches.is_found] = must[matches.truth[matches.is_found]]
    truth_cam = truths.objects.boxes_cam[matches.truth[is_used]]
    rows, is_reversed = differences(truth_cam, detections.objects.boxes_cam[is_used])
    distance_m, of_all_m = (distances_m(boxes_cam) for boxes_cam in (truth_cam, truths.objects.boxes_cam[must]))
    bands = []
    for low, high in itertools.pairwise(BANDS_M):
        inside = (distance_m >= low) & (distance_m < high)
        quantiles = np.percentile(rows[inside], (50, 16, 84), axis=0).T if inside.any() else ()
        errors = {name: Spread(*map(float, values)) for name, values in zip(QUANTITIES, quantiles, strict=False)}
        limit = None if high == np.inf else high
        n_objects = int(((of_all_m >= low) & (of_all_m < high)).sum())
        bands.append(BandErrors(low, limit, n_objects, int(inside.sum()), int(is_reversed[inside].sum()), errors))
    return tuple(bands)


def differences(
    truth_cam: NDArray[np.float64], found_cam: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Take pairs of boxes apart.

    Returns:
        (n, 8) as in `QUANTITIES`, and (n,) whether the heading is the wrong way round.
    """
    dx, dz = found_cam[:, X] - truth_cam[:, X], found_cam[:, Z] - truth_cam[:, Z]
    cos, sin = np.cos(truth_cam[:, RY]), np.sin(truth_cam[:, RY])
    distance_m = np.maximum(distances_m(truth_cam), 1e-9)
    turn_deg = np.degrees(found_cam[:, RY] - truth_cam[:, RY])
    folded_deg = (turn_deg + 90.0) % 180.0 - 90.0
    whole_deg = (turn_deg + 180.0) % 360.0 - 180.0
    rows = np.column_stack(
        [
            dx * cos - dz * sin,
            dx * sin + dz * cos,
            (dx * truth_cam[:, X] + dz * truth_cam[:, Z]) / distance_m,
            *(found_cam[:, column] - truth_cam[:, column] for column in (Y, L, W, H)),
            folded_deg,
        ]
    )
    return rows, np.abs(whole_deg) > 90.0
