"""The heading of a box: four corners leave four of them open, the angle vector chooses."""

from __future__ import annotations

import math

import torch
from torch import Tensor


def wrap_angle(angle_rad: Tensor) -> Tensor:
    """Wrap angles into [-pi, pi)."""
    return torch.remainder(angle_rad + math.pi, 2.0 * math.pi) - math.pi


def angle_vectors(boxes_cam: Tensor) -> Tensor:
    """Give headings as (cos, sin) of rotation_y: (N, 7) to (N, 2)."""
    return torch.stack([torch.cos(boxes_cam[:, 6]), torch.sin(boxes_cam[:, 6])], dim=1)


def fix_up(boxes_cam: Tensor, vectors: Tensor, *, is_reference: bool = False) -> Tensor:
    """Turn boxes by the multiple of 90 degrees that brings them nearest to their angle vectors.

    Length and width change places where the turn is by 90 degrees, so the rectangle on the ground stays.

    Args:
        boxes_cam: (N, 7), as decoded from corners.
        vectors: (N, 2) [cos, sin] of the predicted rotation_y, of any length.
        is_reference: turn by 90 degrees the wrong way, as AVOD's own code does: the axis is right then and the heading
            reversed.

    Returns:
        (N, 7), rotation_y in [-pi, pi).
    """
    rotation_y = boxes_cam[:, 6]
    error = wrap_angle(rotation_y - torch.atan2(vectors[:, 1], vectors[:, 0]))
    is_across = (error.abs() > math.pi / 4.0) & (error.abs() < 3.0 * math.pi / 4.0)
    is_reversed = error.abs() >= 3.0 * math.pi / 4.0
    quarter = torch.sign(error) * (math.pi / 2.0) * (1.0 if is_reference else -1.0)
    turn = quarter * is_across + math.pi * is_reversed.to(error)
    length = torch.where(is_across, boxes_cam[:, 4], boxes_cam[:, 3])
    width = torch.where(is_across, boxes_cam[:, 3], boxes_cam[:, 4])
    turned = wrap_angle(rotation_y + turn)
    return torch.cat([boxes_cam[:, :3], torch.stack([length, width, boxes_cam[:, 5], turned], dim=1)], dim=1)
