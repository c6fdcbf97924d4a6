"""Objects cut out of a labeled frame."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from cadet.datasets.object_bank.object import BankObject
from cadet.datasets.object_bank.silhouette import (
    is_solid,
    refined_silhouette,
    silhouette_from_instances,
    silhouette_from_points,
)
from cadet.errors import CadetError
from cadet.formats.kitti import Label
from cadet.formats.kitti.boxes import corners_cam, points_in_boxes
from cadet.formats.kitti.frame import Frame

MIN_POINTS: Final = 20
"""Objects with fewer points are left where they are."""

_MIN_HEIGHT_PX: Final = 25.0
"""KITTI's own limit for objects that are easy to see is 40, and 25 for all others."""
_MOST_TRUNCATED: Final = 0.01
_MIN_PIXELS: Final = 100
_SLENDER: Final = ("Pedestrian", "Person_sitting", "Cyclist", "Misc")
"""Their outlines have gaps of their own."""


def cut_objects(
    frame: Frame, types: Collection[str], source: str, *, min_points: int = MIN_POINTS
) -> Iterator[BankObject]:
    """Yield the objects of a frame that are seen whole: not occluded, not cut off, with enough points.

    The silhouette is the instance map's where the frame has one, else the convex hull of the object's points,
    stretched to fill the label's rectangle and refined by colors.

    Args:
        frame: with labels, and an instance map or none.
        types: of the labels.
        source: names the frame.
        min_points: objects with fewer are left out.

    Raises:
        CadetError: a calibration that is no camera's.
    """
    points_cam = frame.calib.points_cam_from_velo(frame.points_velo)
    is_ahead = points_cam[:, 2] > 0.0
    points_cam, intensity = points_cam[is_ahead], frame.points_velo[is_ahead, 3]
    for label in frame.labels:
        if label.type not in types or not _is_seen_whole(label):
            continue
        inside = points_in_boxes(points_cam, label.box_cam[None])[:, 0]
        if np.count_nonzero(inside) < min_points:
            continue
        found = _cut(frame, label, points_cam[inside], intensity[inside], source)
        if found is not None:
            yield found


def _is_seen_whole(label: Label) -> bool:
    left, top, right, bottom = label.bbox
    is_whole = label.occluded == 0 and 0.0 <= label.truncated <= _MOST_TRUNCATED
    return is_whole and bottom - top >= _MIN_HEIGHT_PX and right > left and min(label.dimensions_hwl) > 0.0


def _cut(
    frame: Frame, label: Label, points_cam: NDArray[np.float64], intensity: NDArray[np.float32], source: str
) -> BankObject | None:
    points_img = frame.calib.project(points_cam)
    width, height = frame.image_size
    is_seen = (points_img >= 0.0).all(axis=1) & (points_img <= (width - 1.0, height - 1.0)).all(axis=1)
    if not is_seen.any():
        return None
    if frame.instance is None:
        corners_img = frame.calib.project(corners_cam(label.box_cam[None])[0])
        mask = silhouette_from_points(frame.image_size, points_img[is_seen], corners_img, label.bbox)
        mask = None if mask is None else refined_silhouette(frame.image, mask, label.bbox)
    else:
        mask = silhouette_from_instances(frame.instance, points_img[is_seen], label.bbox)
        if mask is not None and label.type not in _SLENDER and not is_solid(mask):
            return None
    if mask is None or np.count_nonzero(mask) < _MIN_PIXELS:
        return None
    left, top, columns, rows = cv2.boundingRect(mask)
    window = (slice(top, top + rows), slice(left, left + columns))
    crop = np.dstack([frame.image[window], mask[window]])
    edges = np.array([[left, top], [left + columns, top], [left + columns, top + rows], [left, top + rows]]) - 0.5
    lidar_cam = frame.calib.cam_from_velo[:3, 3]
    box_scan = label.box_cam
    box_scan[:3] -= lidar_cam
    try:
        return BankObject(
            label.type,
            box_scan,
            np.column_stack([points_cam - lidar_cam, intensity]).astype(np.float32),
            crop,
            _on_board(edges, frame, label) - lidar_cam,
            source,
        )
    except CadetError as error:
        raise CadetError(f"{source}: {label.type} at {label.location_cam}: {error}") from None


def _on_board(points_img: NDArray[np.float64], frame: Frame, label: Label) -> NDArray[np.float64]:
    """Bring pixels (N, 2) onto the upright plane through the box's center that faces the camera: (N, 3), cam frame."""
    eye_cam, calib = frame.calib.eye_cam, frame.calib
    center_cam = np.array(label.location_cam) - [0.0, 0.5 * label.dimensions_hwl[0], 0.0]
    normal = (center_cam - eye_cam) * [1.0, 0.0, 1.0]
    rays = np.linalg.solve(calib.P2[:, :3], np.column_stack([points_img, np.ones(len(points_img))]).T).T
    reach = (normal @ (center_cam - eye_cam)) / (rays @ normal)
    on_board: NDArray[np.float64] = eye_cam + rays * reach[:, None]
    return on_board
