"""The losses of both stages."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from torch import Tensor
from torch.nn import functional

from avod.config import Config
from avod.data.sample import Sample
from avod.geometry.encoding import boxes_4c_from_anchors
from avod.model.avod.outputs import FrameOutputs
from avod.model.avod.targets import AnchorTargets, ProposalTargets


@dataclass(frozen=True, eq=False)
class Losses:
    """Scalars, weights applied.

    Attributes:
        objectness: of the first stage.
        anchor: the first stage's boxes.
        classification: of the second stage.
        box: the second stage's corners and heights.
        orientation: the second stage's angle vectors.
    """

    objectness: Tensor
    anchor: Tensor
    classification: Tensor
    box: Tensor
    orientation: Tensor

    def by_name(self) -> dict[str, Tensor]:
        """Return the terms by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}


def frame_losses(outputs: FrameOutputs, anchors: AnchorTargets, sample: Sample, config: Config) -> Losses:
    """Compute the losses of a frame in training.

    Args:
        outputs: of the network, with targets.
        anchors: the drawn anchors.
        sample: the sample.
        config: weights and smoothing.
    """
    assert outputs.targets is not None
    smoothing = config.training.label_smoothing
    objectness, anchor = rpn_losses(outputs, anchors, smoothing)
    classification, box, orientation = second_stage_losses(outputs, outputs.targets, sample.plane, smoothing)
    return Losses(
        objectness,
        anchor * config.rpn.regression_weight,
        classification,
        box * config.second_stage.regression_weight,
        orientation * config.second_stage.orientation_weight,
    )


def rpn_losses(outputs: FrameOutputs, targets: AnchorTargets, smoothing: float) -> tuple[Tensor, Tensor]:
    """Compute the first stage's losses before weighting.

    Objectness is the mean cross entropy against (1 - smoothing, smoothing). The box loss is the mean of each anchor's
    smooth L1 sum, weighted by its smoothed objectness; so negatives weigh `smoothing`, unless all are negative.

    Returns:
        Objectness and box loss.
    """
    logits, offsets = outputs.anchor_logits[targets.chosen], outputs.anchor_offsets[targets.chosen]
    objectness = smoothed_cross_entropy(logits, targets.is_object.long(), smoothing).sum() / max(len(logits), 1)
    weights = torch.where(targets.is_object, 1.0 - smoothing, smoothing).to(logits.dtype)
    errors = functional.smooth_l1_loss(offsets, targets.offsets, reduction="none").sum(dim=1)
    return objectness, (errors * weights).sum() / weights.sum().clamp(min=1e-6)


def second_stage_losses(
    outputs: FrameOutputs, targets: ProposalTargets, plane: Tensor, smoothing: float
) -> tuple[Tensor, Tensor, Tensor]:
    """Compute the second stage's losses before weighting.

    Returns:
        Mean cross entropy over all proposals; smooth L1 sums of boxes and of angle vectors over the number of proposals
        that are no background, 0 if there are none.
    """
    classification = smoothed_cross_entropy(outputs.class_logits, targets.labels, smoothing).sum()
    is_object = targets.labels > 0
    num_objects = is_object.sum().clamp(min=1)
    box_targets = targets.boxes_4c - boxes_4c_from_anchors(outputs.proposals, plane)
    box_errors = functional.smooth_l1_loss(outputs.box_offsets, box_targets, reduction="none").sum(dim=1)
    vector_errors = functional.smooth_l1_loss(outputs.vectors, targets.vectors, reduction="none").sum(dim=1)
    zero = torch.zeros_like(box_errors)
    return (
        classification / max(len(targets.labels), 1),
        torch.where(is_object, box_errors, zero).sum() / num_objects,
        torch.where(is_object, vector_errors, zero).sum() / num_objects,
    )


def smoothed_cross_entropy(logits: Tensor, labels: Tensor, smoothing: float) -> Tensor:
    """Compute softmax cross entropy against 1 - smoothing for the label and the rest shared among the others.

    Args:
        logits: (N, K).
        labels: (N,) int64.
        smoothing: 0..1.

    Returns:
        (N,).
    """
    num_classes = logits.shape[1]
    log_probabilities = functional.log_softmax(logits, dim=1)
    share = smoothing / (num_classes - 1)
    right = log_probabilities.gather(1, labels[:, None]).squeeze(1)
    return -(1.0 - smoothing - share) * right - share * log_probabilities.sum(dim=1)
