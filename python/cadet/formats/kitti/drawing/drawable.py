"""The part of a frame that is drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.label import Label

LEVEL_PLANE: Final = np.array([0.0, -1.0, 0.0, 1.65])
"""The ground of a frame that has none: level, under KITTI's camera."""


class Drawable(Protocol):
    """What figures show of a frame: see `cadet.Frame`."""

    @property
    def image(self) -> NDArray[np.uint8]:
        """(H, W, 3) uint8 RGB."""

    @property
    def points_velo(self) -> NDArray[np.float32]:
        """(N, 4) float32."""

    @property
    def labels(self) -> tuple[Label, ...]:
        """Its labels."""

    @property
    def calib(self) -> Calibration:
        """Its calibration."""

    @property
    def plane(self) -> NDArray[np.float64] | None:
        """(4,) float64."""

    @property
    def depth(self) -> NDArray[np.float32] | None:
        """(H, W) float32."""

    @property
    def meta(self) -> dict[str, Any] | None:
        """What else the generator knows."""

    @property
    def image_size(self) -> tuple[int, int]:
        """Width and height of the image in pixels."""


@dataclass(frozen=True, eq=False)
class _Enlarged:
    image: NDArray[np.uint8]
    points_velo: NDArray[np.float32]
    labels: tuple[Label, ...]
    calib: Calibration
    plane: NDArray[np.float64] | None
    meta: dict[str, Any] | None
    depth: None = None

    @property
    def image_size(self) -> tuple[int, int]:
        return self.image.shape[1], self.image.shape[0]


def enlarged(frame: Drawable, least_width: int) -> Drawable:
    """Enlarge a small image by a whole factor, with the labels and the projection, so that strokes stay fine."""
    factor = -(-least_width // frame.image.shape[1])
    if factor == 1:
        return frame
    # Pixel centers are whole numbers: the first pixel's center moves from 0 to the middle of the pixels it becomes.
    offset = 0.5 * (factor - 1)
    projection = frame.calib.P2.copy()
    projection[:2] = factor * projection[:2] + offset * projection[2]

    def moved(label: Label) -> Label:
        left, top, right, bottom = (factor * x + offset for x in label.bbox)
        return replace(label, bbox=(left, top, right, bottom))

    return _Enlarged(
        image=resized(frame.image, factor * frame.image.shape[1]),
        points_velo=frame.points_velo,
        labels=tuple(map(moved, frame.labels)),
        calib=replace(frame.calib, P2=projection),
        plane=frame.plane,
        meta=frame.meta,
    )


def resized(image: NDArray[np.uint8], width: int) -> NDArray[np.uint8]:
    """Scale a picture to a width."""
    height = round(image.shape[0] * width / image.shape[1])
    method = cv2.INTER_AREA if width < image.shape[1] else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(image, (width, height), interpolation=method), np.uint8)
