"""Detected boxes of a frame, whatever network found them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from avod.config import DetectionConfig, ObjectClass
from avod.geometry.encoding import anchors_from_boxes
from avod.geometry.orientation import wrap_angle
from avod.geometry.projection import ground_boxes
from avod.ops import axis_aligned_iou, nms
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
    boxes_bev = _from_above(boxes_cam)
    if config.suppression == "class":
        parts = [(classes == kind).nonzero().squeeze(1) for kind in sorted(set(classes.tolist()))]
        kept = torch.cat(
            [classes.new_zeros(0)]
            + [part[nms(boxes_bev[part], scores[part], config.nms_iou, config.max_detections)] for part in parts]
        )
    else:
        kept = nms(boxes_bev, scores if ranks is None else ranks, config.nms_iou, config.max_detections)
    return kept[torch.argsort(scores[kept], descending=True, stable=True)][: config.max_detections]


def classes_by_length(boxes_cam: Tensor, classes: Sequence[ObjectClass]) -> Tensor:
    """Find the class that has anchors of the length nearest to that of each box, as a ratio: (D, 7) to (D,) int64."""
    sizes = [(number, size[0]) for number, kind in enumerate(classes, start=1) for size in kind.anchor_sizes_lwh_m]
    numbers, lengths_m = (torch.tensor(values, device=boxes_cam.device) for values in zip(*sizes, strict=True))
    return numbers[torch.log(boxes_cam[:, 3:4] / lengths_m).abs().argmin(dim=1)]


def joined(first: Boxes, second: Boxes, config: DetectionConfig) -> Boxes:
    """Join the boxes of two looks at one frame.

    Two boxes of one class that overlap each other the most, and by more than `nms_iou`, become their mean, weighted by
    their scores, with the mean of the scores. The others lose half of their score.
    """
    overlaps = axis_aligned_iou(_from_above(first.boxes_cam), _from_above(second.boxes_cam))
    overlaps[first.classes[:, None] != second.classes] = 0.0
    is_mutual = (overlaps == _most(overlaps, 1)) & (overlaps == _most(overlaps, 0)) & (overlaps > config.nms_iou)
    one, other = is_mutual.nonzero(as_tuple=True)
    is_alone = torch.cat([~is_mutual.any(dim=1), ~is_mutual.any(dim=0)])
    boxes_cam = torch.cat([first.boxes_cam, second.boxes_cam])
    scores, classes = torch.cat([first.scores, second.scores]) / 2.0, torch.cat([first.classes, second.classes])
    other_of_all = len(first.scores) + other
    pairs = _mean(boxes_cam[one], scores[one], boxes_cam[other_of_all], scores[other_of_all])
    boxes_cam = torch.cat([pairs, boxes_cam[is_alone]])
    scores = torch.cat([scores[one] + scores[other_of_all], scores[is_alone]])
    classes = torch.cat([classes[one], classes[is_alone]])
    kept = kept_boxes(boxes_cam, scores, classes, config)
    return Boxes(boxes_cam[kept], scores[kept], classes[kept])


def _from_above(boxes_cam: Tensor) -> Tensor:
    return ground_boxes(anchors_from_boxes(boxes_cam))


def _most(overlaps: Tensor, dim: int) -> Tensor:
    return overlaps.amax(dim=dim, keepdim=True) if overlaps.shape[dim] else overlaps


def _mean(boxes_cam: Tensor, weights: Tensor, others_cam: Tensor, other_weights: Tensor) -> Tensor:
    """Average pairs of boxes (K, 7); of opposite headings that of more weight counts."""
    share = (other_weights / (weights + other_weights).clamp(min=torch.finfo(weights.dtype).tiny))[:, None]
    mean = boxes_cam + share * (others_cam - boxes_cam)
    turn = wrap_angle(others_cam[:, 6] - boxes_cam[:, 6])
    is_opposite = turn.abs() > torch.pi / 2.0
    small_turn = wrap_angle(torch.where(is_opposite, turn + torch.pi, turn))
    heading = boxes_cam[:, 6] + share[:, 0] * small_turn
    heading = torch.where(is_opposite & (share[:, 0] > 0.5), heading + torch.pi, heading)
    return torch.cat([mean[:, :6], wrap_angle(heading)[:, None]], dim=1)
