"""Oxts of motions with closed forms: a circle, and a long way over the globe."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet import Rig
from cadet.formats.kitti.calib import KEYS
from cadet.formats.kitti.from_sample import calibration_of
from cadet.formats.kitti_sequences.oxts import FIELDS, oxts_lines

Array = NDArray[np.float64]
RADIUS_M, TURN = 30.0, 0.4


def record(time_s: float, world_from_ego: Array, velocity: Any = (0, 0, 0), turn: Any = (0, 0, 0)) -> dict[str, Any]:
    calib = calibration_of(Rig.kitti())
    ego_from_velo = np.eye(4)
    ego_from_velo[2, 3] = 1.73
    return {
        "time_s": time_s,
        "world_from_ego": world_from_ego.tolist(),
        "ego_from_velo": ego_from_velo.tolist(),
        "ego_velocity_world": list(velocity),
        "ego_angular_velocity_world": list(turn),
        "calib": {key: getattr(calib, key).tolist() for key in KEYS},
    }


def on_circle(time_s: float) -> dict[str, Any]:
    angle = TURN * time_s
    c, s = math.cos(angle), math.sin(angle)
    pose = np.eye(4)
    # Counter-clockwise, heading along the tangent.
    pose[:2, :2] = [[-s, -c], [c, -s]]
    pose[:2, 3] = RADIUS_M * c, RADIUS_M * s
    velocity = (-RADIUS_M * TURN * s, RADIUS_M * TURN * c, 0.0)
    return record(time_s, pose, velocity, (0.0, 0.0, TURN))


def columns(records: list[dict[str, Any]]) -> dict[str, Array]:
    rows = np.array([line.split() for line in oxts_lines(records)], np.float64)
    assert rows.shape == (len(records), 30)
    return {name: rows[:, index] for index, (name, _) in enumerate(FIELDS)}


def test_on_a_circle_the_unit_goes_around_on_one_of_its_own() -> None:
    """KITTI's unit stands 0.81 m behind and 0.32 m left of the LIDAR, so nearer to the center."""
    step_s = 0.01
    found = columns([on_circle(index * step_s) for index in range(200)])
    x, y, _ = (np.array(calibration_of(Rig.kitti()).Tr_imu_to_velo)[:, 3]).tolist()
    own_radius_m = math.hypot(RADIUS_M - y, x)
    speed = np.hypot(found["vn"], found["ve"])
    np.testing.assert_allclose(speed, TURN * own_radius_m, atol=1e-6)
    np.testing.assert_allclose(np.hypot(found["vf"], found["vl"]), speed, atol=1e-6)
    assert abs(found["vl"][0]) > 0.2, "the unit is behind the middle, so it slides outwards"
    force = np.hypot(found["af"], found["al"])[1:-1]
    np.testing.assert_allclose(force, TURN**2 * own_radius_m, rtol=1e-4)
    np.testing.assert_allclose(found["au"], 9.80665, atol=1e-6)
    np.testing.assert_allclose(found["wu"], TURN, atol=1e-9)
    np.testing.assert_allclose(np.gradient(np.unwrap(found["yaw"]), step_s), TURN, atol=1e-5)
    # The frame of KITTI's unit leans 0.85 degrees against the LIDAR's.
    np.testing.assert_allclose(np.sqrt(found["wx"] ** 2 + found["wy"] ** 2 + found["wz"] ** 2), TURN, atol=1e-9)


def test_a_long_way_keeps_to_the_mercator_projection() -> None:
    places = [(0.0, 0.0), (3.0, 5000.0), (-8000.0, -12000.0), (20000.0, 30000.0)]
    records = []
    for index, (east_m, north_m) in enumerate(places):
        pose = np.eye(4)
        pose[:3, 3] = east_m, north_m, 12.0
        records.append(record(float(index), pose))
    found = columns(records)
    scale, radius_m = math.cos(math.radians(found["lat"][0])), 6378137.0
    east = scale * found["lon"] * math.pi * radius_m / 180
    north = scale * radius_m * np.log(np.tan((90 + found["lat"]) * math.pi / 360))
    np.testing.assert_allclose(np.column_stack([east - east[0], north - north[0]]), places, atol=1e-4)
    assert (found["lat"][0], found["lon"][0]) == (49.0, 8.4)


def test_a_single_sample_has_no_acceleration_but_gravity() -> None:
    found = columns([on_circle(0.0)])
    assert (found["af"][0], found["al"][0]) == (0.0, 0.0)
    assert math.sqrt(found["ax"][0] ** 2 + found["ay"][0] ** 2 + found["az"][0] ** 2) == pytest.approx(9.80665)
