"""A frame together with the scan of the same instant, actor ids included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import cadet


@dataclass(frozen=True)
class Sensed:
    """What a scene's rig sees at one instant."""

    frame: cadet.Frame
    scan: cadet.Scan
    cam_from_world: NDArray[np.float64]


def sense(scene: cadet.Scene) -> Sensed:
    """Captures a scene and its scan at one instant."""
    poses = scene.sensor_poses()
    return Sensed(scene.capture(), scene.scan(), np.linalg.inv(poses["world_from_cam"]))
