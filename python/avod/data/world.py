"""A sample's whole world turned, scaled, and moved, with the camera that sees it: every point keeps its pixel.

Turning is about the vertical axis of the cam frame, so upright boxes stay upright boxes. What changes is where the
world lies in the maps, which are tied to the cam frame's axes, and how high the camera stands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avod.data.augmentation import Augmentation
from cadet.formats.kitti.boxes import wrap_angle


@dataclass(frozen=True, eq=False)
class WorldChange:
    """The similarity p -> scale * rotation * p + shift_m of the cam frame.

    Attributes:
        rotation_rad: about the y axis, as rotation_y counts.
        scale: positive.
        shift_m: (3,).
    """

    rotation_rad: float
    scale: float
    shift_m: NDArray[np.float64]

    @classmethod
    def drawn(cls, augmentation: Augmentation) -> WorldChange | None:
        """Draw a change within the augmentation's limits; None where it has none."""
        settings = augmentation.settings
        if not (settings.rotation_deg or settings.scaling or any(settings.translation_m)):
            return None
        angle, size, *shift = augmentation.stream("world").uniform(-1.0, 1.0, 5)
        return cls(
            math.radians(settings.rotation_deg) * angle,
            1.0 + settings.scaling * size,
            np.array(settings.translation_m) * shift,
        )

    def points(self, points_cam: NDArray[np.float64]) -> NDArray[np.float64]:
        """Change points (N, 3)."""
        changed: NDArray[np.float64] = self.scale * points_cam @ self._rotation().T + self.shift_m
        return changed

    def boxes(self, boxes_cam: NDArray[np.float64]) -> NDArray[np.float64]:
        """Change boxes (M, 7)."""
        changed = boxes_cam.copy()
        changed[:, :3] = self.points(boxes_cam[:, :3])
        changed[:, 3:6] *= self.scale
        changed[:, 6] = wrap_angle(boxes_cam[:, 6] + self.rotation_rad)
        return changed

    def plane(self, plane: NDArray[np.float64]) -> NDArray[np.float64]:
        """Change the ground plane (4,), whose normal keeps its length and its vertical part."""
        normal = self._rotation() @ plane[:3]
        return np.array([*normal, self.scale * plane[3] - normal @ self.shift_m])

    def projection(self, projection: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give the camera (3, 4) that sees the changed world as it saw the old one; depths are in its meters."""
        turned = projection[:, :3] @ self._rotation().T
        moved = self.scale * projection[:, 3] - turned @ self.shift_m
        return np.hstack([turned, moved[:, None]])

    def _rotation(self) -> NDArray[np.float64]:
        cos, sin = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
