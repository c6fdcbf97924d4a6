"""KITTI's view of a sample: the only place where its marks for "unknown" and its rounding are made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.checks import shown
from cadet.errors import CadetError
from cadet.formats.kitti.calib import Calibration, is_at_zero_depth
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.label import Label
from cadet.sensors.mounted import MountedCamera
from cadet.sensors.pose import inverse, product
from cadet.sensors.rig import GRAY_CAMERAS, RIGHT_CAMERA, Rig
from cadet.sensors.sample import Sample

_STEPS: Final = 1e6
"""The numbers of a `meta` are rounded to a millionth: keeps the file short."""


def frame_from_sample(sample: Sample, camera: str | None = None) -> Frame:
    """Return KITTI's view of a sample: a camera's image and the first LIDAR's scan.

    Args:
        sample: the sample.
        camera: one of `sample.image_names`: the frame is as if this camera were the rig's first, so that image, maps,
            labels, calibration, and `meta` are its own, and there is no plane. None for the first.

    Raises:
        CadetError: the sample has no image or no labels of such a camera.
    """
    labels = labels_of(sample, camera)
    calib, maps = calibration_of(sample.rig, camera), sample.maps(camera)
    return Frame(
        image=sample.image(camera),
        points_velo=move_off_zero_depth(sample.scan().points_velo, calib),
        labels=labels,
        calib=calib,
        plane=sample.plane if camera is None else None,
        **({} if maps is None else maps._asdict()),
        camera_labels=_camera_labels(sample) if camera is None else {},
        meta=meta_of(sample, camera),
        sample=sample if camera is None else None,
    )


def calibration_of(rig: Rig, camera: str | None = None) -> Calibration:
    """Return the calibration file's matrices of a rig.

    Args:
        rig: the rig.
        camera: whose image P2 is to project into, and whose frame is the cam frame; the first one if None. The right
            and the gray cameras of a rig share the first one's frame.
    """
    matrices: dict[str, Any] = {**rig.camera.projections(), **rig.extrinsics.matrices()}
    if camera is None or camera == rig.camera_name:
        return Calibration(**matrices)
    for mounted in rig.more:
        if mounted.name == camera and isinstance(mounted, MountedCamera):
            if mounted.camera.model == "fisheye":
                raise CadetError(f"the camera {camera} is a fisheye, of which KITTI's files have no calibration")
            cam_from_velo = product(inverse(mounted.pose.matrix()), rig.ego_from_sensor(rig.lidar_name))[:3]
            own = {**mounted.camera.projections(), "R0_rect": np.eye(3), "Tr_velo_to_cam": cam_from_velo}
            return Calibration(**matrices | own)
    beside = dict(zip((*GRAY_CAMERAS, RIGHT_CAMERA), ("P0", "P1", "P3"), strict=True))
    return Calibration(**matrices | {"P2": matrices[beside[camera]]})


def labels_of(sample: Sample, camera: str | None = None) -> tuple[Label, ...]:
    """Return the lines of a camera's label file: objects, then a DontCare region for what is seen without a label.

    Args:
        sample: the sample.
        camera: one of `sample.image_names`, the first one if None.

    Raises:
        CadetError: the sample has no image or no labels of such a camera.
    """
    return tuple(
        _label(seen) if seen.is_labeled else Label.in_image("DontCare", seen.bbox) for seen in _seen(sample, camera)
    )


def meta_of(sample: Sample, camera: str | None = None) -> dict[str, Any]:
    """Return what else is known of a sample, with one entry of `objects` for each line of a camera's labels."""
    elevation_rad, azimuth_rad = sample.sun_rad
    return {
        **sample.origin,
        "time_s": sample.time_s,
        "ego_speed_mps": sample.ego_speed_mps,
        "world_from_ego": sample.world_from_ego.tolist(),
        "boxes": sample.boxes,
        "objects": [_object(seen) for seen in _seen(sample, camera)],
        "map": sample.map,
        "weather": sample.weather,
        "rig": sample.rig.name,
        "ego_from_velo": sample.ego_from_velo,
        "sun": {"elevation_rad": elevation_rad, "azimuth_rad": azimuth_rad},
    }


def move_off_zero_depth(points_velo: NDArray[np.float32], calib: Calibration) -> NDArray[np.float32]:
    """Round points with z = 0 in the cam frame to the next millimeter outwards: other programs divide by z.

    Coordinates are whole millimeters, so with LIDAR and camera in one point every point whose x rounds to 0 has no
    depth; `Rig.cadet()` has two columns of such beams, to the left and to the right.

    Args:
        points_velo: (N, 4) float32 [x, y, z, intensity], meters, velo frame.
        calib: the calibration.

    Returns:
        (N, 4) float32; the same array if no point lies there.
    """
    is_zero = is_at_zero_depth(points_velo, calib)
    if not is_zero.any():
        return points_velo
    axis = int(np.argmax(np.abs(calib.cam_from_velo[2, :3])))
    moved = points_velo.copy()
    millimeters = np.rint(moved[is_zero, axis].astype(np.float64) * 1e3)
    moved[is_zero, axis] = (millimeters + np.where(millimeters < 0.0, -1.0, 1.0)) / 1e3
    return moved


def _camera_labels(sample: Sample) -> dict[str, tuple[Label, ...]]:
    return {name: labels_of(sample, name) for name in sample.image_names if sample._sightings(name) is not None}


def _seen(sample: Sample, camera: str | None) -> list[_cadet.Sighting]:
    if camera is not None and camera not in sample.image_names:
        raise CadetError(f"no image of the camera {shown(camera)}; there are {', '.join(sample.image_names)}")
    sightings = sample._sightings(camera)
    if sightings is None:
        raise CadetError(f"the camera {camera} has no labels: they were not asked for")
    return sightings


def _label(seen: _cadet.Sighting) -> Label:
    length, width, height = seen.size_lwh
    x, y, z = seen.location_cam
    return Label(
        type=seen.class_name,
        truncated=seen.truncation,
        occluded=seen.occlusion_level,
        alpha=seen.observation_angle,
        bbox=seen.bbox,
        dimensions_hwl=(height, width, length),
        location_cam=(x, y, z),
        rotation_y=seen.rotation_y,
    )


def _object(seen: _cadet.Sighting) -> dict[str, Any]:
    length, width, height = seen.size_lwh
    return {
        "actor_id": seen.actor_id,
        "type": seen.class_name,
        "model": seen.model,
        "visible_fraction": _rounded(seen.visible_fraction),
        "visible_pixels": seen.visible_pixels,
        "contrast": _rounded(seen.contrast),
        "num_points": seen.num_points,
        "velocity_world": _all_rounded(seen.velocity_world),
        "silhouette_bbox": seen.silhouette_bbox,
        "corner_visible": seen.corner_visible,
        "dimensions_hwl": _all_rounded((height, width, length)),
        "location_cam": _all_rounded(seen.location_cam),
        "rotation_y": _rounded(seen.rotation_y),
    }


def _all_rounded(values: Sequence[float]) -> list[float]:
    return [_rounded(value) for value in values]


def _rounded(value: float) -> float:
    """Round halves away from zero, by steps rather than by decimals as Python does, and write no negative zero."""
    steps = math.trunc(value * _STEPS)
    rest = value * _STEPS - steps
    if abs(rest) >= 0.5:
        steps += 1 if rest > 0.0 else -1
    return steps / _STEPS
