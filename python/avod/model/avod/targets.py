"""Training targets of anchors and proposals, and which of them the losses use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import torch
from torch import Tensor

from avod.config import RpnConfig, SecondStageConfig
from avod.data.sample import Sample
from avod.geometry.encoding import (
    anchors_from_boxes,
    anchors_from_offsets,
    boxes_4c_from_boxes,
    offsets_from_anchors,
)
from avod.geometry.orientation import angle_vectors
from avod.geometry.projection import ground_boxes
from avod.ops import axis_aligned_iou

_TRUTH_NOISE: Final = 0.15
"""Standard deviation of the largest noise of `truth_proposals`: of shifts over the box's size, and of the logarithms of
its length, height and width."""


@dataclass(frozen=True, eq=False)
class AnchorTargets:
    """Of the sampled anchors.

    Attributes:
        chosen: (S,) int64, their indices.
        is_object: (S,) bool.
        offsets: (S, 6) to the object of largest overlap; zeros where nothing overlaps.
    """

    chosen: Tensor
    is_object: Tensor
    offsets: Tensor


@dataclass(frozen=True, eq=False)
class ProposalTargets:
    """Of the sampled proposals.

    Attributes:
        labels: (S,) int64: 0 background, else the class.
        boxes_4c: (S, 10) of the object of largest overlap; of no meaning for background.
        vectors: (S, 2) of its heading, likewise.
    """

    labels: Tensor
    boxes_4c: Tensor
    vectors: Tensor


def anchor_targets(sample: Sample, config: RpnConfig, generator: torch.Generator) -> AnchorTargets:
    """Compare a sample's anchors with its objects, seen from above and turned to the axes, and draw a mini-batch.

    Every label of the classes counts, however hidden. An object whose best anchor overlaps too little has no positive.

    Args:
        sample: the sample.
        config: thresholds and size of the mini-batch.
        generator: on the CPU.
    """
    objects = anchors_from_boxes(sample.boxes_cam)
    overlap, nearest = _best_overlap(sample.anchors, objects)
    overlap = torch.round(overlap, decimals=3)
    is_negative = _is_background(overlap, sample.anchors, sample, config.negative_iou)
    chosen = _draw(overlap > config.positive_iou, is_negative, config.batch_size, generator)
    offsets = sample.anchors.new_zeros((len(chosen), 6))
    if len(objects) > 0:
        to_nearest = offsets_from_anchors(sample.anchors[chosen], objects[nearest[chosen]])
        offsets = torch.where(overlap[chosen, None] > 0.0, to_nearest, offsets)
    return AnchorTargets(chosen, overlap[chosen] > config.positive_iou, offsets)


def truth_proposals(sample: Sample, count: int, generator: torch.Generator) -> Tensor:
    """Draw proposals about a sample's objects: `count` copies of each box, moved and scaled a little.

    Copies differ by how much: some lie on the object, and some hardly overlap it enough to be positive.

    Args:
        sample: the sample, with M objects.
        count: copies of each.
        generator: on the CPU.

    Returns:
        (M * count, 6) anchors.
    """
    anchors = anchors_from_boxes(sample.boxes_cam).repeat_interleave(count, dim=0)
    how_much = torch.rand((len(anchors), 1), generator=generator)
    offsets = torch.randn((len(anchors), 6), generator=generator) * how_much * _TRUTH_NOISE
    return anchors_from_offsets(anchors, offsets.to(anchors))


def sample_proposals(
    proposals: Tensor, sample: Sample, config: SecondStageConfig, generator: torch.Generator
) -> tuple[Tensor, ProposalTargets]:
    """Compare proposals with a sample's objects, and draw a mini-batch.

    Args:
        proposals: (P, 6) anchors.
        sample: the sample.
        config: thresholds and size of the mini-batch.
        generator: on the CPU.

    Returns:
        (S,) int64 indices of the drawn proposals, and their targets.
    """
    overlap, nearest = _best_overlap(proposals, anchors_from_boxes(sample.boxes_cam))
    is_negative = _is_background(overlap, proposals, sample, config.negative_iou)
    chosen = _draw(overlap > config.positive_iou, is_negative, config.batch_size, generator)
    is_object, nearest = overlap[chosen] > config.positive_iou, nearest[chosen]
    if len(sample.boxes_cam) == 0:
        labels = torch.zeros_like(nearest)
        return chosen, ProposalTargets(
            labels, proposals.new_zeros((len(chosen), 10)), proposals.new_zeros((len(chosen), 2))
        )
    labels = torch.where(is_object, sample.classes[nearest], 0)
    boxes_4c = boxes_4c_from_boxes(sample.boxes_cam, sample.plane)
    return chosen, ProposalTargets(labels, boxes_4c[nearest], angle_vectors(sample.boxes_cam)[nearest])


def _best_overlap(anchors: Tensor, objects: Tensor) -> tuple[Tensor, Tensor]:
    if len(objects) == 0:
        return anchors.new_zeros(len(anchors)), torch.zeros(len(anchors), dtype=torch.int64, device=anchors.device)
    overlap, nearest = axis_aligned_iou(ground_boxes(anchors), ground_boxes(objects)).max(dim=1)
    return overlap, nearest


def _is_background(overlap: Tensor, anchors: Tensor, sample: Sample, negative_iou: float) -> Tensor:
    """Tell which anchors (N, 6) overlap too little with objects, by `overlap`, and with what is ignored: (N,) bool."""
    ignored, _ = _best_overlap(anchors, anchors_from_boxes(sample.ignored_cam))
    return (overlap < negative_iou) & (ignored < negative_iou)


def _draw(is_positive: Tensor, is_negative: Tensor, batch_size: int, generator: torch.Generator) -> Tensor:
    """Draw up to half a mini-batch of positives, the rest of negatives: (S,) int64 indices, positives first."""
    positives = _shuffled(is_positive, generator)[: batch_size // 2]
    negatives = _shuffled(is_negative, generator)[: batch_size - len(positives)]
    return torch.cat([positives, negatives])


def _shuffled(mask: Tensor, generator: torch.Generator) -> Tensor:
    indices = mask.nonzero().squeeze(1)
    return indices[torch.randperm(len(indices), generator=generator).to(indices.device)]
