"""Left and right exchanged: every function is its own inverse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avod.data.sample import Sample


def mirror_image(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Mirror the columns of an image (H, W, 3)."""
    return np.asarray(cv2.flip(image, 1), np.uint8)


def mirror_projection(projection: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Give the camera that sees the mirrored world as the mirrored image.

    Exactly: u becomes W - 1 - u for every point, the third row's offset included, which AVOD leaves out.

    Args:
        projection: (3, 4) P2.
        width: of the image.
    """
    mirrored = projection.copy()
    mirrored[0] = (width - 1.0) * projection[2] - projection[0]
    mirrored[:, 0] *= -1.0
    return mirrored


def mirror_points(points_cam: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mirror points (N, 3+) of the cam frame."""
    mirrored = points_cam.copy()
    mirrored[:, 0] *= -1.0
    return mirrored


def mirror_plane(plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mirror the ground plane (4,). Anchors made on it stand on the mirrored ground and need no further mirroring."""
    mirrored: NDArray[np.float64] = plane * np.array([-1.0, 1.0, 1.0, 1.0])
    return mirrored


def mirror_boxes(boxes_cam: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mirror boxes (M, 7): x changes its sign, rotation_y becomes pi - rotation_y, within [-pi, pi]."""
    mirrored = boxes_cam.copy()
    mirrored[:, 0] *= -1.0
    rotation_y = boxes_cam[:, 6]
    mirrored[:, 6] = np.where(rotation_y >= 0.0, np.pi - rotation_y, -np.pi - rotation_y)
    return mirrored


def mirror_box_tensors(boxes_cam: Tensor) -> Tensor:
    """Mirror boxes (M, 7) as `mirror_boxes` does."""
    return _of_tensor(mirror_boxes, boxes_cam)


def mirror_sample(sample: Sample) -> Sample:
    """Mirror a sample whose maps reach as far to the left as to the right."""
    return replace(
        sample,
        bev=sample.bev.flip(2),
        image=sample.image.flip(-1),
        anchors=_of_tensor(mirror_points, sample.anchors),
        points_cam=_of_tensor(mirror_points, sample.points_cam),
        plane=_of_tensor(mirror_plane, sample.plane),
        projection=_of_tensor(partial(mirror_projection, width=sample.image_size[0]), sample.projection),
        boxes_cam=mirror_box_tensors(sample.boxes_cam),
        ignored_cam=mirror_box_tensors(sample.ignored_cam),
    )


def _of_tensor(mirror: Callable[[NDArray[np.float64]], NDArray[np.float64]], values: Tensor) -> Tensor:
    return torch.from_numpy(mirror(values.cpu().double().numpy())).to(values)
