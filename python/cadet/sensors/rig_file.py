"""Rigs as tables of a TOML file: every sensor with its name, its numbers and its pose (docs/rigs.md)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import check_three, shown
from cadet._util.plain_tables import check_keys, object_of_table, table_of_object
from cadet.errors import CadetError
from cadet.sensors.camera import Camera
from cadet.sensors.extrinsics import Extrinsics
from cadet.sensors.lidar import HOW, Lidar
from cadet.sensors.mounted import MountedCamera, MountedLidar
from cadet.sensors.pose import Pose, Row3, inverse, product, rotation_of_angles

_CAMERA: Final = tuple(f.name for f in fields(Camera))
_PLACES: Final = ("position_m", "position_in_ego_m")
_TURNS: Final = ("quaternion_wxyz", "roll_pitch_yaw_deg")
POSE: Final = (*_PLACES, *_TURNS)
"""Keys of a sensor's place, of which one is given, and of its turn, likewise."""


def fields_of_table(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the fields of a `Rig`; the first camera and LIDAR of the table are the rig's first.

    Args:
        table: what the file holds.
        folder: what the names of LIDARs' files are relative to.

    Raises:
        CadetError: anything that is wrong with it; the key is named.
    """
    check_keys(table, ("name", "origin_in_ego_m", "camera", "lidar"), ("name", "camera", "lidar"))
    origin = _three("origin_in_ego_m", table.get("origin_in_ego_m", [0.0, 0.0, 0.0]))
    lidars = [_lidar(place, one, origin, folder) for place, one in _tables("lidar", table["lidar"])]
    cameras = [_camera(place, one, origin) for place, one in _tables("camera", table["camera"])]
    lidar, angles = lidars[0]
    camera, at = cameras[0]
    if isinstance(at, Pose):
        at = _extrinsics(at, lidar.pose.position_m, angles)
    more = [MountedCamera(name=one["name"], camera=one["camera"], pose=pose) for one, pose in cameras[1:]]
    return {
        "name": table["name"],
        "lidar": lidar.lidar,
        "camera": camera["camera"],
        "extrinsics": at,
        "velo_in_ego_m": lidar.pose.position_m,
        "velo_roll_pitch_yaw_deg": angles,
        "camera_name": camera["name"],
        "lidar_name": lidar.name,
        "more": (*more, *(one for one, _ in lidars[1:])),
        "origin_in_ego_m": origin,
    }


def table_of_rig(rig: Any) -> dict[str, Any]:
    """Return the table of a rig, from which `fields_of_table` makes the same one."""
    lidar = {
        "name": rig.lidar_name,
        "position_in_ego_m": list(rig.velo_in_ego_m),
        "roll_pitch_yaw_deg": list(rig.velo_roll_pitch_yaw_deg),
        **_lidar_table(rig.lidar),
    }
    extrinsics = {"extrinsics": table_of_object(rig.extrinsics)}
    cameras = [{"name": rig.camera_name, **rig.camera._table(), **extrinsics}]
    lidars = [lidar]
    for mounted in rig.more:
        pose = {
            "name": mounted.name,
            "position_in_ego_m": list(mounted.pose.position_m),
            "quaternion_wxyz": list(mounted.pose.quaternion_wxyz),
        }
        if isinstance(mounted, MountedCamera):
            cameras.append({**pose, **mounted.camera._table()})
        else:
            lidars.append({**pose, **_lidar_table(mounted.lidar)})
    origin = list(rig.origin_in_ego_m)
    return {"name": rig.name, "origin_in_ego_m": origin, "lidar": lidars, "camera": cameras}


def _lidar_table(lidar: Lidar) -> dict[str, Any]:
    table = lidar._table()
    how = {key: table.pop(key) for key in HOW if key in table}
    return {**how, "lidar": table["name"] if table.keys() == {"name"} else table}


def _camera(place: str, table: Mapping[str, Any], origin: Row3) -> tuple[dict[str, Any], Any]:
    """Return a camera with its name, and its pose; of the first one its `Extrinsics`, if they are given instead."""
    is_beside = "extrinsics" in table and place == "camera[0]"
    mount = ("extrinsics",) if is_beside else POSE
    check_keys(table, ("name", *mount, *_CAMERA), ("name",), place)
    camera = Camera._of_table({key: table[key] for key in _CAMERA if key in table}, Path(), place)
    if is_beside:
        at: Any = object_of_table(Extrinsics, table["extrinsics"], Path(), f"{place}.extrinsics")
    else:
        at, _ = _pose(place, table, origin, Pose.of_camera)
    return {"name": table["name"], "camera": camera}, at


def _lidar(place: str, table: Mapping[str, Any], origin: Row3, folder: Path) -> tuple[MountedLidar, Row3]:
    """Return a LIDAR with its pose, and the pose's angles."""
    check_keys(table, ("name", "lidar", *HOW, *POSE), ("name", "lidar"), place)
    named = table["lidar"]
    try:
        lidar = Lidar._of_table(named, folder) if isinstance(named, Mapping) else Lidar.named(named, folder=folder)
    except CadetError as error:
        raise CadetError(f"{place}.lidar: {error}") from None
    lidar = replace(lidar, **{key: table[key] for key in HOW if key in table})
    pose, angles = _pose(place, table, origin, Pose.of_angles)
    return MountedLidar(name=table["name"], lidar=lidar, pose=pose), angles


def _pose(place: str, table: Mapping[str, Any], origin: Row3, turned: Callable[..., Pose]) -> tuple[Pose, Row3]:
    """Return a pose, and its roll, pitch and yaw in degrees, of which `turned` makes one."""
    for keys in (_PLACES, _TURNS):
        if sum(key in table for key in keys) != 1:
            raise CadetError(f"{place}.{keys[0]}: expected one of {' and '.join(keys)}")
    given = next(key for key in _PLACES if key in table)
    position = _three(f"{place}.{given}", table[given])
    if given == "position_m":
        x, y, z = position
        position = (origin[0] + x, origin[1] + y, origin[2] + z)
    if "roll_pitch_yaw_deg" in table:
        angles = _three(f"{place}.roll_pitch_yaw_deg", table["roll_pitch_yaw_deg"], 180)
        roll, pitch, yaw = angles
        return turned(position, roll_deg=roll, pitch_deg=pitch, yaw_deg=yaw), angles
    given_turn = table["quaternion_wxyz"]
    pose = Pose(position_m=position, quaternion_wxyz=tuple(given_turn) if isinstance(given_turn, list) else given_turn)
    return pose, _angles_of(pose.matrix()[:3, :3])


def _extrinsics(camera: Pose, velo_in_ego_m: Row3, angles_deg: Row3) -> Extrinsics:
    # What the rounded angles leave is the camera's to take.
    velo = np.eye(4)
    velo[:3, :3] = rotation_of_angles(*angles_deg)
    velo[:3, 3] = velo_in_ego_m
    cam_from_velo = product(inverse(camera.matrix()), velo)
    rows: Any = tuple(tuple(row) for row in cam_from_velo[:3].tolist())
    return replace(Extrinsics.aligned(), tr_velo_to_cam=rows)


def _angles_of(rotation: NDArray[np.float64]) -> Row3:
    """Return roll, pitch and yaw in degrees, as `rotation_of_angles` takes them."""
    (a, _, _), (b, _, _), (c, d, e) = rotation.tolist()
    angles = (math.atan2(d, e), -math.asin(max(-1.0, min(1.0, c))), math.atan2(b, a))
    roll, pitch, yaw = (round(math.degrees(angle), 9) for angle in angles)
    return roll, pitch, yaw


def _tables(name: str, tables: object) -> list[tuple[str, Mapping[str, Any]]]:
    if not isinstance(tables, list) or not tables or not all(isinstance(table, Mapping) for table in tables):
        raise CadetError(f"{name}: expected at least one table [[{name}]]")
    return [(f"{name}[{number}]", table) for number, table in enumerate(tables)]


def _three(name: str, values: object, limit: float = 20) -> Row3:
    if not isinstance(values, list):
        raise CadetError(f"{name}: expected three numbers, got {shown(values)}")
    check_three("", name, tuple(values), limit)
    x, y, z = map(float, values)
    return x, y, z
