"""What an inertial and GPS unit on the ego would write: the 30 numbers of KITTI's `oxts` files.

Latitude and longitude are those of a Mercator projection about the drive's first place, as KITTI's development kit
(`convertOxtsToPose.m`) and pykitti project them back; x is east, y north.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti_sequences.record import Record, calibration_of_record
from cadet.sensors.pose import angles_of_rotation, cos_sin, product

FIELDS: Final[tuple[tuple[str, str], ...]] = (
    ("lat", "latitude of the oxts-unit (deg)"),
    ("lon", "longitude of the oxts-unit (deg)"),
    ("alt", "altitude of the oxts-unit (m)"),
    ("roll", "roll angle (rad), 0 = level, positive = left side up, range: -pi .. +pi"),
    ("pitch", "pitch angle (rad), 0 = level, positive = front down, range: -pi/2 .. +pi/2"),
    ("yaw", "heading (rad), 0 = east, positive = counter clockwise, range: -pi .. +pi"),
    ("vn", "velocity towards north (m/s)"),
    ("ve", "velocity towards east (m/s)"),
    ("vf", "forward velocity, parallel to the earth's surface (m/s)"),
    ("vl", "leftward velocity, parallel to the earth's surface (m/s)"),
    ("vu", "upward velocity, perpendicular to the earth's surface (m/s)"),
    ("ax", "specific force (acceleration and 9.80665 m/s^2 upwards) in x, the unit's forward (m/s^2)"),
    ("ay", "specific force in y, the unit's left (m/s^2)"),
    ("az", "specific force in z, the unit's up (m/s^2)"),
    ("af", "forward specific force, parallel to the earth's surface (m/s^2)"),
    ("al", "leftward specific force, parallel to the earth's surface (m/s^2)"),
    ("au", "upward specific force, perpendicular to the earth's surface (m/s^2)"),
    ("wx", "angular rate around x (rad/s)"),
    ("wy", "angular rate around y (rad/s)"),
    ("wz", "angular rate around z (rad/s)"),
    ("wf", "angular rate around the forward axis (rad/s)"),
    ("wl", "angular rate around the leftward axis (rad/s)"),
    ("wu", "angular rate around the upward axis (rad/s)"),
    ("pos_accuracy", "position accuracy (m): 0, exact"),
    ("vel_accuracy", "velocity accuracy (m/s): 0, exact"),
    ("navstat", "navigation status: 4, locked"),
    ("numsats", "number of satellites: 0"),
    ("posmode", "position mode: 0, none"),
    ("velmode", "velocity mode: 0, none"),
    ("orimode", "orientation mode: 0, none"),
)
"""The fields in their order, each with its meaning."""

DATA_FORMAT: Final = "".join(f"{name}: {meaning}\n" for name, meaning in FIELDS)
"""The text of `dataformat.txt`."""

LATITUDE_DEG: Final = 49.0
LONGITUDE_DEG: Final = 8.4
"""Where each drive begins: Karlsruhe, as KITTI's."""

EARTH_RADIUS_M: Final = 6378137.0
GRAVITY_MPS2: Final = 9.80665
_STATUS: Final = "0 0 4 0 0 0 0"


def oxts_lines(records: Sequence[Record]) -> list[str]:
    """Return a line for each record of a drive.

    Velocity is the instant's. Acceleration is the velocity's change from the record before to the one after, over the
    time between them: a mean over two time steps, or one at the drive's ends.
    """
    poses = [_world_from_imu(record) for record in records]
    velocities = [_velocity_world(record, pose) for record, pose in zip(records, poses, strict=True)]
    lines = []
    for index, (record, pose) in enumerate(zip(records, poses, strict=True)):
        before, after = max(index - 1, 0), min(index + 1, len(records) - 1)
        seconds = records[after]["time_s"] - records[before]["time_s"]
        force_world = [0.0, 0.0, GRAVITY_MPS2]
        if seconds > 0.0:
            for axis in range(3):
                force_world[axis] += (velocities[after][axis] - velocities[before][axis]) / seconds
        turn_world = record["ego_angular_velocity_world"]
        lines.append(_line(pose, poses[0], velocities[index], force_world, turn_world))
    return lines


def _line(
    pose: NDArray[np.float64],
    first: NDArray[np.float64],
    velocity: Sequence[float],
    force: Sequence[float],
    turn: Sequence[float],
) -> str:
    east_m, north_m = (pose[:2, 3] - first[:2, 3]).tolist()
    roll, pitch, yaw = angles_of_rotation(pose[:3, :3])
    body, level = pose[:3, :3], _level(pose)
    numbers = [
        float(pose[2, 3]),
        roll,
        pitch,
        yaw,
        velocity[1],
        velocity[0],
        *_seen_from(level, velocity),
        *_seen_from(body, force),
        *_seen_from(level, force),
        *_seen_from(body, turn),
        *_seen_from(level, turn),
    ]
    place = f"{_latitude_deg(north_m):.13f} {_longitude_deg(east_m):.13f}"
    return f"{place} {' '.join(_decimal(number) for number in numbers)} {_STATUS}"


def _world_from_imu(record: Record) -> NDArray[np.float64]:
    velo_from_imu = np.vstack([calibration_of_record(record).Tr_imu_to_velo, [0.0, 0.0, 0.0, 1.0]])
    world_from_velo = product(np.array(record["world_from_ego"]), np.array(record["ego_from_velo"]))
    return product(world_from_velo, velo_from_imu)


def _velocity_world(record: Record, world_from_imu: NDArray[np.float64]) -> list[float]:
    """Return the unit's velocity: the ego's, and what its turning adds at the unit's place."""
    x, y, z = (world_from_imu[:3, 3] - np.array(record["world_from_ego"])[:3, 3]).tolist()
    vx, vy, vz = record["ego_velocity_world"]
    wx, wy, wz = record["ego_angular_velocity_world"]
    return [vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x]


def _level(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the axes forward, left, and up in the world that the unit has if leveled, as columns."""
    a, d = float(pose[0, 0]), float(pose[1, 0])
    length = math.sqrt(a * a + d * d)
    c, s = a / length, d / length
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _seen_from(world_from_axes: NDArray[np.float64], vector: Sequence[float]) -> list[float]:
    x, y, z = vector
    return [a * x + b * y + c * z for a, b, c in world_from_axes.T.tolist()]


def _longitude_deg(east_m: float) -> float:
    scale, _ = cos_sin(LATITUDE_DEG)
    return LONGITUDE_DEG + east_m * 180.0 / (math.pi * EARTH_RADIUS_M * scale)


def _latitude_deg(north_m: float) -> float:
    """Invert y = scale R ln tan(45 deg + latitude / 2), without functions that differ between machines.

    tan(latitude / 2) is tanh(y / 2 scale R), so the difference from the first latitude is a quotient of hyperbolic
    tangents by their addition theorem; both are small, and series give them.
    """
    scale, _ = cos_sin(LATITUDE_DEG)
    cosine, sine = cos_sin(LATITUDE_DEG / 2.0)
    first = sine / cosine
    half = north_m / (2.0 * scale * EARTH_RADIUS_M)
    square = half * half
    rise = half * (1.0 - square * (1.0 / 3.0 - square * (2.0 / 15.0 - square * 17.0 / 315.0)))
    ratio = rise * (1.0 - first * first) / (1.0 + rise * first + first * (first + rise))
    square = ratio * ratio
    angle = ratio * (1.0 - square * (1.0 / 3.0 - square * (1.0 / 5.0 - square / 7.0)))
    return LATITUDE_DEG + 2.0 * angle * 180.0 / math.pi


def _decimal(value: float) -> str:
    text = f"{value:.9f}"
    # No negative zero.
    return text[1:] if text.strip("-0.") == "" and text.startswith("-") else text
