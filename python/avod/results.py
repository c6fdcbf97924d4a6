"""From the network's outputs to KITTI's labels with scores."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avod.config import Config, DetectionConfig
from avod.geometry.encoding import anchors_from_boxes, boxes_4c_from_anchors, boxes_from_4c
from avod.geometry.orientation import fix_up
from avod.geometry.projection import ground_boxes
from avod.model.avod.network import FrameOutputs
from avod.ops import nms
from cadet._util.summary import summary
from cadet.formats.kitti import Calibration, Label
from cadet.formats.kitti.boxes import alpha_from_boxes, clip_boxes_img, project_boxes


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


def decode(outputs: FrameOutputs, plane: Tensor, config: DetectionConfig) -> Boxes:
    """Decode proposals, drop the lesser ones, choose headings.

    Boxes are compared turned to the axes: all classes together, ranked by the greatest logit of a class, or each class
    on its own, ranked by score.

    Args:
        outputs: of the network.
        plane: (4,) ground plane of the sample.
        config: overlap and number.
    """
    boxes_4c = boxes_4c_from_anchors(outputs.proposals, plane) + outputs.box_offsets
    boxes_cam = boxes_from_4c(boxes_4c, plane)
    boxes_bev = ground_boxes(anchors_from_boxes(boxes_cam))
    scores, classes = outputs.class_logits.softmax(dim=1)[:, 1:].max(dim=1)
    if config.suppression == "class":
        parts = [(classes == kind).nonzero().squeeze(1) for kind in range(outputs.class_logits.shape[1] - 1)]
        kept = torch.cat(
            [part[nms(boxes_bev[part], scores[part], config.nms_iou, config.max_detections)] for part in parts]
        )
    else:
        ranks = outputs.class_logits[:, 1:].amax(dim=1)
        kept = nms(boxes_bev, ranks, config.nms_iou, config.max_detections)
    # The greatest logit need not have the highest score: that depends on the others' too.
    kept = kept[torch.argsort(scores[kept], descending=True, stable=True)][: config.max_detections]
    fixed = fix_up(boxes_cam[kept], outputs.vectors[kept], is_reference=config.fix_up == "reference")
    return Boxes(fixed, scores[kept], classes[kept] + 1)


def labels_from_boxes(
    boxes: Boxes, calib: Calibration, image_size: tuple[int, int], config: Config
) -> tuple[Label, ...]:
    """Turn detected boxes into labels with scores; left out is what AVOD does not write.

    That is: scores below the least, boxes outside the image or behind it, and boxes that, before clipping, are wider or
    higher than the image's greater part.

    Args:
        boxes: of one frame.
        calib: its calibration.
        image_size: width and height of its image.
        config: the detector.
    """
    boxes_cam = boxes.boxes_cam.detach().cpu().double().numpy()
    scores, classes = boxes.scores.detach().cpu().double().numpy(), boxes.classes.cpu().numpy()
    whole = project_boxes(boxes_cam, calib)
    is_kept = (scores >= config.detection.min_score) & _is_in_image(whole, image_size, config.detection)
    boxes_cam, scores, classes = boxes_cam[is_kept], scores[is_kept], classes[is_kept]
    clipped, alphas = clip_boxes_img(whole[is_kept], image_size), alpha_from_boxes(boxes_cam)
    names = config.class_names
    rows: Iterable[tuple[NDArray[np.float64], float, int, NDArray[np.float64], float]] = zip(
        boxes_cam, scores, classes, clipped, alphas, strict=True
    )
    return tuple(
        Label(
            type=names[kind - 1],
            truncated=-1.0,
            occluded=-1,
            alpha=float(alpha),
            bbox=(float(bbox[0]), float(bbox[1]), float(bbox[2]), float(bbox[3])),
            dimensions_hwl=(float(box[5]), float(box[4]), float(box[3])),
            location_cam=(float(box[0]), float(box[1]), float(box[2])),
            rotation_y=float(box[6]),
            score=float(score),
        )
        for box, score, kind, bbox, alpha in rows
    )


def _is_in_image(
    boxes_img: NDArray[np.float64], image_size: tuple[int, int], config: DetectionConfig
) -> NDArray[np.bool_]:
    width, height = image_size
    left, top, right, bottom = boxes_img.T
    is_seen = (right > 0) & (left < width - 1) & (bottom > 0) & (top < height - 1)
    limit = config.max_image_fraction
    is_whole: NDArray[np.bool_] = is_seen & (right - left <= limit * width) & (bottom - top <= limit * height)
    return is_whole


def detections(
    outputs: FrameOutputs, plane: Tensor, calib: Calibration, image_size: tuple[int, int], config: Config
) -> tuple[Label, ...]:
    """Turn the network's outputs for a frame into labels with scores, best first."""
    with torch.no_grad():
        return labels_from_boxes(decode(outputs, plane, config.detection), calib, image_size, config)
