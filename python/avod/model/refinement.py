"""A last stage that corrects boxes by the points in and around them, whatever network found them.

Reference: Li et al., "LiDAR R-CNN: An Efficient and Universal 3D Object Detector" (CVPR 2021).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, cast

import torch
from torch import Tensor, nn
from torch.nn import functional

from avod.config import RefinementConfig
from avod.data.sample import Sample
from avod.geometry.encoding import MIN_SIZE_M, ground_y
from avod.geometry.orientation import angle_vectors, fix_up, wrap_angle
from avod.model.box_points import BoxPoints, PointLayers, greatest, points_near, turned
from avod.model.heading import PointHeading, heading_loss, heading_vectors, reversals
from avod.model.layers import Head
from avod.model.parts import EXAMPLE_ROWS, Part

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
_LONG: Final = 2.0
"""Boxes that are longer, in widths, are cars and bicycles, whose axis is plain to see."""
_FARTHEST_M: Final = 40.0


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
        heading_losses: (N,) of those that have an object.
    """

    found: Tensor
    wanted: Tensor
    has_object: Tensor
    quality_logits: Tensor
    qualities: Tensor
    heading_losses: Tensor

    def loss(self) -> Tensor:
        """Compute the smooth L1 sum of corrections, and cross entropies of headings and of qualities.

        The first two are means over those with an object.

        Reference of the qualities: Jiang et al., "IoU-Net" (ECCV 2018), scaled as in PV-RCNN (Shi et al., CVPR 2020).
        """
        errors = functional.smooth_l1_loss(self.found, self.wanted, beta=_SMOOTHING, reduction="none").sum(dim=1)
        errors = torch.where(self.has_object, errors + self.heading_losses, 0.0)
        correction = errors.sum() / self.has_object.sum().clamp(min=1)
        judgment = functional.binary_cross_entropy_with_logits(self.quality_logits, self.qualities, reduction="sum")
        return correction + _QUALITY_WEIGHT * judgment / max(len(self.qualities), 1)


@dataclass(frozen=True, eq=False)
class _Look:
    """What a look at the points of N boxes says.

    Attributes:
        corrections: (N, 7), in units of `_SCALES`.
        quality_logits: (N,).
        reversal_logits: (N, 12), of observation angles, by the points in the box's frame.
        near: the points.
        seen: (N, 9), what `box_features` gives.
    """

    corrections: Tensor
    quality_logits: Tensor
    reversal_logits: Tensor
    near: BoxPoints
    seen: Tensor

    @cached_property
    def has_points(self) -> Tensor:
        """Whether boxes have enough points to say so: (N,) bool."""
        return self.near.counts >= _LEAST_POINTS

    def corrected(self, boxes_cam: Tensor, plane: Tensor) -> Tensor:
        """Apply the corrections to the boxes (N, 7)."""
        limits = boxes_cam.new_tensor(_MOST)
        corrections = (self.corrections * boxes_cam.new_tensor(_SCALES)).clamp(-limits, limits)
        return corrected(boxes_cam, corrections, plane)


class PointRefinement(nn.Module):
    """Corrects boxes by the points in and around them.

    Args:
        config: of the stage.
    """

    def __init__(self, config: RefinementConfig) -> None:
        super().__init__()
        self.config = config
        self.points = PointLayers(_POINT_FEATURES, config.channels)
        self.head = Head(config.channels[-1] + _BOX_FEATURES, config.hidden, (len(_SCALES), 1, 1), 1.0)
        self.heading = PointHeading(config)
        nn.init.zeros_(cast("nn.Linear", self.head.outputs[0]).weight)

    def forward(self, sample: Sample, boxes_cam: Tensor, passes: int = 1) -> tuple[Tensor, Tensor]:
        """Correct boxes so often, make the side that both views point to their front, and judge them.

        Args:
            sample: the sample.
            boxes_cam: (N, 7).
            passes: 1 or more.

        Returns:
            (N, 7) boxes, those with hardly a point as they were, and (N,) the quality of each, 0..1.
        """
        for _ in range(passes):
            found_cam, look = boxes_cam, self._look(sample, boxes_cam, None)
            boxes_cam = torch.where(look.has_points[:, None], look.corrected(found_cam, sample.plane), found_cam)
        # Not before: what is wanted of a box that lies across its object is not learned.
        logits = self.heading(look.near, found_cam, look.seen) + look.reversal_logits
        headed_cam = _headed(boxes_cam, heading_vectors(logits, found_cam))
        boxes_cam = torch.where(look.has_points[:, None], headed_cam, boxes_cam)
        return boxes_cam, torch.where(look.has_points, torch.sigmoid(look.quality_logits), 0.0)

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
        # Each by itself: where the box's frame tells cars' headings, the line of sight would learn no shapes.
        heading_logits = self.heading(look.near, boxes_cam, look.seen)
        heading_losses = heading_loss(heading_logits, truths) + heading_loss(look.reversal_logits, truths)
        every = look.corrections, wanted, has_object, look.quality_logits, qualities, heading_losses
        return RefinementOutputs(*(values[chosen] for values in every))

    def _look(self, sample: Sample, boxes_cam: Tensor, generator: torch.Generator | None) -> _Look:
        """Look at the points of boxes (N, 7); with a generator some are left out, a share drawn for each box."""
        near = points_near(sample, boxes_cam, self.config.margin_m)
        if generator is not None:
            kept_shares = 0.3 + 0.9 * torch.rand(len(boxes_cam), generator=generator)
            is_kept = torch.rand(len(near.box), generator=generator) < kept_shares[near.box.cpu()]
            near = near.where(is_kept.to(near.box.device))
        points = near.at_most(self.config.max_points)
        seen = box_features(points, near.counts, sample, boxes_cam)
        features = point_features(points, boxes_cam)
        corrections, quality_logits, reversed_logits = self.judge(features, points.box, seen)
        return _Look(corrections, quality_logits, reversals(reversed_logits, boxes_cam), near, seen)

    def parts(self) -> tuple[Part, Part]:
        """Describe what `judge` and that of the headings compute."""
        inputs = {
            "features": torch.zeros((EXAMPLE_ROWS, _POINT_FEATURES)),
            "box": torch.zeros(EXAMPLE_ROWS, dtype=torch.int64),
            "seen": torch.zeros((EXAMPLE_ROWS, _BOX_FEATURES)),
        }
        outputs = ("corrections", "quality_logits", "reversed_logits")
        return Part("refinement", self.judge, inputs, outputs, has_rows=True), self.heading.part()

    def judge(self, features: Tensor, box: Tensor, seen: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Run the layers.

        Args:
            features: (P, 7) what `point_features` gives.
            box: (P,) int64, whose point it is.
            seen: (N, 9) what `box_features` gives.

        Returns:
            Corrections (N, 7), in units of `_SCALES`, and logits of qualities (N,) and of reversals (N,), above 0 where
            the front is the box's rear.
        """
        corrections, qualities, turns = self.head(self.points(features, box, seen))
        return corrections, qualities.squeeze(1), turns.squeeze(1)


def corrections_to(boxes_cam: Tensor, truths_cam: Tensor, plane: Tensor) -> Tensor:
    """Tell what makes boxes into others: (N, 7) and (N, 7) to (N, 7) as `_SCALES` names it.

    Which end is the front is not corrected: turns are those to the nearer of both headings.
    """
    shift = truths_cam[:, :3] - boxes_cam[:, :3]
    along, across = turned(shift[:, 0], shift[:, 2], boxes_cam[:, 6])
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


def _headed(boxes_cam: Tensor, vectors: Tensor) -> Tensor:
    """Make the sides that vectors (N, 2) [cos, sin] point to the fronts of boxes (N, 7), of long ones an end."""
    axes = angle_vectors(boxes_cam)
    is_long = boxes_cam[:, 3:4] > _LONG * boxes_cam[:, 4:5]
    return fix_up(boxes_cam, torch.where(is_long, (axes * vectors).sum(dim=1, keepdim=True) * axes, vectors))


def _nearest(boxes_cam: Tensor, truths_cam: Tensor) -> tuple[Tensor, Tensor]:
    """Find the true box whose center is nearest to each (N, 7), and whether both overlap enough: (N, 7) and (N,)."""
    if len(truths_cam) == 0:
        return boxes_cam, torch.zeros(len(boxes_cam), dtype=torch.bool, device=boxes_cam.device)
    nearest = truths_cam[torch.cdist(boxes_cam[:, [0, 2]], truths_cam[:, [0, 2]]).argmin(dim=1)]
    return nearest, _overlap(boxes_cam, nearest) > _LEAST_OVERLAP


def _overlap(boxes_cam: Tensor, truths_cam: Tensor) -> Tensor:
    """Compute the intersection over union in 3D of boxes and others (N, 7), as if both had the others' headings."""
    shift = boxes_cam[:, :3] - truths_cam[:, :3]
    along, across = turned(shift[:, 0], shift[:, 2], truths_cam[:, 6])
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


def point_features(points: BoxPoints, boxes_cam: Tensor) -> Tensor:
    """Tell where points are in their boxes: (P, 7)."""
    u, v = points.along, points.across
    length, width = boxes_cam[points.box, 3] / 2.0, boxes_cam[points.box, 4] / 2.0
    return torch.stack([u, v, points.height, u / length, v / width, length - u.abs(), width - v.abs()], dim=1)


def box_features(points: BoxPoints, counts: Tensor, sample: Sample, boxes_cam: Tensor) -> Tensor:
    """Tell how a box stands to the sensor, how many points it has, how large it is, and how high they are: (N, 9)."""
    to_sensor = -boxes_cam[:, :3]
    distance_m = torch.hypot(to_sensor[:, 0], to_sensor[:, 2]).clamp(min=1.0)
    along, across = turned(to_sensor[:, 0], to_sensor[:, 2], boxes_cam[:, 6])
    top_m = greatest(points.height[:, None], points.box, boxes_cam.new_zeros((len(boxes_cam), 1)))[:, 0]
    bottom_m = boxes_cam[:, :3] @ sample.plane[:3] + sample.plane[3]
    seen = [distance_m / _FARTHEST_M, along / distance_m, across / distance_m, torch.log1p(counts) / 5.0]
    return torch.stack([*seen, *boxes_cam[:, 3:6].unbind(dim=1), bottom_m, top_m], dim=1)
