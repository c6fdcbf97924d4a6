"""AVOD-FPN as a whole: from samples to proposals, classes, boxes and headings."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import cast

import torch
from torch import Tensor, nn

from avod.config import Config
from avod.data.sample import Sample
from avod.geometry.encoding import anchors_from_offsets, standing_anchors
from avod.geometry.height_profile import cell_tops, height_profiles
from avod.geometry.projection import bev_boxes, ground_boxes, image_boxes
from avod.model.avod.path_drop import detection_masks, draw_masks, fuse
from avod.model.avod.pyramid import FeaturePyramid
from avod.model.avod.targets import ProposalTargets, sample_proposals, truth_proposals
from avod.model.layers import Convolution, Head
from avod.ops import crop_and_resize, nms
from cadet._util.summary import summary

_NUM_ANCHOR_OFFSETS = 6
_NUM_BOX_OFFSETS = 10
_NUM_VECTOR = 2
_HEIGHT_SCALE = 2.0
"""Brings heights in meters to the spread of features."""


@dataclass(frozen=True, eq=False)
class FrameOutputs:
    """The network's outputs for one frame, N anchors and P proposals.

    Attributes:
        anchor_logits: (N, 2) of background and object.
        anchor_offsets: (N, 6).
        proposals: (P, 6) anchors as the first stage regresses them, best first; with targets those that were sampled.
        class_logits: (P, K + 1), background first.
        box_offsets: (P, 10) from the proposals' corners and heights, meters.
        vectors: (P, 2) of headings.
        targets: what the proposals should become; None where nothing is drawn.
    """

    anchor_logits: Tensor
    anchor_offsets: Tensor
    proposals: Tensor
    class_logits: Tensor
    box_offsets: Tensor
    vectors: Tensor
    targets: ProposalTargets | None = None

    def __repr__(self) -> str:
        return summary(self, **{f.name: getattr(self, f.name) for f in fields(self)[:-1]})


@dataclass(frozen=True, eq=False)
class FrameFeatures:
    """The feature maps of one frame.

    Attributes:
        bev: (C, H, W).
        image: (C, h, w).
        bev_bottleneck: (B, H, W), for the first stage, B `bottleneck_channels`.
        image_bottleneck: (B, h, w), likewise.
    """

    bev: Tensor
    image: Tensor
    bev_bottleneck: Tensor
    image_bottleneck: Tensor

    def __repr__(self) -> str:
        return summary(self, **{f.name: getattr(self, f.name) for f in fields(self)})


class AvodNetwork(nn.Module):
    """AVOD-FPN.

    Args:
        config: the detector.
    """

    mean_rgb: Tensor

    def __init__(self, config: Config) -> None:
        super().__init__()
        self.config = config
        width = config.extractor.fused_channels[-1]
        rpn, second = config.rpn, config.second_stage
        self.bev_pyramid = FeaturePyramid(config.bev.shape[0], config.extractor)
        self.image_pyramid = FeaturePyramid(3, config.extractor)
        self.bev_bottleneck = Convolution(width, rpn.bottleneck_channels, config.extractor, kernel=1)
        self.image_bottleneck = Convolution(width, rpn.bottleneck_channels, config.extractor, kernel=1)
        hidden = (rpn.hidden, rpn.hidden)
        num_cropped = rpn.bottleneck_channels * rpn.crop_size**2
        self.anchor_classifier = Head(num_cropped, hidden, (2,), rpn.dropout_keep)
        self.anchor_regressor = Head(num_cropped, hidden, (_NUM_ANCHOR_OFFSETS,), rpn.dropout_keep)
        num_heights = second.height_cells**2 + 1 if second.height_cells else 0
        self.second_stage = Head(
            width * second.crop_size**2 + num_heights,
            second.hidden,
            (len(config.classes) + 1, _NUM_BOX_OFFSETS, _NUM_VECTOR),
            second.dropout_keep,
        )
        mean = torch.tensor(config.image.mean_rgb).view(3, 1, 1)
        self.register_buffer("mean_rgb", mean, persistent=False)
        # Channels last is what convolutions on processors with bf16 and on GPUs like, and what crops read.
        self.to(memory_format=torch.channels_last)
        self.precision: torch.dtype | None = None
        """Type of the convolutions' and layers' arithmetic; None for float32. Boxes are always float32."""

    def forward(
        self,
        samples: Sequence[Sample],
        generator: torch.Generator | None = None,
        *,
        has_truths: bool = False,
        config: Config | None = None,
    ) -> list[FrameOutputs]:
        """Run both stages on each sample.

        Args:
            samples: one or more.
            generator: on the CPU; draws path drop and the second stage's mini-batch. Needed in training mode; in
                evaluation mode outputs have targets if it is given, and no path is dropped.
            has_truths: with a generator, copies of the true boxes join the proposals.
            config: other settings of a network with the same weights, such as the number of proposals; None for the
                network's own.

        Returns:
            The outputs of each sample.
        """
        return [
            self.judge(sample, features, generator, has_truths=has_truths, config=config)
            for sample, features in zip(samples, self.extract(samples), strict=True)
        ]

    def extract(self, samples: Sequence[Sample]) -> list[FrameFeatures]:
        """Make the feature maps of samples."""
        with self._arithmetic(samples[0].bev):
            bev = self.bev_pyramid(_stacked([sample.bev for sample in samples]))
            image = self.image_pyramid(_stacked([sample.image for sample in samples]) - self.mean_rgb)
            bev_bottleneck, image_bottleneck = self.bev_bottleneck(bev), self.image_bottleneck(image)
        return [FrameFeatures(*maps) for maps in zip(bev, image, bev_bottleneck, image_bottleneck, strict=True)]

    def judge(
        self,
        sample: Sample,
        features: FrameFeatures,
        generator: torch.Generator | None = None,
        *,
        has_truths: bool = False,
        config: Config | None = None,
    ) -> FrameOutputs:
        """Run both stages on the feature maps of a sample; arguments as for `forward`."""
        config = self.config if config is None else config
        masks = detection_masks(config.path_drop)
        if self.training:
            assert generator is not None
            masks = draw_masks(config.path_drop, generator)
        anchor_logits, anchor_offsets = self._judge_anchors(sample, features, masks)
        regressed = anchors_from_offsets(sample.anchors, anchor_offsets)
        scores = anchor_logits.softmax(dim=1)[:, 1]
        count = config.rpn.proposals if generator is None else config.rpn.train_proposals
        proposals = regressed[nms(ground_boxes(regressed), scores, config.rpn.nms_iou, count)]
        targets = None
        if generator is not None:
            if has_truths:
                truths = truth_proposals(sample, config.second_stage.truth_proposals, generator)
                proposals = torch.cat([proposals, truths])
            chosen, targets = sample_proposals(proposals.detach(), sample, config.second_stage, generator)
            proposals = proposals[chosen]
        if config.second_stage.gradient == "stopped":
            proposals = proposals.detach()
        heights = None
        if config.second_stage.height_cells:
            tops_m = cell_tops(sample.bev, config.bev)
            heights = height_profiles(tops_m, proposals.detach(), config.bev, config.second_stage.height_cells)
            least_m, most_m = config.second_stage.standing_heights_m
            if most_m > 0.0:
                proposals = standing_anchors(proposals, sample.plane, heights[:, -1].clamp(least_m, most_m))
        class_logits, box_offsets, vectors = self._judge_proposals(sample, features, proposals, heights, masks)
        return FrameOutputs(anchor_logits, anchor_offsets, proposals, class_logits, box_offsets, vectors, targets)

    def _judge_anchors(
        self, sample: Sample, features: FrameFeatures, masks: tuple[float, float]
    ) -> tuple[Tensor, Tensor]:
        crops = self._crops(
            sample, sample.anchors, features.image_bottleneck, features.bev_bottleneck, masks, self.config.rpn.crop_size
        )
        with self._arithmetic(crops):
            (logits,) = cast("tuple[Tensor]", self.anchor_classifier(crops))
            (offsets,) = cast("tuple[Tensor]", self.anchor_regressor(crops))
        return logits.to(crops.dtype), offsets.to(crops.dtype)

    def _judge_proposals(
        self,
        sample: Sample,
        features: FrameFeatures,
        proposals: Tensor,
        heights: Tensor | None,
        masks: tuple[float, float],
    ) -> tuple[Tensor, Tensor, Tensor]:
        crops = self._crops(sample, proposals, features.image, features.bev, masks, self.config.second_stage.crop_size)
        if heights is not None:
            crops = torch.cat([crops, heights * (_HEIGHT_SCALE * float(masks[1] > 0.0))], dim=1)
        with self._arithmetic(crops):
            outputs = self.second_stage(crops)
        logits, offsets, vectors = (output.to(crops.dtype) for output in outputs)
        return logits, offsets, vectors

    def _crops(
        self,
        sample: Sample,
        anchors: Tensor,
        image_map: Tensor,
        bev_map: Tensor,
        masks: tuple[float, float],
        size: int,
    ) -> Tensor:
        image_crops = crop_and_resize(image_map, image_boxes(anchors, sample.projection, sample.image_size), size)
        bev_crops = crop_and_resize(bev_map, bev_boxes(anchors, self.config.bev), size)
        return fuse(image_crops, bev_crops, masks).flatten(1)

    def _arithmetic(self, values: Tensor) -> contextlib.AbstractContextManager[object]:
        if self.precision is None:
            return contextlib.nullcontext()
        return torch.autocast(values.device.type, dtype=self.precision)


def _stacked(maps: list[Tensor]) -> Tensor:
    return torch.stack(maps).contiguous(memory_format=torch.channels_last)


def abstract_network(config: Config) -> AvodNetwork:
    """Make a network of shapes alone, on PyTorch's "meta" device: its weights take no memory."""
    with torch.device("meta"):
        return AvodNetwork(config)
