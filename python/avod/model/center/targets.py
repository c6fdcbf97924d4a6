"""What the center detector should find: marks about centers, and each box as numbers at its center's cell.

The ten numbers of a box are the center's place in its cell (rows and columns), the bottom's height over the ground (m),
the logarithms of length, width and height over the class's mean sizes, sine and cosine of twice the heading, which an
object's two ends share, and of the heading.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import torch
from torch import Tensor

from avod.config import Config
from avod.data.sample import Sample
from avod.geometry.encoding import ground_y
from avod.geometry.orientation import wrap_angle

NUM_BOX: Final = 10
OUTPUT_STRIDE: Final = 2
"""Cells of the maps that a cell of the output covers, along each axis."""
_LEAST_MARK: Final = 0.01
"""Marks end where they are fainter."""


@dataclass(frozen=True, eq=False)
class CenterTargets:
    """What should be found in a frame with M objects in the maps, C classes, and R x W cells.

    Attributes:
        marks: (C, R, W): 1 at centers, less beside them, 0 elsewhere.
        cells: (M,) int64, the cell of each center, row by row.
        boxes: (M, 10).
        is_ignored: (R, W) bool, cells that ignored objects reach.
    """

    marks: Tensor
    cells: Tensor
    boxes: Tensor
    is_ignored: Tensor


def center_targets(sample: Sample, config: Config) -> CenterTargets:
    """Mark the centers of a sample's objects that lie in the maps."""
    rows, columns = output_size(config)
    place_row, place_column = _places(sample.boxes_cam, config)
    is_inside = (place_row >= 0.0) & (place_row < rows) & (place_column >= 0.0) & (place_column < columns)
    boxes_cam, kinds = sample.boxes_cam[is_inside], sample.classes[is_inside] - 1
    place_row, place_column = place_row[is_inside], place_column[is_inside]
    row, column = place_row.floor(), place_column.floor()
    spread = (boxes_cam[:, 4] * (config.center.spread / _cell_m(config))).clamp(min=config.center.min_spread_cells)
    down = torch.arange(rows, device=row.device) - row[:, None]
    right = torch.arange(columns, device=row.device) - column[:, None]
    bump_down, bump_right = (torch.exp(-(d * d) / (2.0 * spread * spread)[:, None]) for d in (down, right))
    bumps = bump_down[:, :, None] * bump_right[:, None, :]
    marks = boxes_cam.new_zeros((len(config.classes), rows, columns))
    for kind in set(kinds.tolist()):
        marks[kind] = bumps[kinds == kind].amax(dim=0)
    marks[marks < _LEAST_MARK] = 0.0
    bottom_m = boxes_cam[:, :3] @ sample.plane[:3] + sample.plane[3]
    sizes = torch.log(boxes_cam[:, 3:6] / mean_sizes(config, kinds))
    heading = boxes_cam[:, 6]
    numbers = [
        place_row - row - 0.5,
        place_column - column - 0.5,
        bottom_m,
        *sizes.unbind(dim=1),
        torch.sin(2.0 * heading),
        torch.cos(2.0 * heading),
        torch.sin(heading),
        torch.cos(heading),
    ]
    cells = (row * columns + column).long()
    return CenterTargets(marks, cells, torch.stack(numbers, dim=1), _ignored_cells(sample, config))


def boxes_from_cells(cells: Tensor, numbers: Tensor, kinds: Tensor, plane: Tensor, config: Config) -> Tensor:
    """Decode boxes (N, 7) from their cells (N,), their numbers (N, 10) and their classes, counted from 0."""
    _, columns = output_size(config)
    cell_m = _cell_m(config)
    x = config.bev.x_m[0] + (cells % columns + 0.5 + numbers[:, 1]) * cell_m
    z = config.bev.z_m[1] - (cells // columns + 0.5 + numbers[:, 0]) * cell_m
    y = ground_y(x, z, plane) + numbers[:, 2] / plane[1]
    sizes = mean_sizes(config, kinds) * torch.exp(numbers[:, 3:6].clamp(-1.0, 1.0))
    axis = torch.atan2(numbers[:, 6], numbers[:, 7]) / 2.0
    is_ahead = torch.sin(axis) * numbers[:, 8] + torch.cos(axis) * numbers[:, 9] >= 0.0
    heading = wrap_angle(torch.where(is_ahead, axis, axis + torch.pi))
    return torch.cat([torch.stack([x, y, z], dim=1), sizes, heading[:, None]], dim=1)


def output_size(config: Config) -> tuple[int, int]:
    """Return the rows and columns of the output."""
    _, rows, columns = config.bev.shape
    return rows // OUTPUT_STRIDE, columns // OUTPUT_STRIDE


def mean_sizes(config: Config, kinds: Tensor) -> Tensor:
    """Return the mean of the sizes (l, w, h) that the anchors of classes (N,), counted from 0, take: (N, 3)."""
    sizes = torch.stack([torch.tensor(item.anchor_sizes_lwh_m).mean(dim=0) for item in config.classes])
    return sizes.to(kinds.device)[kinds]


def _ignored_cells(sample: Sample, config: Config) -> Tensor:
    rows, columns = output_size(config)
    place_row, place_column = _places(sample.ignored_cam, config)
    down = torch.arange(rows, device=place_row.device) + 0.5 - place_row[:, None]
    right = torch.arange(columns, device=place_row.device) + 0.5 - place_column[:, None]
    reach = sample.ignored_cam[:, 3] / (2.0 * _cell_m(config))
    is_near = down[:, :, None] ** 2 + right[:, None, :] ** 2 < (reach**2)[:, None, None]
    return is_near.any(dim=0)


def _places(boxes_cam: Tensor, config: Config) -> tuple[Tensor, Tensor]:
    cell_m = _cell_m(config)
    return (config.bev.z_m[1] - boxes_cam[:, 2]) / cell_m, (boxes_cam[:, 0] - config.bev.x_m[0]) / cell_m


def _cell_m(config: Config) -> float:
    return config.bev.cell_m * OUTPUT_STRIDE
