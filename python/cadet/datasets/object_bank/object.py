"""One object of a bank."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import check_array
from cadet._util.checks import shown
from cadet._util.summary import summary
from cadet.errors import CadetError
from cadet.formats.kitti.label import is_object_type


@dataclass(frozen=True, eq=False)
class BankObject:
    """An object with its points and pixels.

    Its frame, `_scan`, has the axes of the cam frame (x right, y down, z ahead) and the LIDAR in its origin: turned
    about the y axis, an object keeps its beams.

    Attributes:
        type: of its label.
        box_scan: (7,) float64 [x, y, z, l, w, h, rotation_y], the bottom's center, meters.
        points_scan: (N, 4) float32 [x, y, z, intensity], meters.
        crop: (h, w, 4) uint8 RGB and opacity.
        corners_scan: (4, 3) float64, meters: where the crop's corners (top left, top right, bottom right, bottom left)
            lie on the upright plane through the box's center that faces the camera.
        source: the frame that it was cut from, for messages.

    Raises:
        ShapeError, NonFiniteError: an array of another shape, dtype, or with NaN.
        CadetError: an unknown type, no size, no points, or a place that is not ahead.
    """

    type: str
    box_scan: NDArray[np.float64]
    points_scan: NDArray[np.float32]
    crop: NDArray[np.uint8]
    corners_scan: NDArray[np.float64]
    source: str

    def __post_init__(self) -> None:
        if not is_object_type(self.type):
            raise CadetError(f"type: expected a type of objects such as Car, got {shown(self.type)}")
        check_array(self.box_scan, "box_scan", (7,), np.float64, finite=True)
        check_array(self.points_scan, "points_scan", ("N", 4), np.float32, finite=True)
        check_array(self.crop, "crop", ("H", "W", 4), np.uint8)
        check_array(self.corners_scan, "corners_scan", (4, 3), np.float64, finite=True)
        if not (self.box_scan[3:6] > 0.0).all() or not len(self.points_scan) or not self.crop.size:
            raise CadetError("expected an object with a size, points, and pixels")
        if not (self.corners_scan[:, 2] > 0.0).all() or not (self.points_scan[:, 2] > 0.0).all():
            raise CadetError("expected an object ahead of the LIDAR")

    def __repr__(self) -> str:
        values: dict[str, Any] = {"type": self.type, "box_scan": self.box_scan, "points_scan": self.points_scan}
        return summary(self, **values, crop=self.crop, source=self.source)
