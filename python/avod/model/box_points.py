"""The points in and around boxes, in the boxes' own frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import torch
from torch import Tensor, nn
from torch.nn import functional

from avod.data.sample import Sample

_LOWEST_M: Final = -0.3
_HIGHEST_M: Final = 3.2
"""Heights over the ground between which points are looked at."""
_LEAST: Final = -5.0
"""The greatest of no points' features, and the least that counts."""


@dataclass(frozen=True, eq=False)
class BoxPoints:
    """Points of N boxes, box by box, in the scan's order.

    Attributes:
        box: (P,) int64, whose point it is.
        along, across, height: (P,) place along and across the box from its center, and over the ground, in meters.
        num_boxes: N.
    """

    box: Tensor
    along: Tensor
    across: Tensor
    height: Tensor
    num_boxes: int

    @cached_property
    def counts(self) -> Tensor:
        """Points of each box: (N,)."""
        return torch.bincount(self.box, minlength=self.num_boxes)

    def where(self, is_taken: Tensor) -> BoxPoints:
        """Take some of the points: (P,) bool."""
        box, along, across, height = (values[is_taken] for values in (self.box, self.along, self.across, self.height))
        return BoxPoints(box, along, across, height, self.num_boxes)

    def at_most(self, most: int) -> BoxPoints:
        """Take so many points of each box at most, evenly along the scan's order."""
        counts = self.counts
        number = torch.arange(len(self.box), device=self.box.device) - (counts.cumsum(0) - counts)[self.box]
        steps = counts[self.box].clamp(min=most)
        slot = number * most // steps
        return self.where((counts[self.box] <= most) | (number == 0) | (slot != (number - 1) * most // steps))


def points_near(sample: Sample, boxes_cam: Tensor, margin_m: float) -> BoxPoints:
    """Find the points in boxes (N, 7) and so far beyond their sides."""
    heights = sample.points_cam @ sample.plane[:3] + sample.plane[3]
    is_between = (heights > _LOWEST_M) & (heights < _HIGHEST_M)
    points_cam, heights = sample.points_cam[is_between], heights[is_between]
    half = boxes_cam[:, 3:5] / 2.0 + margin_m
    # Squares about all boxes first: of their points few are looked at twice.
    reach = torch.hypot(half[:, 0], half[:, 1])[:, None]
    is_close = (points_cam[:, 0] - boxes_cam[:, 0, None]).abs_() < reach
    is_close &= (points_cam[:, 2] - boxes_cam[:, 2, None]).abs_() < reach
    box, point = is_close.nonzero(as_tuple=True)
    shift = points_cam[point] - boxes_cam[box, :3]
    along, across = turned(shift[:, 0], shift[:, 2], boxes_cam[box, 6])
    is_near = (along.abs() < half[box, 0]) & (across.abs() < half[box, 1])
    return BoxPoints(box, along, across, heights[point], len(boxes_cam)).where(is_near)


def turned(x: Tensor, z: Tensor, rotation_y: Tensor) -> tuple[Tensor, Tensor]:
    """Give directions of the cam frame along and across boxes."""
    cos, sin = torch.cos(rotation_y), torch.sin(rotation_y)
    return cos * x - sin * z, sin * x + cos * z


def greatest(values: Tensor, box: Tensor, least: Tensor) -> Tensor:
    """Find the greatest of each box's points and of the least that counts: (P, C), (P,) and (N, 1) to (N, C)."""
    least = least.expand(-1, values.shape[1])
    return least.scatter_reduce(0, box[:, None].expand_as(values), values, "amax")


class PointLayers(nn.Module):
    """Layers for each point, and the greatest of each box's points: twice, so that points know of the others.

    What is known of the boxes by itself is joined to the result.

    Args:
        num_in: features of a point.
        channels: of each point after each layer.

    Reference: Qi et al., "PointNet" (CVPR 2017).
    """

    def __init__(self, num_in: int, channels: Sequence[int]) -> None:
        super().__init__()
        first, second, third = channels
        self.before = nn.ModuleList([nn.Linear(num_in, first), nn.Linear(first, second)])
        self.after = nn.ModuleList([nn.Linear(2 * second, third), nn.Linear(third, third)])
        self.norms = nn.ModuleList([nn.LayerNorm(first), nn.LayerNorm(second), nn.LayerNorm(third)])

    def forward(self, features: Tensor, box: Tensor, seen: Tensor) -> Tensor:
        """Map points' features (P, num_in), their boxes (P,), and what is known of boxes (N, K) to (N, C + K)."""
        hidden = features
        for layer, norm in zip(self.before, self.norms[:2], strict=True):
            hidden = functional.relu(norm(layer(hidden)))
        least = seen.new_full((len(seen), 1), _LEAST)
        hidden = torch.cat([hidden, greatest(hidden, box, least)[box]], dim=1)
        hidden = functional.relu(self.norms[2](self.after[0](hidden)))
        return torch.cat([greatest(self.after[1](hidden), box, least), seen], dim=1)
