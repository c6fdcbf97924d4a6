"""Anchors seen from above and by the camera, as fractions of the maps that are cropped."""

from __future__ import annotations

from typing import Final

import torch
from torch import Tensor

from cadet.bev import BevConfig

NEAR_M: Final = 0.1
"""Corners of anchors nearer than this to the image plane are projected as if they lay there."""


def bev_boxes(anchors: Tensor, bev: BevConfig) -> Tensor:
    """Bound anchors from above.

    Args:
        anchors: (N, 6), meters.
        bev: the extent.

    Returns:
        (N, 4) [y1, x1, y2, x2] as fractions of the map, y from the far edge. Not clipped.
    """
    x, z, half_x, half_z = anchors[:, 0], anchors[:, 2], anchors[:, 3] / 2.0, anchors[:, 5] / 2.0
    width, height = bev.x_m[1] - bev.x_m[0], bev.z_m[1] - bev.z_m[0]
    return torch.stack(
        [
            (bev.z_m[1] - (z + half_z)) / height,
            (x - half_x - bev.x_m[0]) / width,
            (bev.z_m[1] - (z - half_z)) / height,
            (x + half_x - bev.x_m[0]) / width,
        ],
        dim=1,
    )


def ground_boxes(anchors: Tensor) -> Tensor:
    """Bound anchors from above in meters: (N, 6) to (N, 4) [z1, x1, z2, x2]."""
    x, z, half_x, half_z = anchors[:, 0], anchors[:, 2], anchors[:, 3] / 2.0, anchors[:, 5] / 2.0
    return torch.stack([z - half_z, x - half_x, z + half_z, x + half_x], dim=1)


def image_boxes(anchors: Tensor, projection: Tensor, image_size: tuple[int, int]) -> Tensor:
    """Bound the projections of anchors' corners.

    Args:
        anchors: (N, 6), meters.
        projection: (3, 4) P2, pixels, the same dtype.
        image_size: width and height of the image that P2 belongs to.

    Returns:
        (N, 4) [y1, x1, y2, x2] as fractions of the image. Not clipped. AVOD projects corners behind the camera too,
        which turns boxes there inside out; here they count as lying `NEAR_M` before it.
    """
    signs = torch.tensor([[x, y, z] for x in (-0.5, 0.5) for y in (0.0, -1.0) for z in (-0.5, 0.5)])
    corners = anchors[:, None, :3] + anchors[:, None, 3:] * signs.to(anchors)
    homogeneous = corners @ projection[:, :3].T + projection[:, 3]
    size = torch.tensor([image_size[0], image_size[1]]).to(anchors)
    points = homogeneous[..., :2] / homogeneous[..., 2:].clamp(min=NEAR_M) / size
    low, high = points.amin(dim=1), points.amax(dim=1)
    return torch.stack([low[:, 1], low[:, 0], high[:, 1], high[:, 0]], dim=1)
