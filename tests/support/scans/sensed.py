"""A frame together with the scan of the same instant, actor ids included."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import cadet


@dataclass(frozen=True)
class Sensed:
    """What a scene's rig sees at one instant."""

    frame: cadet.Frame
    scan: cadet.Scan
    cam_from_world: NDArray[np.float64]


def objects_of(frame: cadet.Frame) -> list[dict[str, Any]]:
    """Return what the generator knows of each line of a frame's labels."""
    assert frame.meta is not None
    objects: list[dict[str, Any]] = frame.meta["objects"]
    assert len(objects) == len(frame.labels)
    return objects


def sense(scene: cadet.Scene) -> Sensed:
    """Captures a scene and its scan at one instant."""
    poses = scene.sensor_poses()
    cam_from_world: NDArray[np.float64] = np.linalg.inv(poses["world_from_cam"]).astype(np.float64)
    return Sensed(scene.capture(), scene.scan(), cam_from_world)
