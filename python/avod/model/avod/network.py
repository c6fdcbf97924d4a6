"""AVOD-FPN as a whole: from samples to proposals, classes, boxes and headings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import cast

import torch
from torch import Tensor, nn

from avod.config import Config, DetectionConfig
from avod.data.sample import Sample
from avod.geometry.encoding import anchors_from_offsets
from avod.geometry.projection import bev_boxes, ground_boxes, image_boxes
from avod.model.avod.decoding import decode
from avod.model.avod.losses import frame_losses
from avod.model.avod.outputs import FrameOutputs
from avod.model.avod.path_drop import detection_masks, draw_masks, fuse
from avod.model.avod.pyramid import FeaturePyramid
from avod.model.avod.targets import anchor_targets, sample_proposals, truth_proposals
from avod.model.boxes import Boxes
from avod.model.layers import Convolution, Head
from avod.model.network import DetectionNetwork, stacked
from avod.model.parts import EXAMPLE_ROWS, Part
from avod.ops import crop_and_resize, nms
from cadet._util.summary import summary

_NUM_ANCHOR_OFFSETS = 6
_NUM_BOX_OFFSETS = 10
_NUM_VECTOR = 2


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


class AvodNetwork(DetectionNetwork[FrameFeatures, FrameOutputs]):
    """AVOD-FPN.

    Args:
        config: the detector.
    """

    TERMS = ("objectness", "anchor", "classification", "box", "orientation")
    mean_rgb: Tensor

    def __init__(self, config: Config) -> None:
        super().__init__(config)
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
        self.second_stage = Head(
            width * second.crop_size**2,
            second.hidden,
            (len(config.classes) + 1, _NUM_BOX_OFFSETS, _NUM_VECTOR),
            second.dropout_keep,
        )
        mean = torch.tensor(config.image.mean_rgb).view(3, 1, 1)
        self.register_buffer("mean_rgb", mean, persistent=False)

    def extract(self, samples: Sequence[Sample]) -> list[FrameFeatures]:
        """Make the feature maps of samples."""
        with self.arithmetic(samples[0].bev):
            maps = self.run_maps(*(stacked([getattr(sample, name) for sample in samples]) for name in ("bev", "image")))
        return [FrameFeatures(*of_frame) for of_frame in zip(*maps, strict=True)]

    def run_maps(self, bev: Tensor, image: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Map (B, c, H, W) and (B, 3, h, w), colors 0..255, to the fields of `FrameFeatures`, frames stacked."""
        bev = self.bev_pyramid(bev)
        image = self.image_pyramid(image - self.mean_rgb)
        return bev, image, self.bev_bottleneck(bev), self.image_bottleneck(image)

    def find(
        self,
        sample: Sample,
        features: FrameFeatures,
        generator: torch.Generator | None,
        *,
        step: int | None,
        config: Config,
    ) -> FrameOutputs:
        """Run both stages on the feature maps of a sample; arguments as for `forward`.

        Outputs made with a generator have targets: a mini-batch of proposals, which copies of the true boxes join in
        the first steps. In training mode a path may be dropped.
        """
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
            second = config.second_stage
            if second.truth_proposals and step is not None and step < second.truth_steps:
                truths = truth_proposals(sample, second.truth_proposals, generator)
                proposals = torch.cat([proposals, truths])
            chosen, targets = sample_proposals(proposals.detach(), sample, second, generator)
            proposals = proposals[chosen]
        if config.second_stage.gradient == "stopped":
            proposals = proposals.detach()
        class_logits, box_offsets, vectors = self._judge_proposals(sample, features, proposals, masks)
        return FrameOutputs(anchor_logits, anchor_offsets, proposals, class_logits, box_offsets, vectors, targets)

    def extractors(self) -> tuple[nn.Module, ...]:
        """Return both feature pyramids."""
        return self.bev_pyramid, self.image_pyramid

    def own_parts(self) -> tuple[Part, ...]:
        """List the one that makes feature maps, and the heads of both stages."""
        width, height = self.config.image.size
        frame = {"bev": torch.zeros((1, *self.config.bev.shape)), "image": torch.zeros((1, 3, height, width))}
        anchors, proposals = (
            {"crops": torch.zeros((EXAMPLE_ROWS, cast("nn.Linear", head.layers[0]).in_features))}
            for head in (self.anchor_classifier, self.second_stage)
        )
        maps = ("bev_features", "image_features", "bev_bottleneck", "image_bottleneck")
        judgments = ("class_logits", "box_offsets", "vectors")
        return (
            Part("features", self.run_maps, frame, maps, has_rows=False),
            Part("anchors", self.run_anchors, anchors, ("logits", "offsets"), has_rows=True),
            Part("proposals", self.second_stage, proposals, judgments, has_rows=True),
        )

    def own_losses(self, outputs: FrameOutputs, sample: Sample, generator: torch.Generator) -> dict[str, Tensor]:
        """Compute both stages' losses, the first's over a mini-batch of anchors."""
        targets = anchor_targets(sample, self.config.rpn, generator)
        return frame_losses(outputs, targets, sample, self.config).by_name()

    def decode(self, outputs: FrameOutputs, sample: Sample, config: DetectionConfig) -> Boxes:
        """Decode proposals."""
        return decode(outputs, sample.plane, config)

    def _judge_anchors(
        self, sample: Sample, features: FrameFeatures, masks: tuple[float, float]
    ) -> tuple[Tensor, Tensor]:
        crops = self._crops(
            sample, sample.anchors, features.image_bottleneck, features.bev_bottleneck, masks, self.config.rpn.crop_size
        )
        with self.arithmetic(crops):
            logits, offsets = self.run_anchors(crops)
        return logits.to(crops.dtype), offsets.to(crops.dtype)

    def run_anchors(self, crops: Tensor) -> tuple[Tensor, Tensor]:
        """Map fused crops of anchors to logits (N, 2) and offsets (N, 6)."""
        (logits,) = cast("tuple[Tensor]", self.anchor_classifier(crops))
        (offsets,) = cast("tuple[Tensor]", self.anchor_regressor(crops))
        return logits, offsets

    def _judge_proposals(
        self,
        sample: Sample,
        features: FrameFeatures,
        proposals: Tensor,
        masks: tuple[float, float],
    ) -> tuple[Tensor, Tensor, Tensor]:
        crops = self._crops(sample, proposals, features.image, features.bev, masks, self.config.second_stage.crop_size)
        with self.arithmetic(crops):
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
