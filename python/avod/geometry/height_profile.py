"""How high the points in a box reach: what a detector's maps say of it directly."""

from __future__ import annotations

from typing import Final

import torch
from torch import Tensor

from avod.geometry.projection import bev_boxes
from cadet.bev import BevConfig

_SAMPLES: Final = 8
"""Places along each side of a cell of the profile; a car's quarter of 1.1 m has 11 cells of 0.1 m at most."""


def cell_tops(bev: Tensor, config: BevConfig) -> Tensor:
    """Return the greatest height over the ground in each cell of the maps: (C, H, W) to (H, W), meters; 0 where empty.

    Args:
        bev: maps by `config`, "max_height" among them.
        config: which maps there are.
    """
    if "max_height" in config.slice_maps:
        per_slice, at = len(config.slice_maps), config.slice_maps.index("max_height")
        thickness_m = (config.height_hi_m - config.height_lo_m) / config.num_slices
        shares = bev[at : per_slice * config.num_slices : per_slice]
        floors_m = torch.arange(config.num_slices, device=bev.device, dtype=bev.dtype) * thickness_m
        heights_m = config.height_lo_m + floors_m[:, None, None] + shares * thickness_m
    else:
        at = len(config.slice_maps) * config.num_slices + config.cloud_maps.index("max_height")
        shares = bev[at : at + 1]
        heights_m = config.height_lo_m + shares * (config.height_hi_m - config.height_lo_m)
    return torch.where(shares > 0.0, heights_m, 0.0).amax(dim=0)


def height_profiles(tops_m: Tensor, anchors: Tensor, config: BevConfig, num_cells: int) -> Tensor:
    """Return the greatest heights in the parts of boxes, seen from above, and in each as a whole.

    Args:
        tops_m: (H, W) from `cell_tops`.
        anchors: (N, 6).
        config: the maps' extent.
        num_cells: parts along each side.

    Returns:
        (N, num_cells ** 2 + 1) meters, the whole last; places off the maps count as empty.
    """
    rows, columns = tops_m.shape
    side = num_cells * _SAMPLES
    steps = (torch.arange(side, device=tops_m.device, dtype=tops_m.dtype) + 0.5) / side
    y1, x1, y2, x2 = bev_boxes(anchors, config).unbind(dim=1)
    row = ((y1[:, None] + (y2 - y1)[:, None] * steps) * rows).floor().long()
    column = ((x1[:, None] + (x2 - x1)[:, None] * steps) * columns).floor().long()
    is_inside = ((row >= 0) & (row < rows))[:, :, None] & ((column >= 0) & (column < columns))[:, None, :]
    at = row.clamp(0, rows - 1)[:, :, None] * columns + column.clamp(0, columns - 1)[:, None, :]
    heights = torch.where(is_inside, tops_m.flatten()[at], 0.0)
    parts = heights.view(-1, num_cells, _SAMPLES, num_cells, _SAMPLES).amax(dim=(2, 4)).flatten(1)
    return torch.cat([parts, parts.amax(dim=1, keepdim=True)], dim=1)
