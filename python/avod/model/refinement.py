"""A last stage that corrects boxes by the points in and around them, whatever network found them.

Reference: Li et al., "LiDAR R-CNN: An Efficient and Universal 3D Object Detector" (CVPR 2021).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, cast

import torch
from torch import Tensor, nn
from torch.nn import functional

from avod.config import RefinementConfig
from avod.data.sample import Sample
from avod.geometry.encoding import MIN_SIZE_M, ground_y
from avod.geometry.orientation import wrap_angle
from avod.model.layers import Head
from avod.model.parts import EXAMPLE_ROWS, Part

_LOWEST_M: Final = -0.3
_HIGHEST_M: Final = 3.2
"""Heights over the ground between which points are looked at."""
_LEAST_POINTS: Final = 3
"""Boxes of fewer points are left as they are."""
_SCALES: Final = (0.2, 0.2, 0.1, 0.08, 0.06, 0.06, 0.08)
"""Spread of what is corrected: along and across (m), bottom (m), logarithms of length, width and height, turn (rad)."""
_MOST: Final = (1.0, 1.0, 0.5, 0.8, 0.8, 0.5, 1.5)
"""Nothing is corrected by more."""
_NOISE_M: Final = (0.07, 0.06, 0.12, 0.32, 0.10, 0.10, 0.28)
"""Standard deviation of copies of true boxes: along, across, bottom, length, width, height, and of one end sideways, so
that short boxes are turned more; drawn for each copy between nothing and twice this ..."""
_NOISE_OF_SIZE: Final = 0.045
"""... and what it grows by along and across, as a share of length and width."""
_POINT_FEATURES: Final = 7
_BOX_FEATURES: Final = 9
_SMOOTHING: Final = 0.3
_QUALITY_WEIGHT: Final = 2.0
_LEAST_OVERLAP: Final = 0.2
"""Found boxes that overlap an object by less have none."""
_FARTHEST_M: Final = 40.0
_LEAST: Final = -5.0
"""The greatest of no points' features, and the least that counts."""


@dataclass(frozen=True, eq=False)
class RefinementOutputs:
    """Corrections and judgments of moved copies of true boxes and of found ones.

    Attributes:
        found: (N, 7), in units of `_SCALES`.
        wanted: (N, 7), of those that have an object.
        has_object: (N,) bool.
        quality_logits: (N,).
        qualities: (N,) what they should be: 0 for an overlap of the corrected box in 3D of a quarter or less, 1 for one
            of three quarters or more.
        reversed_logits: (N,).
        is_reversed: (N,) bool, whether the object's front is the box's rear.
    """

    found: Tensor
    wanted: Tensor
    has_object: Tensor
    quality_logits: Tensor
    qualities: Tensor
    reversed_logits: Tensor
    is_reversed: Tensor

    def loss(self) -> Tensor:
        """Compute the smooth L1 sum of corrections, and cross entropies of reversals and of qualities.

        The first two are means over those with an object.

        Reference of the qualities: Jiang et al., "IoU-Net" (ECCV 2018), scaled as in PV-RCNN (Shi et al., CVPR 2020).
        """
        errors = functional.smooth_l1_loss(self.found, self.wanted, beta=_SMOOTHING, reduction="none").sum(dim=1)
        errors = errors + functional.binary_cross_entropy_with_logits(
            self.reversed_logits, self.is_reversed.to(errors), reduction="none"
        )
        correction = torch.where(self.has_object, errors, 0.0).sum() / self.has_object.sum().clamp(min=1)
        judgment = functional.binary_cross_entropy_with_logits(self.quality_logits, self.qualities, reduction="sum")
        return correction + _QUALITY_WEIGHT * judgment / max(len(self.qualities), 1)


@dataclass(frozen=True, eq=False)
class Points:
    """Points of N boxes, in the boxes' own frames, box by box.

    Attributes:
        features: (P, 7).
        box: (P,) int64, whose point it is.
        counts: (N,) points of each box, before some were left out.
    """

    features: Tensor
    box: Tensor
    counts: Tensor


@dataclass(frozen=True, eq=False)
class _Look:
    """What a look at the points of N boxes says.

    Attributes:
        corrections: (N, 7), in units of `_SCALES`.
        quality_logits: (N,).
        reversed_logits: (N,), above 0 where the front is the box's rear.
        has_points: (N,) bool, enough to say so.
    """

    corrections: Tensor
    quality_logits: Tensor
    reversed_logits: Tensor
    has_points: Tensor

    def corrected(self, boxes_cam: Tensor, plane: Tensor) -> Tensor:
        """Apply the corrections to the boxes (N, 7), and turn those whose front is their rear."""
        limits = boxes_cam.new_tensor(_MOST)
        corrections = (self.corrections * boxes_cam.new_tensor(_SCALES)).clamp(-limits, limits)
        corrections[:, 6] += math.pi * (self.reversed_logits > 0.0)
        return corrected(boxes_cam, corrections, plane)


class PointRefinement(nn.Module):
    """Corrects boxes by the points in and around them.

    Args:
        config: of the stage.
    """

    def __init__(self, config: RefinementConfig) -> None:
        super().__init__()
        self.config = config
        first, second, third = config.channels
        self.before = nn.ModuleList([nn.Linear(_POINT_FEATURES, first), nn.Linear(first, second)])
        self.after = nn.ModuleList([nn.Linear(2 * second, third), nn.Linear(third, third)])
        self.norms = nn.ModuleList([nn.LayerNorm(first), nn.LayerNorm(second), nn.LayerNorm(third)])
        self.head = Head(third + _BOX_FEATURES, config.hidden, (len(_SCALES), 1, 1), 1.0)
        nn.init.zeros_(cast("nn.Linear", self.head.outputs[0]).weight)

    def forward(self, sample: Sample, boxes_cam: Tensor, passes: int = 1) -> tuple[Tensor, Tensor]:
        """Correct boxes so often, and judge them.

        Args:
            sample: the sample.
            boxes_cam: (N, 7).
            passes: 1 or more.

        Returns:
            (N, 7) boxes, those with hardly a point as they were, and (N,) the quality of each, 0..1.
        """
        qualities = boxes_cam.new_zeros(len(boxes_cam))
        for _ in range(passes):
            look = self._look(sample, boxes_cam, None)
            boxes_cam = torch.where(look.has_points[:, None], look.corrected(boxes_cam, sample.plane), boxes_cam)
            qualities = torch.where(look.has_points, torch.sigmoid(look.quality_logits), 0.0)
        return boxes_cam, qualities

    def learned(self, sample: Sample, found_cam: Tensor, generator: torch.Generator) -> RefinementOutputs:
        """Correct and judge moved copies of a sample's true boxes, and boxes that were found.

        Args:
            sample: the sample.
            found_cam: (N, 7).
            generator: on the CPU; draws the copies, and which of the points are left out.
        """
        truths = sample.boxes_cam.repeat_interleave(self.config.copies, dim=0)
        nearest, is_near = _nearest(found_cam, sample.boxes_cam)
        boxes_cam = torch.cat([_moved(truths, sample.plane, generator), found_cam])
        truths = torch.cat([truths, nearest])
        has_object = torch.cat([is_near.new_ones(len(truths) - len(nearest)), is_near])
        look = self._look(sample, boxes_cam, generator)
        wanted = corrections_to(boxes_cam, truths, sample.plane) / boxes_cam.new_tensor(_SCALES)
        with torch.no_grad():
            overlap = _overlap(look.corrected(boxes_cam, sample.plane), truths)
            qualities = torch.where(has_object, (2.0 * overlap - 0.5).clamp(0.0, 1.0), 0.0)
        _, is_ignored = _nearest(boxes_cam, sample.ignored_cam)
        chosen = look.has_points & (has_object | ~is_ignored)
        is_reversed = torch.cos(truths[:, 6] - boxes_cam[:, 6]) < 0.0
        every = look.corrections, wanted, has_object, look.quality_logits, qualities, look.reversed_logits, is_reversed
        return RefinementOutputs(*(values[chosen] for values in every))

    def _look(self, sample: Sample, boxes_cam: Tensor, generator: torch.Generator | None) -> _Look:
        """Look at the points of boxes (N, 7); with a generator some are left out."""
        points = self._points(sample, boxes_cam, generator)
        seen = box_features(points, sample, boxes_cam)
        return _Look(*self.judge(points.features, points.box, seen), points.counts >= _LEAST_POINTS)

    def part(self) -> Part:
        """Describe what `judge` computes."""
        inputs = {
            "features": torch.zeros((EXAMPLE_ROWS, _POINT_FEATURES)),
            "box": torch.zeros(EXAMPLE_ROWS, dtype=torch.int64),
            "seen": torch.zeros((EXAMPLE_ROWS, _BOX_FEATURES)),
        }
        outputs = ("corrections", "quality_logits", "reversed_logits")
        return Part("refinement", self.judge, inputs, outputs, has_rows=True)

    def judge(self, features: Tensor, box: Tensor, seen: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Run the layers.

        Args:
            features: (P, 7) of points.
            box: (P,) int64, whose point it is.
            seen: (N, 9) what `box_features` gives.

        Returns:
            Corrections (N, 7), in units of `_SCALES`, logits of qualities (N,), and of reversals (N,).
        """
        hidden = features
        for layer, norm in zip(self.before, self.norms[:2], strict=True):
            hidden = functional.relu(norm(layer(hidden)))
        least = seen.new_full((len(seen), 1), _LEAST)
        hidden = torch.cat([hidden, _greatest(hidden, box, least)[box]], dim=1)
        hidden = functional.relu(self.norms[2](self.after[0](hidden)))
        whole = _greatest(self.after[1](hidden), box, least)
        corrections, qualities, reversals = self.head(torch.cat([whole, seen], dim=1))
        return corrections, qualities.squeeze(1), reversals.squeeze(1)

    def _points(self, sample: Sample, boxes_cam: Tensor, generator: torch.Generator | None) -> Points:
        """Gather the points of boxes; with a generator some are left out, a share drawn for each box."""
        most = self.config.max_points
        box, along, across, height = _near(sample, boxes_cam, self.config.margin_m)
        if generator is not None:
            kept_shares = 0.3 + 0.9 * torch.rand(len(boxes_cam), generator=generator)
            is_kept = torch.rand(len(box), generator=generator) < kept_shares[box.cpu()]
            box, along, across, height = (values[is_kept.to(box.device)] for values in (box, along, across, height))
        counts = torch.bincount(box, minlength=len(boxes_cam))
        number = torch.arange(len(box), device=box.device) - (counts.cumsum(0) - counts)[box]
        # Of more points than there is room for, as many as there is room for, evenly along the scan's order.
        steps = counts[box].clamp(min=most)
        slot = number * most // steps
        is_taken = (counts[box] <= most) | (number == 0) | (slot != (number - 1) * most // steps)
        box, u, v, height = (values[is_taken] for values in (box, along, across, height))
        length, width = boxes_cam[box, 3] / 2.0, boxes_cam[box, 4] / 2.0
        features = torch.stack([u, v, height, u / length, v / width, length - u.abs(), width - v.abs()], dim=1)
        return Points(features, box, counts)


def corrections_to(boxes_cam: Tensor, truths_cam: Tensor, plane: Tensor) -> Tensor:
    """Tell what makes boxes into others: (N, 7) and (N, 7) to (N, 7) as `_SCALES` names it.

    Which end is the front is not corrected: turns are those to the nearer of both headings.
    """
    shift = truths_cam[:, :3] - boxes_cam[:, :3]
    along, across = _turned(shift[:, 0], shift[:, 2], boxes_cam[:, 6])
    bottom = shift @ plane[:3]
    turn = torch.remainder(truths_cam[:, 6] - boxes_cam[:, 6] + math.pi / 2.0, math.pi) - math.pi / 2.0
    return torch.cat(
        [torch.stack([along, across, bottom], dim=1), torch.log(truths_cam[:, 3:6] / boxes_cam[:, 3:6]), turn[:, None]],
        dim=1,
    )


def corrected(boxes_cam: Tensor, corrections: Tensor, plane: Tensor) -> Tensor:
    """Apply what `corrections_to` tells: (N, 7) and (N, 7) to (N, 7)."""
    along, across, bottom = corrections[:, :3].unbind(dim=1)
    cos, sin = torch.cos(boxes_cam[:, 6]), torch.sin(boxes_cam[:, 6])
    x = boxes_cam[:, 0] + cos * along + sin * across
    z = boxes_cam[:, 2] - sin * along + cos * across
    height_m = boxes_cam[:, :3] @ plane[:3] + plane[3] + bottom
    y = ground_y(x, z, plane) + height_m / plane[1]
    sizes = (boxes_cam[:, 3:6] * torch.exp(corrections[:, 3:6])).clamp(min=MIN_SIZE_M)
    turned = wrap_angle(boxes_cam[:, 6] + corrections[:, 6])
    return torch.cat([torch.stack([x, y, z], dim=1), sizes, turned[:, None]], dim=1)


def _nearest(boxes_cam: Tensor, truths_cam: Tensor) -> tuple[Tensor, Tensor]:
    """Find the true box whose center is nearest to each (N, 7), and whether both overlap enough: (N, 7) and (N,)."""
    if len(truths_cam) == 0:
        return boxes_cam, torch.zeros(len(boxes_cam), dtype=torch.bool, device=boxes_cam.device)
    nearest = truths_cam[torch.cdist(boxes_cam[:, [0, 2]], truths_cam[:, [0, 2]]).argmin(dim=1)]
    return nearest, _overlap(boxes_cam, nearest) > _LEAST_OVERLAP


def _overlap(boxes_cam: Tensor, truths_cam: Tensor) -> Tensor:
    """Compute the intersection over union in 3D of boxes and others (N, 7), as if both had the others' headings."""
    shift = boxes_cam[:, :3] - truths_cam[:, :3]
    along, across = _turned(shift[:, 0], shift[:, 2], truths_cam[:, 6])
    half, half_true = boxes_cam[:, 3:5] / 2.0, truths_cam[:, 3:5] / 2.0
    place = torch.stack([along, across], dim=1)
    shared = torch.minimum(place + half, half_true) - torch.maximum(place - half, -half_true)
    low, low_true = boxes_cam[:, 1], truths_cam[:, 1]
    height = torch.minimum(low, low_true) - torch.maximum(low - boxes_cam[:, 5], low_true - truths_cam[:, 5])
    both = shared.clamp(min=0.0).prod(dim=1) * height.clamp(min=0.0)
    return both / (boxes_cam[:, 3:6].prod(dim=1) + truths_cam[:, 3:6].prod(dim=1) - both)


def _moved(boxes_cam: Tensor, plane: Tensor, generator: torch.Generator) -> Tensor:
    """Move, scale and turn boxes a little, half of them end to end."""
    count = len(boxes_cam)
    how_much = 2.0 * torch.rand((count, 1), generator=generator)
    spread = boxes_cam.new_tensor(_NOISE_M).repeat(count, 1)
    spread[:, :2] += _NOISE_OF_SIZE * boxes_cam[:, 3:5]
    spread[:, 3:] /= boxes_cam[:, [3, 4, 5, 3]]
    noise = (torch.randn(spread.shape, generator=generator) * how_much).to(boxes_cam) * spread
    noise[:, 6] += math.pi * torch.randint(2, (count,), generator=generator).to(boxes_cam)
    return corrected(boxes_cam, noise, plane)


def _near(sample: Sample, boxes_cam: Tensor, margin_m: float) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Find the points in and around boxes (N, 7), box by box, in the scan's order.

    Returns:
        Four times (K,): the box, and the point's place along and across it and over the ground.
    """
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
    along, across = _turned(shift[:, 0], shift[:, 2], boxes_cam[box, 6])
    is_near = (along.abs() < half[box, 0]) & (across.abs() < half[box, 1])
    return box[is_near], along[is_near], across[is_near], heights[point[is_near]]


def _turned(x: Tensor, z: Tensor, rotation_y: Tensor) -> tuple[Tensor, Tensor]:
    cos, sin = torch.cos(rotation_y), torch.sin(rotation_y)
    return cos * x - sin * z, sin * x + cos * z


def box_features(points: Points, sample: Sample, boxes_cam: Tensor) -> Tensor:
    """Tell how a box stands to the sensor, how large it is, and how high its points are: (N, 9)."""
    to_sensor = -boxes_cam[:, :3]
    distance_m = torch.hypot(to_sensor[:, 0], to_sensor[:, 2]).clamp(min=1.0)
    along, across = _turned(to_sensor[:, 0], to_sensor[:, 2], boxes_cam[:, 6])
    top_m = _greatest(points.features[:, 2:3], points.box, boxes_cam.new_zeros((len(boxes_cam), 1)))[:, 0]
    bottom_m = boxes_cam[:, :3] @ sample.plane[:3] + sample.plane[3]
    seen = [distance_m / _FARTHEST_M, along / distance_m, across / distance_m, torch.log1p(points.counts) / 5.0]
    return torch.stack([*seen, *boxes_cam[:, 3:6].unbind(dim=1), bottom_m, top_m], dim=1)


def _greatest(values: Tensor, box: Tensor, least: Tensor) -> Tensor:
    """Find the greatest of each box's points and of the least that counts: (P, C), (P,) and (N, 1) to (N, C)."""
    least = least.expand(-1, values.shape[1])
    return least.scatter_reduce(0, box[:, None].expand_as(values), values, "amax")
