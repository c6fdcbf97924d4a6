"""What the network takes of one frame."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Sample:
    """One frame as tensors, float32 unless said otherwise.

    Attributes:
        frame_id: six digits, or what names a frame that comes from no folder.
        bev: (C, H, W) maps of the bird's-eye view, row 0 far.
        image: (3, h, w) RGB, resized, the mean taken off.
        anchors: (N, 6) over occupied ground, cam frame.
        plane: (4,) [a, b, c, d], unit normal, b < 0.
        projection: (3, 4) P2 of the image before resizing.
        image_size: its width and height.
        boxes_cam: (M, 7) of the labels of the classes; empty without labels.
        classes: (M,) int64, 1 for the first class.
    """

    frame_id: str
    bev: Tensor
    image: Tensor
    anchors: Tensor
    plane: Tensor
    projection: Tensor
    image_size: tuple[int, int]
    boxes_cam: Tensor
    classes: Tensor

    def to(self, device: torch.device) -> Sample:
        """Return the sample on a device."""
        tensors = {
            f.name: value.to(device, non_blocking=True)
            for f in fields(self)
            if isinstance(value := getattr(self, f.name), Tensor)
        }
        return replace(self, **tensors)

    def pin_memory(self) -> Sample:
        """Return the sample in page-locked memory, from where it travels to a GPU faster."""
        tensors = {
            f.name: value.pin_memory() for f in fields(self) if isinstance(value := getattr(self, f.name), Tensor)
        }
        return replace(self, **tensors)
