"""Figures drawn into the camera image: LIDAR returns, boxes, box corners."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util import style
from cadet.formats.kitti import boxes
from cadet.formats.kitti.calib import Calibration, points_in_image
from cadet.formats.kitti.drawing.drawable import Drawable
from cadet.formats.kitti.drawing.visibility import corner_visibility
from cadet.formats.kitti.label import Label

_FACES: Final = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7), (3, 2, 1, 0))
_HEADING_M: Final = 1.0
_FARTHEST_M: Final = 1e6
_MIN_TAG_HEIGHT_PX: Final = 16.0


def lidar_figure(frame: Drawable) -> style.Image:
    """Draw the LIDAR returns that the image sees over it, colored by depth: near red, far blue.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    canvas = style.dimmed(frame.image, brightness=0.5, saturation=0.35)
    points_cam = frame.calib.points_cam_from_velo(frame.points_velo)
    points_cam = points_cam[points_in_image(points_cam, frame.calib, frame.image_size)]
    points_cam = points_cam[np.argsort(-points_cam[:, 2], kind="stable")]
    points_img = frame.calib.project(points_cam)
    colors = style.turbo(style.depth_share(points_cam[:, 2]))
    radii = np.clip(12.0 / np.maximum(points_cam[:, 2], 1.0), 0.9, 1.5)
    for point, color, radius in zip(points_img, colors.tolist(), radii, strict=True):
        style.dot(canvas, point, radius, (color[0], color[1], color[2]))
    _draw_depth_scale(canvas)
    return canvas


def boxes_figure(frame: Drawable) -> style.Image:
    """Draw the labels' 2D boxes (thin) and 3D boxes (front face tinted, an arrow along the heading), far ones first.

    Edges on the far side of a box are fainter; DontCare regions are dashed.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    canvas = frame.image.copy()
    for label in frame.labels:
        if label.is_dont_care:
            _draw_dashed(canvas, label.bbox, style.DONT_CARE)
    objects = far_to_near(frame.labels)
    for label in objects:
        color = style.class_color(label.type)
        left, top, right, bottom = label.bbox
        corners_img = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
        style.polyline(canvas, corners_img, _mix(color, style.TEXT, 0.5), 1)
        draw_wire_box(canvas, label, frame.calib, color)
    _draw_tags(canvas, objects)
    return canvas


def corners_figure(frame: Drawable, is_visible: NDArray[np.bool_] | None = None) -> style.Image:
    """Draw the 3D boxes' corners, red where hidden and green where visible.

    Args:
        frame: the frame.
        is_visible: (M, 8) for the objects from far to near; None asks `corner_visibility`.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    canvas = style.dimmed(frame.image, brightness=0.75, saturation=0.5)
    objects = far_to_near(frame.labels)
    if is_visible is None:
        is_visible, _ = corner_visibility(frame, objects)
    for label, is_corner_visible in zip(objects, is_visible, strict=True):
        draw_wire_box(canvas, label, frame.calib, style.TEXT, has_heading=False)
        corners = boxes.corners_cam(label.box_cam[None])[0]
        near_to_far = np.argsort(-corners[:, 2], kind="stable")
        for corner in near_to_far:
            if corners[corner, 2] >= boxes.NEAR_M:
                center = frame.calib.project(corners[corner : corner + 1])[0]
                radius = float(np.clip(60.0 / corners[corner, 2], 2.2, 5.0))
                style.dot(canvas, center, radius + 1.3, style.BACKGROUND)
                style.dot(canvas, center, radius, style.VISIBLE if is_corner_visible[corner] else style.HIDDEN)
    return canvas


def draw_wire_box(
    canvas: style.Image, label: Label, calib: Calibration, color: style.Color, *, has_heading: bool = True
) -> None:
    """Draw a 3D box: edges of faces that look at the camera bright, the others faint; optionally where it heads.

    A damaged label's box may be too far away to be drawn.
    """
    corners = boxes.corners_cam(label.box_cam[None])[0]
    if np.abs(corners).max() > _FARTHEST_M:
        return
    is_seen = _seen_edges(corners, calib)
    thickness = 2 if label.location_cam[2] < 30.0 else 1
    if has_heading and (corners[list(boxes.FRONT), 2] >= boxes.NEAR_M).all():
        style.polygon(canvas, calib.project(corners[list(boxes.FRONT)]), color, 0.28)
    for edge, is_bright in sorted(zip(boxes.EDGES, is_seen, strict=True), key=lambda item: item[1]):
        start, end = boxes.clip_segments(corners[edge[:1],], corners[edge[1:],])
        ends_img = calib.project(np.concatenate([start, end]))
        edge_color = color if is_bright else _mix(color, style.BACKGROUND, 0.5)
        style.stroke(canvas, ends_img[0], ends_img[1], edge_color, thickness if is_bright else 1)
    if has_heading:
        _draw_heading(canvas, corners, calib, color, thickness)


def far_to_near(labels: tuple[Label, ...]) -> list[Label]:
    """List the objects without DontCare regions, the farthest first."""
    return sorted((label for label in labels if not label.is_dont_care), key=lambda label: -label.location_cam[2])


def _draw_heading(
    canvas: style.Image, corners: NDArray[np.float64], calib: Calibration, color: style.Color, thickness: int
) -> None:
    front, center = corners[[0, 1]].mean(axis=0), corners[:4].mean(axis=0)
    ahead = (front - center) / np.linalg.norm(front - center)
    side = np.array([ahead[2], 0.0, -ahead[0]])
    tip = front + _HEADING_M * ahead
    barbs = [tip - 0.35 * ahead + 0.25 * side, tip - 0.35 * ahead - 0.25 * side]
    for start, end in ((center, tip), (tip, barbs[0]), (tip, barbs[1])):
        ends = np.concatenate(boxes.clip_segments(start[None], end[None]))
        ends_img = calib.project(ends)
        style.stroke(canvas, ends_img[0], ends_img[1], color, thickness)


def _seen_edges(corners: NDArray[np.float64], calib: Calibration) -> list[bool]:
    eye = calib.eye_cam
    middle = corners.mean(axis=0)
    seen: set[frozenset[int]] = set()
    for face in _FACES:
        center = corners[list(face)].mean(axis=0)
        if np.dot(center - middle, eye - center) > 0.0:
            seen |= {frozenset((face[k], face[(k + 1) % 4])) for k in range(4)}
    return [frozenset(edge) in seen for edge in boxes.EDGES]


def _draw_tags(canvas: style.Image, objects: list[Label]) -> None:
    """Name the objects, the nearest first; a tag that would cover one already there is left out."""
    taken: list[tuple[float, float, float, float]] = []
    for label in reversed(objects):
        if label.bbox[3] - label.bbox[1] < _MIN_TAG_HEIGHT_PX:
            continue
        text = f"{label.type} {np.hypot(label.location_cam[0], label.location_cam[2]):.0f} m"
        bounds = style.tag_bounds(canvas, text, label.bbox[0], label.bbox[1] - 2.0)
        if any(_overlap(bounds, other) for other in taken):
            continue
        taken.append(bounds)
        style.write_on_tag(canvas, text, label.bbox[0], label.bbox[1] - 2.0, style.class_color(label.type))


def _overlap(first: tuple[float, float, float, float], second: tuple[float, float, float, float]) -> bool:
    return first[0] < second[2] and second[0] < first[2] and first[1] < second[3] and second[1] < first[3]


def _draw_dashed(canvas: style.Image, bbox: tuple[float, float, float, float], color: style.Color) -> None:
    left, top, right, bottom = bbox
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        for first, last in style.dashes(start, end):
            style.stroke(canvas, first, last, color)


def _draw_depth_scale(canvas: style.Image) -> None:
    width, height, margin = 220, 8, 12
    left, top = canvas.shape[1] - width - margin - 8, canvas.shape[0] - margin - height
    if left < margin or top < 40:
        return
    plate = np.array([[-12, -24], [width + 12, -24], [width + 12, height + 6], [-12, height + 6]], np.float64)
    style.polygon(canvas, plate + np.array([left, top]), style.BACKGROUND, 0.75)
    depth_m = np.exp(np.linspace(np.log(4.0), np.log(70.0), width))
    canvas[top : top + height, left : left + width] = style.turbo(style.depth_share(depth_m))[None]
    for tick_m in (5, 10, 20, 40, 70):
        x = left + (np.log(tick_m) - np.log(4.0)) / (np.log(70.0) - np.log(4.0)) * (width - 1)
        style.stroke(canvas, (x, top - 3), (x, top), style.TEXT)
        text = f"{tick_m} m" if tick_m == 70 else str(tick_m)
        text_width, _ = style.text_size(text, 0.36)
        style.write(canvas, text, min(x - text_width / 2, left + width + 8 - text_width), top - 7, 0.36)


def _mix(first: style.Color, second: style.Color, share: float) -> style.Color:
    red, green, blue = (round((1.0 - share) * a + share * b) for a, b in zip(first, second, strict=True))
    return red, green, blue
