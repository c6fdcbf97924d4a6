"""Overlaps of oriented boxes, and suppression of the lesser ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadet import _cadet
from cadet._util.arrays import as_array
from cadet._util.checks import check_number
from cadet.errors import CadetError

_LENGTH, _HEIGHT = 3, 6


def box_iou_bev(a: ArrayLike, b: ArrayLike) -> NDArray[np.float64]:
    """Compute the intersection over union of each pair of boxes, seen from above.

    Exact up to rounding in double precision, at any heading: equal boxes give 1, parallel edges are no special case.

    Args:
        a: (n, 7) [x, y, z, l, w, h, rotation_y], bottom center in the cam frame, meters and radians. May be
            empty, or a list of such rows.
        b: (m, 7) likewise.

    Returns:
        (n, m) float64 in [0, 1]; 0 where a box has no area.

    Raises:
        ShapeError: not (n, 7).
        NonFiniteError: NaN or infinity.
        CadetError: a negative size.
    """
    return _cadet.box_iou(_boxes(a, "a"), _boxes(b, "b"), False)


def box_iou_3d(a: ArrayLike, b: ArrayLike) -> NDArray[np.float64]:
    """Compute the intersection over union of each pair of boxes' volumes; a box reaches from y - h up to y.

    Args:
        a: (n, 7) [x, y, z, l, w, h, rotation_y], bottom center in the cam frame, meters and radians. May be
            empty, or a list of such rows.
        b: (m, 7) likewise.

    Returns:
        (n, m) float64 in [0, 1]; 0 where a box has no volume.

    Raises:
        ShapeError: not (n, 7).
        NonFiniteError: NaN or infinity.
        CadetError: a negative size.
    """
    return _cadet.box_iou(_boxes(a, "a"), _boxes(b, "b"), True)


def nms_bev(boxes: ArrayLike, scores: ArrayLike, threshold: float) -> NDArray[np.int64]:
    """Keep the boxes that no kept box of higher score overlaps by more than a threshold, seen from above.

    Args:
        boxes: (n, 7) [x, y, z, l, w, h, rotation_y], cam frame. May be empty.
        scores: (n,), higher is better; of equal scores the first is better.
        threshold: intersection over union, 0..1.

    Returns:
        (k,) int64, the indices of the kept boxes, best first.

    Raises:
        ShapeError: not (n, 7) and (n,).
        NonFiniteError: NaN or infinity.
        CadetError: a negative size, or a threshold outside 0..1.
    """
    check_number("", "threshold", threshold, 0, 1)
    checked = _boxes(boxes, "boxes")
    by_score = as_array(scores, "scores", (len(checked),), finite=True).astype(np.float64)
    return _cadet.nms_bev(checked, by_score, float(threshold))


def _boxes(boxes: ArrayLike, name: str) -> NDArray[np.float64]:
    checked = as_array(boxes, name, ("n", 7), finite=True).astype(np.float64)
    sizes = checked[:, _LENGTH:_HEIGHT]
    if (sizes < 0.0).any():
        row = int(np.flatnonzero((sizes < 0.0).any(axis=1))[0])
        raise CadetError(f"{name}[{row}]: l, w, h are {sizes[row].tolist()}, expected none below 0")
    return checked
