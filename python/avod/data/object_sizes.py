"""Objects of other sizes: boxes with the points in them, in the boxes' own frames."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from avod.clusters import mean_sizes
from avod.config import Size
from avod.config.augmentation import AugmentationConfig
from avod.data.augmentation import Augmentation
from cadet.formats.kitti import Label
from cadet.formats.kitti.boxes import points_in_boxes

_SIZES: Final = slice(3, 6)
_HALF, _TWICE = 0.5, 2.0


def size_shifts_m(labels: Iterable[Label], names: Sequence[str], settings: AugmentationConfig) -> tuple[Size, ...]:
    """Return what objects' (l, w, h) lack to the mean sizes that are wanted, class by class; empty if none are.

    A class that has no labels here is not shifted.
    """
    if not settings.object_sizes_lwh_m:
        return ()
    found = mean_sizes(labels, names)
    wanted = dict(zip(names, settings.object_sizes_lwh_m, strict=True))
    shifts = [np.subtract(wanted[name], found.get(name, wanted[name])).tolist() for name in names]
    return tuple((length, width, height) for length, width, height in shifts)


def resize_objects(
    points_cam: NDArray[np.float64],
    boxes_cam: NDArray[np.float64],
    classes: NDArray[np.int64],
    augmentation: Augmentation,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Shift and scale the sizes of objects, and the points in their boxes with them.

    Centers of bottoms and headings stay, so objects stand where they stood. No size is less than half or more than
    twice what it was. A point in two boxes follows the first.

    Args:
        points_cam: (N, 3).
        boxes_cam: (M, 7).
        classes: (M,), 1 for the first class, 0 for what is of none.
        augmentation: says how much.

    Returns:
        Points (N, 3) and boxes (M, 7).
    """
    spread, shifts_m = augmentation.settings.object_scaling, augmentation.size_shifts_m
    if not (spread or shifts_m) or not len(boxes_cam):
        return points_cam, boxes_cam
    sizes = boxes_cam[:, _SIZES]
    wanted = sizes + np.vstack([np.zeros(3), shifts_m])[classes] if shifts_m else sizes
    wanted = wanted * (1.0 + augmentation.stream("sizes").uniform(-spread, spread, sizes.shape))
    factors = np.clip(np.divide(wanted, sizes, out=np.ones_like(sizes), where=sizes > 0.0), _HALF, _TWICE)
    resized = boxes_cam.copy()
    resized[:, _SIZES] *= factors
    points, is_free = points_cam.copy(), np.ones(len(points_cam), np.bool_)
    for box, (length, width, height) in zip(boxes_cam, factors, strict=True):
        inside = _near(points_cam, box)
        inside = inside[is_free[inside]]
        inside = inside[points_in_boxes(points_cam[inside], box[None])[:, 0]]
        is_free[inside] = False
        cos, sin = np.cos(box[6]), np.sin(box[6])
        along = np.array([cos, 0.0, -sin])
        across = np.array([sin, 0.0, cos])
        offset = points_cam[inside] - box[:3]
        local = np.stack([offset @ along * length, offset[:, 1] * height, offset @ across * width], axis=1)
        points[inside] = box[:3] + local @ np.stack([along, np.array([0.0, 1.0, 0.0]), across])
    return points, resized


def _near(points_cam: NDArray[np.float64], box_cam: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the indices of points about a box: few, so that all else is cheap."""
    reach = 0.5 * np.hypot(box_cam[3], box_cam[4]) + 1e-3
    is_near = np.abs(points_cam[:, 0] - box_cam[0]) <= reach
    is_near &= np.abs(points_cam[:, 2] - box_cam[2]) <= reach
    return np.flatnonzero(is_near)
