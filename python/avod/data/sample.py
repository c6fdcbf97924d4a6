"""The network's inputs for one frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from cadet._util.summary import summary


@dataclass(frozen=True, eq=False)
class Sample:
    """One frame as tensors, float32 unless said otherwise.

    Attributes:
        frame_id: of a folder's frame, or what names a frame that comes from no folder.
        bev: (C, H, W) maps of the bird's-eye view, row 0 far.
        image: (3, h, w) uint8 RGB, resized; empty for a detector that does not look at it.
        anchors: (N, 6) over occupied ground, cam frame; empty for a detector without anchors.
        points_cam: (P, 3) that the image sees; empty for a detector that does not look at single points.
        plane: (4,) [a, b, c, d], unit normal, b < 0.
        projection: (3, 4) P2 of the image before resizing.
        image_size: its width and height.
        boxes_cam: (M, 7) of the labels of the classes; empty without labels.
        classes: (M,) int64, 1 for the first class.
        ignored_cam: (I, 7) of the labels that are neither objects nor background.
    """

    frame_id: str
    bev: Tensor
    image: Tensor
    anchors: Tensor
    points_cam: Tensor
    plane: Tensor
    projection: Tensor
    image_size: tuple[int, int]
    boxes_cam: Tensor
    classes: Tensor
    ignored_cam: Tensor

    def __repr__(self) -> str:
        return summary(
            self,
            frame_id=self.frame_id,
            bev=self.bev,
            image=self.image,
            anchors=self.anchors,
            image_size=self.image_size,
            boxes_cam=self.boxes_cam,
        )

    def to(self, device: torch.device) -> Sample:
        """Return the sample on a device."""
        return self._with(lambda tensor: tensor.to(device, non_blocking=True))

    def pin_memory(self) -> Sample:
        """Return the sample in page-locked memory, from where it travels to a GPU faster."""
        return self._with(lambda tensor: tensor.pin_memory())

    def _with(self, change: Callable[[Tensor], Tensor]) -> Sample:
        return replace(
            self,
            bev=change(self.bev),
            image=change(self.image),
            anchors=change(self.anchors),
            points_cam=change(self.points_cam),
            plane=change(self.plane),
            projection=change(self.projection),
            boxes_cam=change(self.boxes_cam),
            classes=change(self.classes),
            ignored_cam=change(self.ignored_cam),
        )
