"""Which corners of a box the camera sees."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti import boxes
from cadet.formats.kitti.calib import points_in_image
from cadet.formats.kitti.drawing.drawable import LEVEL_PLANE, Drawable
from cadet.formats.kitti.label import Label, boxes_cam_from_labels

_DEPTH_MARGIN_M: Final = 0.1
_LIDAR_MARGIN_M: Final = 0.3
_LIDAR_WINDOW_PX: Final = (5.0, 7.0)
_ABOVE_GROUND_M: Final = 0.25
_NUM_CORNERS: Final = 8


def corner_visibility(frame: Drawable, labels: list[Label]) -> tuple[NDArray[np.bool_], str]:
    """Tell which corners of labeled boxes the camera sees, from the best source at hand.

    In this order: `frame.meta`, where the generator noted it; the depth image, by the rule that a corner is hidden if
    all four diagonal neighbors are nearer by more than 0.1 m; else an estimate from the LIDAR, by which a corner is
    hidden if most returns from above the ground within a few pixels of it are nearer by more than 0.3 m. Corners
    outside the image or behind the camera count as hidden always.

    Args:
        frame: the frame.
        labels: M of its own labels.

    Returns:
        (M, 8) bool in the order of `boxes.corners_cam`, and the source in words.
    """
    noted = _visibility_from_meta(frame, labels)
    if noted is not None:
        return noted, "by the generator"
    corners = boxes.corners_cam(boxes_cam_from_labels(labels)).reshape(-1, 3)
    is_visible = (corners[:, 2] >= boxes.NEAR_M) & points_in_image(corners, frame.calib, frame.image_size)
    corners_img = frame.calib.project(corners)
    if frame.depth is not None:
        is_hidden = _hidden_by_depth(corners[:, 2], corners_img, is_visible, frame.depth)
        source = "by the depth image"
    else:
        is_hidden = _hidden_by_lidar(corners[:, 2], corners_img, is_visible, frame)
        source = "estimated from the LIDAR"
    return (is_visible & ~is_hidden).reshape(-1, _NUM_CORNERS), source


def _visibility_from_meta(frame: Drawable, labels: list[Label]) -> NDArray[np.bool_] | None:
    entries = (frame.meta or {}).get("objects")
    if not isinstance(entries, list) or len(entries) != len(frame.labels):
        return None
    rows: list[list[Any]] = []
    for label in labels:
        entry = entries[[line is label for line in frame.labels].index(True)]
        row = entry.get("corner_visible") if isinstance(entry, dict) else None
        if not isinstance(row, list) or len(row) != _NUM_CORNERS:
            return None
        rows.append(row)
    return np.array(rows, np.bool_).reshape(-1, _NUM_CORNERS)


def _hidden_by_depth(
    z_m: NDArray[np.float64],
    corners_img: NDArray[np.float64],
    is_candidate: NDArray[np.bool_],
    depth: NDArray[np.float32],
) -> NDArray[np.bool_]:
    height, width = depth.shape
    is_hidden = np.zeros(len(z_m), np.bool_)
    for index in np.flatnonzero(is_candidate):
        u, v = np.floor(corners_img[index]).astype(int)
        columns, rows = np.clip([u, u + 1], 0, width - 1), np.clip([v, v + 1], 0, height - 1)
        is_hidden[index] = depth[np.ix_(rows, columns)].max() < z_m[index] - _DEPTH_MARGIN_M
    return is_hidden


def _hidden_by_lidar(
    z_m: NDArray[np.float64], corners_img: NDArray[np.float64], is_candidate: NDArray[np.bool_], frame: Drawable
) -> NDArray[np.bool_]:
    points_cam = frame.calib.points_cam_from_velo(frame.points_velo)
    plane = LEVEL_PLANE if frame.plane is None else frame.plane
    is_kept = points_in_image(points_cam, frame.calib, frame.image_size)
    is_kept &= points_cam @ plane[:3] + plane[3] > _ABOVE_GROUND_M
    points_cam = points_cam[is_kept]
    points_img = frame.calib.project(points_cam)
    is_hidden = np.zeros(len(z_m), np.bool_)
    for index in np.flatnonzero(is_candidate):
        is_near = (np.abs(points_img - corners_img[index]) <= _LIDAR_WINDOW_PX).all(axis=1)
        if is_near.any():
            is_hidden[index] = np.median(points_cam[is_near, 2]) < z_m[index] - _LIDAR_MARGIN_M
    return is_hidden
