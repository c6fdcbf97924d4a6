"""How high the points in a box reach: what a detector's maps say of it directly."""

from __future__ import annotations

from typing import Final

import torch
from torch import Tensor
from torch.nn import functional

from avod.geometry.projection import bev_boxes
from cadet.bev import BevConfig

_MAX_MARGIN: Final = 1.0 / 16.0
"""Half a cell, or this share of a part of less than eight cells, is left out at each of the part's ends: cells that it
barely touches are not its own."""


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
    y1, x1, y2, x2 = bev_boxes(anchors, config).unbind(dim=1)
    rows = _cells_of_parts(y1, y2, tops_m.shape[0], num_cells)[:, :, :, None].expand(-1, -1, -1, num_cells)
    columns = _cells_of_parts(x1, x2, tops_m.shape[1], num_cells)[:, :, None, :].expand(-1, -1, num_cells, -1)
    # A border of empty cells stands for all that is off the maps.
    parts = _greatest(functional.pad(tops_m, (1, 1, 1, 1)), rows, columns).flatten(1)
    return torch.cat([parts, parts.amax(dim=1, keepdim=True)], dim=1)


def _cells_of_parts(start: Tensor, end: Tensor, count: int, num_cells: int) -> Tensor:
    """Return the first and the last cell of each part (2, N, num_cells), counted from a border cell at 0.

    Args:
        start: (N,) of the boxes, as fractions of the map.
        end: (N,) likewise.
        count: cells of the map along this side.
        num_cells: parts of a box.
    """
    parts = torch.arange(num_cells, device=start.device, dtype=start.dtype)
    sides = (end - start)[:, None]
    margins = (0.5 * num_cells / (sides * count)).clamp(max=_MAX_MARGIN)
    shares = torch.stack([parts + margins, parts + 1.0 - margins]) / num_cells
    places = start[:, None] + sides * shares
    # Boxes that are no numbers lie off the maps: the losses say so of them.
    first, last = ((places * count).floor().clamp(-1, count).nan_to_num(nan=-1.0) + 1.0).long()
    return torch.stack([first, last.maximum(first)])


def _greatest(cells: Tensor, rows: Tensor, columns: Tensor) -> Tensor:
    """Return the greatest value in rectangles of a map.

    Each is covered by four windows that may overlap, whose sides are the greatest powers of two that fit.

    Args:
        cells: (H, W).
        rows: (2, ...) first and last row of each rectangle.
        columns: (2, ...) first and last column.
    """
    levels, places = [], []
    if not rows.numel():
        return cells.new_empty(rows.shape[1:])
    for first, last in (rows, columns):
        level = torch.log2((last - first + 1).float()).long()
        levels.append(level)
        places.append((first, last + 1 - (1 << level)))
    found = torch.full_like(rows[0], -torch.inf, dtype=cells.dtype)
    tall = cells
    for i in range(int(levels[0].max()) + 1):
        tall = _doubled(tall, i, 0)
        window = tall
        for j in range(int(levels[1].max()) + 1):
            window = _doubled(window, j, 1)
            height, width = window.shape
            corners = [
                window.flatten()[row.clamp(max=height - 1) * width + column.clamp(max=width - 1)]
                for row in places[0]
                for column in places[1]
            ]
            is_covered = (levels[0] == i) & (levels[1] == j)
            found = torch.where(is_covered, torch.stack(corners).amax(dim=0), found)
    return found


def _doubled(windows: Tensor, level: int, dim: int) -> Tensor:
    """Return the greatest values of windows of 2 ** level cells along a side, from those of half as many."""
    if level == 0:
        return windows
    half = 1 << (level - 1)
    length = windows.shape[dim] - half
    return torch.maximum(windows.narrow(dim, 0, length), windows.narrow(dim, half, length))
