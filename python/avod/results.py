"""From the network's boxes to KITTI's labels with scores."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from avod.config import Config, DetectionConfig
from avod.data.mirror import mirror_box_tensors, mirror_sample
from avod.data.sample import Sample
from avod.model.boxes import Boxes, joined
from avod.model.network import AnyNetwork
from cadet.formats.kitti import Calibration, Label
from cadet.formats.kitti.boxes import alpha_from_boxes, clip_boxes_img, project_boxes


def labels_from_boxes(
    boxes: Boxes, calib: Calibration, image_size: tuple[int, int], config: Config
) -> tuple[Label, ...]:
    """Turn detected boxes into labels with scores, but for what the configuration or the image leaves out.

    That is: scores below `min_score`, boxes outside the image or behind it, and boxes that, before clipping, are wider
    or higher than `max_image_fraction` of the image.

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
    limit = config.max_image_fraction or np.inf
    is_whole: NDArray[np.bool_] = is_seen & (right - left <= limit * width) & (bottom - top <= limit * height)
    return is_whole


def detections(
    network: AnyNetwork, outputs: Any, sample: Sample, calib: Calibration, config: Config
) -> tuple[Label, ...]:
    """Turn a network's outputs for a frame into labels with scores, best first; it looks again where `flip` says so."""
    with torch.no_grad():
        boxes = network.boxes(outputs, sample, config)
        if config.detection.flip:
            mirrored = mirror_sample(sample)
            (outputs,) = network([mirrored], config=config)
            again = network.boxes(outputs, mirrored, config)
            boxes = joined(boxes, replace(again, boxes_cam=mirror_box_tensors(again.boxes_cam)), config.detection)
        return labels_from_boxes(boxes, calib, sample.image_size, config)
