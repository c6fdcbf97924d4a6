"""Rigs as TOML: every sensor with its name, its numbers and its pose (docs/rigs.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import as_path, check_number, check_three, shown, shown_key
from cadet._util.plain_text import toml_from_text
from cadet._util.user_files import read_settings
from cadet.errors import CadetError
from cadet.sensors.camera import Camera
from cadet.sensors.extrinsics import Extrinsics
from cadet.sensors.lidar import Lidar
from cadet.sensors.mounted import MountedCamera, MountedLidar
from cadet.sensors.pose import Pose, Row3, inverse, product, rotation_of_angles

_MOST = 1e9
_POSE = {"position_m", "quaternion_wxyz"}
_CAMERA = {"name", "size", "focal_px", "center_px", "distortion", "rolling_shutter_s"} | _POSE
_LIDAR = {"name", "model", "rolling", "returns", "divergence_mrad"} | _POSE


def rig_fields(path: str | Path) -> dict[str, Any]:
    """Read the fields of a `Rig` from a TOML file; its first camera and LIDAR are the rig's first.

    Raises:
        MissingFileError: there is no such file.
        CadetError: anything that is wrong with it, in one line with the file's name.
    """
    path = as_path("rig", path)
    values = toml_from_text(read_settings(path), path.name)
    try:
        return _fields(values)
    except CadetError as error:
        raise CadetError(f"{path.name}: {error}") from None


def _fields(values: Mapping[str, Any]) -> dict[str, Any]:
    _check_keys("", values, {"name", "origin_in_ego_m", "camera", "lidar"}, {"name", "camera", "lidar"})
    origin = _numbers("origin_in_ego_m", values.get("origin_in_ego_m", [0.0, 0.0, 0.0]), 3)
    cameras = [_camera(i, table, origin) for i, table in enumerate(_tables("camera", values["camera"]))]
    lidars = [_lidar(i, table, origin) for i, table in enumerate(_tables("lidar", values["lidar"]))]
    camera, lidar = cameras[0], lidars[0]
    velo = lidar.pose.matrix()
    angles = _angles_of(velo[:3, :3])
    # What the rounded angles leave is the camera's to take.
    velo[:3, :3] = rotation_of_angles(*angles)
    cam_from_velo = product(inverse(camera.pose.matrix()), velo)
    rows: Any = tuple(tuple(row) for row in cam_from_velo[:3].tolist())
    here = Extrinsics.aligned()
    return {
        "name": values["name"],
        "lidar": lidar.lidar,
        "camera": camera.camera,
        "extrinsics": Extrinsics(r0_rect=here.r0_rect, tr_velo_to_cam=rows, tr_imu_to_velo=here.tr_imu_to_velo),
        "velo_in_ego_m": lidar.pose.position_m,
        "velo_roll_pitch_yaw_deg": angles,
        "camera_name": camera.name,
        "lidar_name": lidar.name,
        "more": (*cameras[1:], *lidars[1:]),
        "origin_in_ego_m": origin,
    }


def _camera(number: int, table: Mapping[str, Any], origin: Row3) -> MountedCamera:
    owner = f"camera[{number}]"
    _check_keys(f"{owner}.", table, _CAMERA, _CAMERA - {"distortion", "rolling_shutter_s"})
    size = _numbers(f"{owner}.size", table["size"], 2)
    if not all(value.is_integer() for value in size):
        raise CadetError(f"{owner}.size: expected whole numbers of pixels, got {shown(table['size'])}")
    fx, fy = _numbers(f"{owner}.focal_px", table["focal_px"], 2)
    cx, cy = _numbers(f"{owner}.center_px", table["center_px"], 2)
    bent = _numbers(f"{owner}.distortion", table.get("distortion", [0.0] * 5), 5)
    (rolling_s,) = _numbers(f"{owner}.rolling_shutter_s", [table.get("rolling_shutter_s", 0.0)], 1)
    camera = Camera(
        width=int(size[0]),
        height=int(size[1]),
        fx=fx,
        fy=fy,
        cx=cx,
        cy=cy,
        distortion=bent,
        rolling_shutter_s=rolling_s,
    )
    return MountedCamera(name=table["name"], camera=camera, pose=_pose(owner, table, origin))


def _lidar(number: int, table: Mapping[str, Any], origin: Row3) -> MountedLidar:
    owner = f"lidar[{number}]"
    _check_keys(f"{owner}.", table, _LIDAR, {"name", "model"} | _POSE)
    how = {key: table[key] for key in ("rolling", "returns", "divergence_mrad") if key in table}
    return MountedLidar(name=table["name"], lidar=Lidar(table["model"], **how), pose=_pose(owner, table, origin))


def _pose(owner: str, table: Mapping[str, Any], origin: Row3) -> Pose:
    x, y, z = _numbers(f"{owner}.position_m", table["position_m"], 3)
    check_three(owner, "position_m", (x, y, z), 20)
    turned = _numbers(f"{owner}.quaternion_wxyz", table["quaternion_wxyz"], 4)
    return Pose(position_m=(origin[0] + x, origin[1] + y, origin[2] + z), quaternion_wxyz=turned)


def _angles_of(rotation: NDArray[np.float64]) -> Row3:
    """Return roll, pitch and yaw in degrees, as `rotation_of_angles` takes them."""
    (a, _, _), (b, _, _), (c, d, e) = rotation.tolist()
    angles = (math.atan2(d, e), -math.asin(max(-1.0, min(1.0, c))), math.atan2(b, a))
    roll, pitch, yaw = (round(math.degrees(angle), 9) for angle in angles)
    return roll, pitch, yaw


def _tables(name: str, tables: object) -> list[Mapping[str, Any]]:
    if not isinstance(tables, list) or not tables or not all(isinstance(table, Mapping) for table in tables):
        raise CadetError(f"{name}: expected at least one table [[{name}]]")
    return tables


def _check_keys(owner: str, values: Mapping[str, Any], known: set[str], needed: set[str]) -> None:
    for key in values:
        if key not in known:
            raise CadetError(f"{owner}{shown_key(key)}: unknown key; known: {', '.join(sorted(known))}")
    for key in sorted(needed):
        if key not in values:
            raise CadetError(f"{owner}{key}: missing key")


def _numbers(name: str, values: object, count: int) -> Any:
    is_list = isinstance(values, list) and len(values) == count
    if not is_list or not all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values):  # type: ignore[attr-defined]
        raise CadetError(f"{name}: expected {count} numbers, got {shown(values)}")
    for value in values:  # type: ignore[attr-defined]
        check_number("", name, value, -_MOST, _MOST)
    return tuple(float(value) for value in values)  # type: ignore[attr-defined]
