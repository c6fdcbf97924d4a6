"""Boxes as anchors, as four corners with heights, and back."""

from __future__ import annotations

import math
from typing import Final

import torch
from torch import Tensor

MIN_SIZE_M: Final = 0.01
"""Decoded boxes are at least this long, wide and high: an untrained network may put the top below the bottom."""

MAX_LOG_SCALE: Final = 4.0
"""Regressed anchors grow at most by exp of this, so that a bad step gives no infinity."""

_RIGHT_ANGLE: Final = math.pi / 2.0
# Corners in turn, seen from above: (+x, +z), (+x, -z), (-x, -z), (-x, +z).
_SIGNS_X: Final = (0.5, 0.5, -0.5, -0.5)
_SIGNS_Z: Final = (0.5, -0.5, -0.5, 0.5)


def anchors_from_boxes(boxes_cam: Tensor) -> Tensor:
    """Turn boxes to the nearest multiple of 90 degrees: (N, 7) to anchors (N, 6)."""
    x, y, z, length, width, height, rotation_y = boxes_cam.unbind(dim=1)
    right_angle = torch.round(rotation_y / _RIGHT_ANGLE) * _RIGHT_ANGLE
    cos, sin = torch.cos(right_angle).abs(), torch.sin(right_angle).abs()
    return torch.stack([x, y, z, length * cos + width * sin, height, width * cos + length * sin], dim=1)


def offsets_from_anchors(anchors: Tensor, targets: Tensor) -> Tensor:
    """Encode anchors by others: (N, 6) and (N, 6) to (N, 6), shifts over the anchor's size and logarithms of ratios."""
    sizes = anchors[:, 3:]
    return torch.cat([(targets[:, :3] - anchors[:, :3]) / sizes, torch.log(targets[:, 3:] / sizes)], dim=1)


def anchors_from_offsets(anchors: Tensor, offsets: Tensor) -> Tensor:
    """Decode what `offsets_from_anchors` encodes: (N, 6) and (N, 6) to (N, 6)."""
    sizes = anchors[:, 3:]
    scale = torch.exp(offsets[:, 3:].clamp(max=MAX_LOG_SCALE))
    return torch.cat([offsets[:, :3] * sizes + anchors[:, :3], sizes * scale], dim=1)


def ground_y(x: Tensor, z: Tensor, plane: Tensor) -> Tensor:
    """Find the ground plane under points: y, cam frame, meters."""
    return -(plane[0] * x + plane[2] * z + plane[3]) / plane[1]


def boxes_4c_from_anchors(anchors: Tensor, plane: Tensor) -> Tensor:
    """Give anchors as corners and heights: (N, 6) and (4,) to (N, 10)."""
    x, y, z, dx, dy, dz = anchors.unbind(dim=1)
    return _boxes_4c(x, y, z, dx, dy, dz, torch.zeros_like(x), plane)


def boxes_4c_from_boxes(boxes_cam: Tensor, plane: Tensor) -> Tensor:
    """Give boxes as corners and heights: (N, 7) and (4,) to (N, 10).

    The first corner is the one that is at (+x, +z) once the box is turned to the nearest multiple of 90 degrees, so
    each corner's nearest neighbor in an anchor has the same place. Which end is the front is lost.
    """
    x, y, z, _, _, _, rotation_y = boxes_cam.unbind(dim=1)
    _, _, _, dx, dy, dz = anchors_from_boxes(boxes_cam).unbind(dim=1)
    rest = rotation_y - torch.round(rotation_y / _RIGHT_ANGLE) * _RIGHT_ANGLE
    return _boxes_4c(x, y, z, dx, dy, dz, rest, plane)


def boxes_from_4c(boxes_4c: Tensor, plane: Tensor) -> Tensor:
    """Fit boxes to corners and heights: (N, 10) and (4,) to (N, 7).

    The longer of the two lines between opposite sides' middles is the length's axis; length and width are what the four
    corners span along it and across. rotation_y is right up to 180 degrees.
    """
    corners = torch.stack([boxes_4c[:, :4], boxes_4c[:, 4:8]], dim=2)
    middles = (corners + corners.roll(-1, dims=1)) / 2.0
    along_x = middles[:, 0] - middles[:, 2]
    along_z = middles[:, 3] - middles[:, 1]
    is_x_longer = (along_x.norm(dim=1) >= along_z.norm(dim=1))[:, None]
    axis = torch.where(is_x_longer, along_x, along_z)
    start = torch.where(is_x_longer, middles[:, 2], middles[:, 1])
    axis = axis / axis.norm(dim=1, keepdim=True).clamp(min=1e-9)
    normal = torch.stack([-axis[:, 1], axis[:, 0]], dim=1)
    from_start = corners - start[:, None]
    along = (from_start * axis[:, None]).sum(dim=2)
    across = (from_start * normal[:, None]).sum(dim=2)
    low, high = along.amin(dim=1), along.amax(dim=1)
    length = (high - low).clamp(min=MIN_SIZE_M)
    width = (across.amax(dim=1) - across.amin(dim=1)).clamp(min=MIN_SIZE_M)
    center = start + ((low + high) / 2.0)[:, None] * axis
    x, z = center.unbind(dim=1)
    y = ground_y(x, z, plane) - boxes_4c[:, 8]
    height = (boxes_4c[:, 9] - boxes_4c[:, 8]).clamp(min=MIN_SIZE_M)
    return torch.stack([x, y, z, length, width, height, -torch.atan2(axis[:, 1], axis[:, 0])], dim=1)


def _boxes_4c(
    x: Tensor, y: Tensor, z: Tensor, dx: Tensor, dy: Tensor, dz: Tensor, rotation: Tensor, plane: Tensor
) -> Tensor:
    across = dx[:, None] * dx.new_tensor(_SIGNS_X)
    ahead = dz[:, None] * dz.new_tensor(_SIGNS_Z)
    cos, sin = torch.cos(rotation)[:, None], torch.sin(rotation)[:, None]
    corners_x = across * cos + ahead * sin + x[:, None]
    corners_z = -across * sin + ahead * cos + z[:, None]
    bottom = ground_y(x, z, plane) - y
    return torch.cat([corners_x, corners_z, bottom[:, None], (bottom + dy)[:, None]], dim=1)
