"""Sensors with a name and a pose on the car."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from cadet._util.checks import check_kind, check_text
from cadet.sensors.camera import Camera
from cadet.sensors.lidar import Lidar
from cadet.sensors.pose import Pose


@dataclass(frozen=True, kw_only=True)
class MountedCamera:
    """A camera on the car.

    Raises:
        CadetError: a part of another kind, or an empty name.
    """

    name: str
    """Names its images."""
    camera: Camera
    """Size, focal lengths and lens, of a camera alone."""
    pose: Pose
    """Where its frame (x right, y down, z forward) stands in the ego's (x forward, y left, z up)."""

    def __post_init__(self) -> None:
        check_text("MountedCamera", "name", self.name)
        check_kind("MountedCamera", "camera", self.camera, Camera)
        check_kind("MountedCamera", "pose", self.pose, Pose)

    def to_dict(self) -> dict[str, Any]:
        """Return it in plain numbers."""
        return {"camera": self.camera.to_dict(), "pose": asdict(self.pose)}


@dataclass(frozen=True, kw_only=True)
class MountedLidar:
    """A LIDAR on the car.

    Raises:
        CadetError: a part of another kind, or an empty name.
    """

    name: str
    """Names its scans."""
    lidar: Lidar
    """The sensor."""
    pose: Pose
    """Where its frame (x forward, y left, z up) stands in the ego's."""

    def __post_init__(self) -> None:
        check_text("MountedLidar", "name", self.name)
        check_kind("MountedLidar", "lidar", self.lidar, Lidar)
        check_kind("MountedLidar", "pose", self.pose, Pose)

    def to_dict(self) -> dict[str, Any]:
        """Return it in plain numbers."""
        return {"lidar": self.lidar.to_dict(), "range_m": self.lidar.range_m(), "pose": asdict(self.pose)}
