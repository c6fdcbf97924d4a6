"""Oriented boxes: corners, projection, truncation, membership, and the step between the cam and velo frames.

`boxes_cam` is (M, 7) [x, y, z, l, w, h, rotation_y], the bottom face's center in the rectified frame of camera 0.
`boxes_velo` is (M, 7) [x, y, z, l, w, h, yaw], the geometric center in the velo frame, yaw
counter-clockwise seen from above.
Lists of such rows are taken for arrays.
`boxes_img` is (M, 4) [left, top, right, bottom] in pixels, (0, 0) the center of the top-left pixel.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadet._util.arrays import as_array, check_array
from cadet._util.checks import check_image_size, check_kind, check_number, shown
from cadet.errors import ShapeError
from cadet.formats.kitti.calib import Calibration

NEAR_M: Final = 0.1
"""Boxes are cut here, in meters before the cam frame's origin, when they are projected."""

EDGES: Final = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
"""The twelve edges of a box, as pairs of corners of `corners_cam`."""

FRONT: Final = (0, 1, 5, 4)
"""The corners of the face that looks ahead, in turn."""

# Shares of length, height and width. The bottom first: front left, front right, rear right, rear left.
_UNIT_CORNERS: Final = np.array(
    [
        [0.5, 0.0, 0.5],
        [0.5, 0.0, -0.5],
        [-0.5, 0.0, -0.5],
        [-0.5, 0.0, 0.5],
        [0.5, -1.0, 0.5],
        [0.5, -1.0, -0.5],
        [-0.5, -1.0, -0.5],
        [-0.5, -1.0, 0.5],
    ]
)


def wrap_angle(angle_rad: NDArray[Any] | float) -> NDArray[np.float64]:
    """Wrap angles into [-pi, pi); angles that lie there already keep every bit."""
    angle = np.asarray(angle_rad, np.float64)
    wrapped = (angle + np.pi) % (2.0 * np.pi) - np.pi
    return np.where((angle >= -np.pi) & (angle < np.pi), angle, wrapped)


def alpha_from_boxes(boxes_cam: ArrayLike) -> NDArray[np.float64]:
    """Compute KITTI's observation angle rotation_y - atan2(x, z), wrapped: (M, 7) to (M,) radians.

    Raises:
        ShapeError: not (M, 7).
        NonFiniteError: NaN or infinity.
    """
    boxes = _check_boxes(boxes_cam, "boxes_cam")
    return wrap_angle(boxes[:, 6] - np.arctan2(boxes[:, 0], boxes[:, 2]))


def corners_cam(boxes_cam: ArrayLike) -> NDArray[np.float64]:
    """List the corners of boxes.

    Args:
        boxes_cam: (M, 7), meters and radians. May be empty.

    Returns:
        (M, 8, 3) float64 in the cam frame: bottom front left, front right, rear right, rear left, then the top alike,
        left and right as seen from inside looking ahead.

    Raises:
        ShapeError: not (M, 7).
        NonFiniteError: NaN or infinity.

    Reference: the order of KITTI's development kit (computeBox3D).
    """
    boxes = _check_boxes(boxes_cam, "boxes_cam")
    local = _UNIT_CORNERS * boxes[:, None, [3, 5, 4]]
    cos, sin = np.cos(boxes[:, None, 6]), np.sin(boxes[:, None, 6])
    x = cos * local[..., 0] + sin * local[..., 2]
    z = cos * local[..., 2] - sin * local[..., 0]
    return np.stack([x, local[..., 1], z], axis=-1) + boxes[:, None, :3]


def project_boxes(boxes_cam: ArrayLike, calib: Calibration) -> NDArray[np.float64]:
    """Project boxes and bound them by upright rectangles, not clipped to any image.

    A box that reaches behind `NEAR_M` is cut there first, edge by edge, so it keeps its finite, visible part.

    Args:
        boxes_cam: (M, 7), meters and radians. May be empty.
        calib: the calibration, whose whole P2 projects.

    Returns:
        (M, 4) float64, pixels; NaN for a box that lies wholly behind `NEAR_M`.

    Raises:
        ShapeError: not (M, 7).
        NonFiniteError: NaN or infinity.
    """
    _check_calib(calib)
    corners = corners_cam(boxes_cam)
    # What is too far away for a number becomes NaN at the end.
    with np.errstate(over="ignore", invalid="ignore"):
        starts, ends = clip_segments(corners[:, [a for a, _ in EDGES]], corners[:, [b for _, b in EDGES]])
    ends_cam = np.concatenate([starts, ends], axis=1)
    points_img = calib.project(ends_cam.reshape(-1, 3)).reshape(*ends_cam.shape[:2], 2)
    is_cut_off = np.isnan(points_img[..., :1])
    low = np.where(is_cut_off, np.inf, points_img).min(axis=1, initial=np.inf)
    high = np.where(is_cut_off, -np.inf, points_img).max(axis=1, initial=-np.inf)
    boxes_img = np.concatenate([low, high], axis=1)
    boxes_img[~np.isfinite(boxes_img).all(axis=1)] = np.nan
    return boxes_img


def clip_segments(
    starts_cam: NDArray[np.float64], ends_cam: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cut segments where they pass behind `NEAR_M`.

    Args:
        starts_cam: (..., 3) meters, cam frame.
        ends_cam: (..., 3) likewise.

    Returns:
        The ends of what remains, same shapes; NaN for segments wholly behind.

    Raises:
        ShapeError: no arrays of one such shape.
    """
    for name, points_cam in (("starts_cam", starts_cam), ("ends_cam", ends_cam)):
        if (
            not isinstance(points_cam, np.ndarray)
            or points_cam.dtype.kind not in "fiu"
            or points_cam.shape[-1:] != (3,)
        ):
            raise ShapeError(f"{name}: expected an array (..., 3) of numbers, got {shown(points_cam)}")
    if starts_cam.shape != ends_cam.shape:
        raise ShapeError(f"ends_cam: expected {starts_cam.shape} as starts_cam, got {ends_cam.shape}")
    z0, z1 = starts_cam[..., 2:], ends_cam[..., 2:]
    span = np.where(z1 == z0, 1.0, z1 - z0)
    cut = starts_cam + (NEAR_M - z0) / span * (ends_cam - starts_cam)
    is_behind = (z0 < NEAR_M) & (z1 < NEAR_M)
    starts = np.where(is_behind, np.nan, np.where(z0 < NEAR_M, cut, starts_cam))
    ends = np.where(is_behind, np.nan, np.where(z1 < NEAR_M, cut, ends_cam))
    return starts, ends


def clip_boxes_img(boxes_img: NDArray[np.float64], image_size: tuple[int, int]) -> NDArray[np.float64]:
    """Clip rectangles to [0, W - 1] x [0, H - 1]; one outside collapses onto the border. NaN stays.

    Args:
        boxes_img: (M, 4), pixels.
        image_size: width and height in pixels.

    Raises:
        ShapeError: not (M, 4).
        CadetError: no image size.
    """
    check_array(boxes_img, "boxes_img", ("M", 4))
    width, height = check_image_size(image_size)
    right, bottom = width - 1.0, height - 1.0
    return np.clip(boxes_img, 0.0, np.array([right, bottom, right, bottom]))


def areas_img(boxes_img: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the areas of rectangles in square pixels: (M, 4) to (M,).

    Raises:
        ShapeError: not (M, 4).
    """
    check_array(boxes_img, "boxes_img", ("M", 4))
    area: NDArray[np.float64] = (boxes_img[:, 2] - boxes_img[:, 0]) * (boxes_img[:, 3] - boxes_img[:, 1])
    return area


def iou_img(boxes_img: NDArray[np.float64], others_img: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute intersection over union, pair by pair: (M, 4) and (M, 4) to (M,).

    Raises:
        ShapeError: not (M, 4) twice.
    """
    check_array(boxes_img, "boxes_img", ("M", 4))
    check_array(others_img, "others_img", (len(boxes_img), 4))
    low = np.maximum(boxes_img[:, :2], others_img[:, :2])
    high = np.minimum(boxes_img[:, 2:], others_img[:, 2:])
    overlap = np.clip(high - low, 0.0, None).prod(axis=1)
    union = areas_img(boxes_img) + areas_img(others_img) - overlap
    iou: NDArray[np.float64] = np.divide(overlap, union, out=np.zeros_like(overlap), where=union > 0.0)
    return iou


def truncation(boxes_cam: ArrayLike, calib: Calibration, image_size: tuple[int, int]) -> NDArray[np.float64]:
    """Compute which share of each projected box the image cuts off: 1 - clipped area / whole area.

    Args:
        boxes_cam: (M, 7), meters and radians.
        calib: the calibration.
        image_size: width and height in pixels.

    Returns:
        (M,) float64: 0 whole .. 1 outside; NaN for a box wholly behind `NEAR_M` or without extent.

    Raises:
        ShapeError: not (M, 7).
        NonFiniteError: NaN or infinity.
    """
    whole = project_boxes(boxes_cam, calib)
    whole_area = areas_img(whole)
    share = np.full(len(whole), np.nan)
    np.divide(areas_img(clip_boxes_img(whole, image_size)), whole_area, out=share, where=whole_area > 0.0)
    return 1.0 - share


def points_in_boxes(points_cam: NDArray[Any], boxes_cam: ArrayLike, margin_m: float = 0.0) -> NDArray[np.bool_]:
    """Tell which points lie inside which boxes.

    Args:
        points_cam: (N, 3) or wider, meters, cam frame. May be empty.
        boxes_cam: (M, 7), meters and radians. May be empty.
        margin_m: grows every box by this on all six sides; negative shrinks.

    Returns:
        (N, M) bool; faces count as inside.

    Raises:
        ShapeError: a trailing dimension is wrong.
        NonFiniteError: NaN or infinity in `boxes_cam`.
    """
    boxes = _check_boxes(boxes_cam, "boxes_cam")
    check_number("", "margin_m", margin_m, -1e6, 1e6)
    check_array(points_cam, "points_cam", ("N", "C"))
    if points_cam.shape[1] < 3:
        raise ShapeError(f"points_cam: expected (N, 3) or wider, got {points_cam.shape}")
    points = points_cam[:, :3].astype(np.float64)
    is_inside = np.zeros((len(points), len(boxes)), np.bool_)
    for index, (x, y, z, length, width, height, rotation_y) in enumerate(boxes):
        dx, dy, dz = points[:, 0] - x, points[:, 1] - y, points[:, 2] - z
        cos, sin = np.cos(rotation_y), np.sin(rotation_y)
        is_inside[:, index] = (
            (np.abs(cos * dx - sin * dz) <= 0.5 * length + margin_m)
            & (np.abs(sin * dx + cos * dz) <= 0.5 * width + margin_m)
            & (np.abs(dy + 0.5 * height) <= 0.5 * height + margin_m)
        )
    return is_inside


def boxes_velo_from_cam(boxes_cam: ArrayLike, calib: Calibration) -> NDArray[np.float64]:
    """Bring boxes from the cam frame into the velo frame: (M, 7) to (M, 7).

    The center moves exactly; yaw = -(rotation_y + pi/2), as everywhere for KITTI, which leaves out the fraction of a
    degree by which the two frames are tilted.

    Raises:
        ShapeError: not (M, 7).
        NonFiniteError: NaN or infinity.
    """
    _check_calib(calib)
    boxes = _check_boxes(boxes_cam, "boxes_cam").copy()
    boxes[:, 1] -= 0.5 * boxes[:, 5]
    boxes[:, :3] = calib.points_velo_from_cam(boxes[:, :3])
    boxes[:, 6] = wrap_angle(-(boxes[:, 6] + 0.5 * np.pi))
    return boxes


def _check_calib(calib: object) -> None:
    check_kind("", "calib", calib, Calibration)


def _check_boxes(boxes: ArrayLike, name: str) -> NDArray[np.float64]:
    return as_array(boxes, name, ("M", 7), finite=True).astype(np.float64)
