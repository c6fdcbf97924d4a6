"""The center detector: from maps of the bird's-eye view to marks and boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Final, cast

import torch
from torch import Tensor, nn
from torch.nn import functional

from avod.config import Config, DetectionConfig, ExtractorConfig
from avod.data.sample import Sample
from avod.model.boxes import Boxes, kept_boxes
from avod.model.center.targets import NUM_BOX, boxes_from_cells, center_targets
from avod.model.layers import Convolution
from avod.model.network import DetectionNetwork, Outputs, stacked
from avod.model.parts import Part
from cadet._util.summary import summary

_RARE: Final = -4.0
"""Logit of a mark before training: hardly any cell is a center."""
_BOX_WEIGHTS: Final = (1.0, 1.0, 2.0, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0)
"""Of a box's numbers in its loss."""
_LEAST: Final = 1e-4


@dataclass(frozen=True, eq=False)
class CenterOutputs(Outputs):
    """The network's outputs for one frame, C classes, R x W cells.

    Attributes:
        marks: (C, R, W) logits of an object's center.
        boxes: (10, R, W), of an object whose center is in the cell.
    """

    marks: Tensor
    boxes: Tensor

    def __repr__(self) -> str:
        return summary(self, **{f.name: getattr(self, f.name) for f in fields(self) if f.name != "refinement"})

    @property
    def is_finite(self) -> bool:
        """Whether all that boxes are made of are numbers."""
        return bool(torch.isfinite(self.marks).all() & torch.isfinite(self.boxes).all())


class CenterNetwork(DetectionNetwork[Tensor, CenterOutputs]):
    """A convolutional network on the maps; the camera's image is not looked at.

    Args:
        config: the detector; of `extractor` the batch normalization's settings alone.

    Reference: Yin et al., "Center-based 3D Object Detection and Tracking" (CVPR 2021).
    """

    TERMS = ("mark", "box")

    def __init__(self, config: Config) -> None:
        super().__init__(config)
        self.backbone = _Backbone(config)
        width = config.center.fused_channels[-1]
        self.mark_head = nn.Conv2d(width, len(config.classes), 1)
        nn.init.constant_(cast("Tensor", self.mark_head.bias), _RARE)
        self.box_head = nn.Sequential(
            Convolution(width, width, config.extractor, kernel=1), nn.Conv2d(width, NUM_BOX, 1)
        )

    def extract(self, samples: Sequence[Sample]) -> list[Tensor]:
        """Make the outputs of samples: (C + 10, R, W)."""
        maps = stacked([sample.bev for sample in samples])
        with self.arithmetic(maps):
            found = self.run_maps(maps)
        return list(found.float())

    def run_maps(self, bev: Tensor) -> Tensor:
        """Map (B, c, H, W) to (B, C + 10, R, W)."""
        features = self.backbone(bev)
        return torch.cat([self.mark_head(features), self.box_head(features)], dim=1)

    def find(
        self,
        sample: Sample,
        features: Tensor,
        generator: torch.Generator | None,
        *,
        step: int | None,
        config: Config,
    ) -> CenterOutputs:
        """Part the outputs of a sample."""
        del sample, generator, step, config
        return CenterOutputs(features[:-NUM_BOX], features[-NUM_BOX:])

    def extractors(self) -> tuple[nn.Module, ...]:
        """Return the convolutions."""
        return (self.backbone,)

    def own_parts(self) -> tuple[Part, ...]:
        """List the one that makes outputs of maps."""

        def maps(bev: Tensor) -> tuple[Tensor, ...]:
            found = self.run_maps(bev)
            return found[:, :-NUM_BOX], found[:, -NUM_BOX:]

        bev = torch.zeros((1, *self.config.bev.shape))
        return (Part("maps", maps, {"bev": bev}, ("marks", "boxes"), has_rows=False),)

    def own_losses(self, outputs: CenterOutputs, sample: Sample, generator: torch.Generator) -> dict[str, Tensor]:
        """Compare marks and boxes with the sample's objects, over the number of objects."""
        del generator
        targets = center_targets(sample, self.config)
        count = max(len(targets.cells), 1)
        found = outputs.boxes.flatten(1).T[targets.cells]
        weights = found.new_tensor(_BOX_WEIGHTS)
        box = ((found - targets.boxes).abs() * weights).sum() / count
        return {
            "mark": mark_loss(outputs.marks, targets.marks, targets.is_ignored) / count,
            "box": box * self.config.center.regression_weight,
        }

    def decode(self, outputs: CenterOutputs, sample: Sample, config: DetectionConfig) -> Boxes:
        """Take cells whose mark no neighbor's exceeds."""
        scores = torch.sigmoid(outputs.marks)
        is_peak = functional.max_pool2d(scores[None], 3, stride=1, padding=1)[0] == scores
        flat = torch.where(is_peak, scores, 0.0).flatten()
        best, places = flat.topk(min(2 * config.max_detections, len(flat)))
        best, places = best[best > 0.0], places[best > 0.0]
        num_cells = scores[0].numel()
        kinds, cells = places // num_cells, places % num_cells
        numbers = outputs.boxes.flatten(1).T[cells]
        boxes_cam = boxes_from_cells(cells, numbers, kinds, sample.plane, self.config)
        kept = kept_boxes(boxes_cam, best, kinds + 1, config)
        return Boxes(boxes_cam[kept], best[kept], kinds[kept] + 1)


def mark_loss(logits: Tensor, marks: Tensor, is_ignored: Tensor) -> Tensor:
    """Compute the focal loss of marks, summed: cells beside a center count less as negatives, ignored ones not at all.

    Reference: Law and Deng, "CornerNet" (ECCV 2018), equation 1, with alpha 2 and beta 4.
    """
    found = torch.sigmoid(logits).clamp(_LEAST, 1.0 - _LEAST)
    is_center = marks == 1.0
    right = (1.0 - found) ** 2 * torch.log(found)
    wrong = ~is_ignored * (1.0 - marks) ** 4 * found**2 * torch.log(1.0 - found)
    return -torch.where(is_center, right, wrong).sum()


class _Backbone(nn.Module):
    """An encoder of strides 2, 4, 8, ... and a decoder back to stride 2."""

    def __init__(self, config: Config) -> None:
        super().__init__()
        center, norm = config.center, config.extractor
        widths = (config.bev.shape[0], *center.channels)
        self.stages = nn.ModuleList(
            _Stage(num_in, num_out, blocks, norm)
            for num_in, num_out, blocks in zip(widths[:-1], widths[1:], center.convolution_pairs, strict=True)
        )
        laterals, fusions = [], []
        num_in = center.channels[-1]
        for num_skip, num_out in zip(reversed(center.channels[:-1]), center.fused_channels, strict=True):
            laterals.append(Convolution(num_in, num_out, norm, kernel=1))
            fusions.append(Convolution(num_skip + num_out, num_out, norm))
            num_in = num_out
        self.laterals, self.fusions = nn.ModuleList(laterals), nn.ModuleList(fusions)

    def forward(self, maps: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, c, H / 2, W / 2)."""
        skips = []
        for stage in self.stages:
            maps = stage(maps)
            skips.append(maps)
        features = skips.pop()
        for lateral, fusion in zip(self.laterals, self.fusions, strict=True):
            features = fusion(skips.pop(), functional.interpolate(lateral(features), scale_factor=2))
        return features


class _Stage(nn.Module):
    """A convolution of stride 2, and pairs of convolutions whose outputs are added to what comes in."""

    def __init__(self, num_in: int, num_out: int, blocks: int, norm: ExtractorConfig) -> None:
        super().__init__()
        self.first = Convolution(num_in, num_out, norm, stride=2)
        self.blocks = nn.ModuleList(
            nn.Sequential(Convolution(num_out, num_out, norm), Convolution(num_out, num_out, norm))
            for _ in range(blocks)
        )

    def forward(self, maps: Tensor) -> Tensor:
        maps = self.first(maps)
        for block in self.blocks:
            maps = maps + block(maps)
        return maps
