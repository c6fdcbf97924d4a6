"""Detected boxes of a frame, whatever network found them."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from avod.config import DetectionConfig
from avod.geometry.encoding import anchors_from_boxes
from avod.geometry.projection import ground_boxes
from avod.ops import nms
from cadet._util.summary import summary


@dataclass(frozen=True, eq=False)
class Boxes:
    """Detected boxes of a frame, best first.

    Attributes:
        boxes_cam: (D, 7), bottom center in the cam frame.
        scores: (D,) probability of the class.
        classes: (D,) int64, 1 for the first class.
    """

    boxes_cam: Tensor
    scores: Tensor
    classes: Tensor

    def __repr__(self) -> str:
        return summary(self, boxes_cam=self.boxes_cam, scores=self.scores, classes=self.classes)


def kept_boxes(
    boxes_cam: Tensor, scores: Tensor, classes: Tensor, config: DetectionConfig, ranks: Tensor | None = None
) -> Tensor:
    """Drop boxes that overlap a better one, and all but the best.

    Boxes are compared turned to the axes: all classes together, or each class on its own, as `config.suppression` says.

    Args:
        boxes_cam: (D, 7).
        scores: (D,) probability of the class.
        classes: (D,) int64.
        config: overlap and number.
        ranks: (D,) what orders boxes of all classes together; None for their scores.

    Returns:
        (K,) int64 indices of the kept boxes, by falling score.
    """
    boxes_bev = ground_boxes(anchors_from_boxes(boxes_cam))
    if config.suppression == "class":
        parts = [(classes == kind).nonzero().squeeze(1) for kind in sorted(set(classes.tolist()))]
        kept = torch.cat(
            [classes.new_zeros(0)]
            + [part[nms(boxes_bev[part], scores[part], config.nms_iou, config.max_detections)] for part in parts]
        )
    else:
        kept = nms(boxes_bev, scores if ranks is None else ranks, config.nms_iou, config.max_detections)
    return kept[torch.argsort(scores[kept], descending=True, stable=True)][: config.max_detections]
