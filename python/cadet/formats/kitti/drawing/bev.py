"""The figure from above: LIDAR returns, boxes, range rings."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from cadet._util import style
from cadet._util.checks import check_number
from cadet.formats.kitti import boxes
from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.drawing.drawable import LEVEL_PLANE, Drawable
from cadet.formats.kitti.label import Label

AHEAD_M: Final = 70.0
"""How far the figure looks ahead of the LIDAR."""
ASIDE_M: Final = 40.0
"""How far the figure looks to either side."""

_BEHIND_M: Final = 3.0
# Points of damaged frames lie further away, up to where sums of coordinates are none.
_FARTHEST_M: Final = 1e6
_RING_STEP_M: Final = 10.0
_HEIGHT_M: Final = (-0.3, 3.0)
_EGO_SIZE_M: Final = (4.5, 1.8)
_THICK_PX_PER_M: Final = 8.0
_GLOW: Final = 3.6
_HEADING_M: Final = 1.2


def bev_figure(frame: Drawable, width: int = 960, *, has_text: bool = True) -> style.Image:
    """Draw the scan from above, ahead being up: 70 m ahead, 40 m to either side, a ring every 10 m.

    Ahead is where the LIDAR's x axis points, or the camera, if that looks more than 45 degrees away from it.

    Returns are colored by height over the ground and brighter where they are denser or shine back more. Boxes are
    outlined in their class's color with a tick along the heading; the faint wedge is what the camera sees.

    Args:
        frame: the frame.
        width: of the figure, in pixels; the height follows.
        has_text: whether the rings carry their range.

    Returns:
        (round(width * 73 / 80), width, 3) uint8 RGB.
    """
    check_number("bev_figure", "width", width, 16, 16_384, whole=True)
    scale = width / (2.0 * ASIDE_M)
    height = round((AHEAD_M + _BEHIND_M) * scale)
    canvas = style.filled(height, width)
    level, view = _View(scale), _View.of_camera(frame.calib, scale)
    _draw_view(canvas, frame, view)
    _draw_rings(canvas, level)
    _draw_points(canvas, frame, view)
    if has_text:
        _draw_ranges(canvas, level)
    for label in frame.labels:
        if not label.is_dont_care:
            _draw_box(canvas, label, frame.calib, view)
    _draw_ego(canvas, view)
    return canvas


class _View(NamedTuple):
    """Where places lie on the canvas.

    Attributes:
        scale: pixels a meter.
        ahead_velo: what is up, a unit vector of the velo frame's plane.
    """

    scale: float
    ahead_velo: tuple[float, float] = (1.0, 0.0)

    @classmethod
    def of_camera(cls, calib: Calibration, scale: float) -> _View:
        """Return the view in which the camera looks up, or within 45 degrees of it."""
        eye, far = calib.points_velo_from_cam(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
        x, y = (far - eye)[:2]
        length = math.hypot(x, y)
        return cls(scale) if x >= math.sqrt(0.5) * length else cls(scale, (x / length, y / length))

    def pixels(self, points_velo: NDArray[np.float64]) -> NDArray[np.float64]:
        """Place points (N, 2+) [x, y] of the velo frame on the canvas: (N, 2) [u, v]."""
        near_velo = np.clip(points_velo[:, :2], -_FARTHEST_M, _FARTHEST_M)
        x, y = self.ahead_velo
        u = (ASIDE_M - near_velo @ [-y, x]) * self.scale - 0.5
        v = (AHEAD_M - near_velo @ [x, y]) * self.scale - 0.5
        return np.stack([u, v], axis=1)


def _draw_rings(canvas: style.Image, view: _View) -> None:
    angles = np.linspace(-np.pi, np.pi, 241)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for range_m in np.arange(_RING_STEP_M, AHEAD_M + 1.0, _RING_STEP_M):
        style.polyline(canvas, view.pixels(range_m * circle), style.GRID)


def _draw_ranges(canvas: style.Image, view: _View) -> None:
    """Write the rings' ranges to the right, near the edge of what the camera sees, where few returns lie."""
    bearing = np.radians(-36.0)
    ahead = np.array([[np.cos(bearing), np.sin(bearing)]])
    for range_m in np.arange(_RING_STEP_M, AHEAD_M + 1.0, _RING_STEP_M):
        left, baseline = view.pixels(range_m * ahead)[0]
        text = f"{range_m:.0f} m"
        width, height = style.text_size(text, 0.38)
        if left + width + 6 < canvas.shape[1]:
            plate = np.array([[-3, 3], [width + 3, 3], [width + 3, -height - 4], [-3, -height - 4]], np.float64)
            style.polygon(canvas, plate + np.array([left + 4, baseline - 4]), style.BACKGROUND, 0.75)
            style.write(canvas, text, left + 4, baseline - 4, 0.38, style.TEXT)


def _draw_view(canvas: style.Image, frame: Drawable, view: _View) -> None:
    eye, *rays = _view_rays(frame.calib, frame.image_size[0])
    wedge = view.pixels(np.stack([eye, rays[0], rays[1]]))
    style.polygon(canvas, wedge, (90, 110, 140), 0.13)
    for ray in wedge[1:]:
        style.stroke(canvas, wedge[0], ray, (58, 70, 88))


def _view_rays(calib: Calibration, width: int) -> list[NDArray[np.float64]]:
    eye_cam = calib.eye_cam
    columns = np.array([[0.0, 0.0, 1.0], [width - 1.0, 0.0, 1.0]])
    columns[:, 1] = calib.P2[1, 2]
    directions = np.linalg.solve(calib.P2[:, :3], columns.T).T
    far_cam = eye_cam + directions * 200.0
    return list(calib.points_velo_from_cam(np.concatenate([eye_cam[None], far_cam]))[:, :2])


def _draw_points(canvas: style.Image, frame: Drawable, view: _View) -> None:
    """Add up the returns on a grid twice as fine, then shrink it: dense places glow, single returns stay visible."""
    plane = LEVEL_PLANE if frame.plane is None else frame.plane
    height_m = frame.calib.points_cam_from_velo(frame.points_velo) @ plane[:3] + plane[3]
    fine = (canvas.shape[0] * 2, canvas.shape[1] * 2)
    places = np.floor((view.pixels(frame.points_velo.astype(np.float64)) + 0.5) * 2.0)
    # Far beyond the canvas a number may be none of an integer's.
    pixels = np.clip(places, -1.0, max(fine)).astype(np.intp)
    is_inside = ((pixels >= 0) & (pixels < [fine[1], fine[0]])).all(axis=1)
    pixels, height_m, intensity = pixels[is_inside], height_m[is_inside], frame.points_velo[is_inside, 3]
    order = np.argsort(height_m, kind="stable")
    pixels, height_m, intensity = pixels[order], height_m[order], intensity[order]
    low, high = _HEIGHT_M
    share = np.clip((height_m - low) / (high - low), 0.0, 1.0)
    brightness = 0.7 + 0.3 * np.sqrt(np.clip(intensity, 0.0, 1.0))
    layer = np.zeros((*fine, 3), np.float32)
    cover = np.zeros(fine, np.float32)
    layer[pixels[:, 1], pixels[:, 0]] = height_colors(share) * brightness[:, None]
    cover[pixels[:, 1], pixels[:, 0]] = 1.0
    size = (canvas.shape[1], canvas.shape[0])
    layer = np.asarray(cv2.resize(layer, size, interpolation=cv2.INTER_AREA), np.float32)
    cover = np.asarray(cv2.resize(cover, size, interpolation=cv2.INTER_AREA), np.float32)
    gain = np.where(cover > 0.0, np.minimum(_GLOW * cover, 1.0) / np.maximum(cover, 1e-6), 0.0)[..., None]
    mixed = canvas * (1.0 - np.minimum(_GLOW * cover, 1.0)[..., None]) + layer * gain
    canvas[:] = np.rint(np.clip(mixed, 0.0, 255.0)).astype(np.uint8)


def height_colors(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Color heights: the road slate, what stands on it from teal over sand to white; (...) in 0..1 to (..., 3)."""
    stops = np.array([0.0, 0.14, 0.32, 0.6, 1.0])
    colors = np.array([[88, 104, 128], [100, 120, 146], [60, 168, 160], [222, 190, 120], [250, 244, 232]], np.float64)
    return np.stack([np.interp(share, stops, colors[:, channel]) for channel in range(3)], axis=-1)


def _draw_box(canvas: style.Image, label: Label, calib: Calibration, view: _View) -> None:
    corners = calib.points_velo_from_cam(boxes.corners_cam(label.box_cam[None])[0, :4])
    outline = view.pixels(corners)
    color = style.class_color(label.type)
    style.polygon(canvas, outline, color, 0.25)
    thickness = 2 if view.scale > _THICK_PX_PER_M else 1
    style.polyline(canvas, outline, color, thickness)
    if np.abs(corners).max() > _FARTHEST_M:
        return
    front, center = corners[:2].mean(axis=0), corners.mean(axis=0)
    ahead = (front - center) / np.linalg.norm(front - center)
    tick = view.pixels(np.stack([center, front + _HEADING_M * ahead]))
    style.stroke(canvas, tick[0], tick[1], color, thickness)


def _draw_ego(canvas: style.Image, view: _View) -> None:
    length, width = _EGO_SIZE_M
    corners = np.array(
        [[length / 2, width / 2], [length / 2, -width / 2], [-length / 2, -width / 2], [-length / 2, width / 2]]
    )
    outline = view.pixels(corners)
    style.polygon(canvas, outline, style.GRID, 0.9)
    style.polyline(canvas, outline, style.FAINT_TEXT)
    nose = view.pixels(np.array([[length / 2, 0.0], [length / 6, width / 3], [length / 6, -width / 3]]))
    style.polygon(canvas, nose, style.TEXT, 0.9)
