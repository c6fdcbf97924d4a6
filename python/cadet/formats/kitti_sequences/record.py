"""Records of each sample of a sequence: all that its drive's text files are made of at the end."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.plain_text import json_from_text
from cadet._util.sink import Sink
from cadet.errors import CadetError, FileFormatError
from cadet.formats.exporter import Place
from cadet.formats.kitti.calib import KEYS, Calibration
from cadet.formats.kitti.from_sample import calibration_of
from cadet.sensors.pose import angle_of, inverse, product
from cadet.sensors.sample import Sample

Record = Mapping[str, Any]

RECORDS: Final = "records"
SPAN_S: Final = "span_s"
"""When the LIDAR's turn begins and ends, from the sample's instant; absent of a scan that is taken at once."""
_AGENTS_WITHIN_M: Final = 120.0
"""How far from the LIDAR agents without a label are recorded: a track goes on through frames that hide its object."""


def path_of_record(place: Place) -> str:
    """Return the record's name."""
    return f"{RECORDS}/{place.id}.json"


def record_of(sample: Sample) -> dict[str, Any]:
    """Return what the files of a drive need of a sample: plain values, meters, seconds, and radians."""
    calib = calibration_of(sample.rig)
    world_from_velo = product(sample.world_from_ego, np.array(sample.ego_from_velo, np.float64))
    camera = sample.rig.camera
    span_s = sample.rig.lidar._to_native().span_s()
    return {
        **sample.origin,
        "time_s": sample.time_s,
        "map": sample.map,
        "weather": sample.weather,
        "rig": sample.rig.name,
        "boxes": sample.boxes,
        "image_size": [camera.width, camera.height],
        "calib": {key: getattr(calib, key).tolist() for key in KEYS},
        "world_from_ego": sample.world_from_ego.tolist(),
        "ego_from_velo": sample.ego_from_velo,
        "ego_speed_mps": sample.ego_speed_mps,
        "ego_velocity_world": sample.ego_velocity_world,
        "ego_angular_velocity_world": sample.ego_angular_velocity_world,
        "objects": [_object(seen, calib) for seen in sample._sightings() or ()],
        "agents": dict(_agents(sample, inverse(world_from_velo))),
        **({} if span_s is None else {SPAN_S: span_s}),
    }


def record_bytes(record: Record) -> bytes:
    """Return a record as JSON."""
    return (json.dumps(record, separators=(",", ":"), allow_nan=False) + "\n").encode("ascii")


def drives(sink: Sink, places: Iterable[Place]) -> Iterator[tuple[list[Place], list[Record]]]:
    """Yield the places and the records of each episode.

    Raises:
        CadetError: a record was removed or damaged while the dataset was being written.
    """
    for _, group in groupby(places, key=lambda place: place.episode):
        found = list(group)
        yield found, [_read(sink, path_of_record(place)) for place in found]


def calibration_of_record(record: Record) -> Calibration:
    """Return the calibration that a record holds."""
    matrices: dict[str, Any] = {key: np.array(record["calib"][key], np.float64) for key in KEYS}
    return Calibration(**matrices)


def velo_from_cam(calib: Calibration) -> NDArray[np.float64]:
    """Return the (4, 4) matrix from the cam frame to the velo frame, with the same bits on every processor."""
    rectified = np.eye(4)
    rectified[:3, :3] = calib.R0_rect
    return inverse(product(rectified, np.vstack([calib.Tr_velo_to_cam, [0.0, 0.0, 0.0, 1.0]])))


def wrapped(angle_rad: float) -> float:
    """Return an angle from -pi to pi."""
    return angle_rad - 2.0 * math.pi * round(angle_rad / (2.0 * math.pi))


def _read(sink: Sink, name: str) -> Record:
    try:
        record: Record = json_from_text(sink.read(name), name)
    except (FileNotFoundError, FileFormatError):
        raise CadetError(f"{name} was changed by another program during the run") from None
    return record


def _object(seen: _cadet.Sighting, calib: Calibration) -> dict[str, Any]:
    x, y, z, _ = product(velo_from_cam(calib), np.array([[*seen.location_cam, 1.0]]).T)[:, 0].tolist()
    return {
        "id": seen.actor_id,
        "type": seen.class_name,
        "model": seen.model,
        "is_labeled": seen.is_labeled,
        "truncation": seen.truncation,
        "occlusion_level": seen.occlusion_level,
        "observation_angle": seen.observation_angle,
        "bbox": seen.bbox,
        "size_lwh": seen.size_lwh,
        "location_cam": seen.location_cam,
        "rotation_y": seen.rotation_y,
        # The bottom's center and the heading in the velo frame.
        "pose_velo": [x, y, z, wrapped(-seen.rotation_y - math.pi / 2)],
        "velocity_world": seen.velocity_world,
        "num_points": seen.num_points,
    }


def _agents(sample: Sample, velo_from_world: NDArray[np.float64]) -> Iterator[tuple[str, list[float]]]:
    """Yield the bottom's center and the heading of agents in the velo frame, whether they are seen or not."""
    for agent in sample.agents:
        velo_from_agent = product(velo_from_world, agent.world_from_agent)
        x, y, z = velo_from_agent[:3, 3].tolist()
        if x * x + y * y + z * z <= _AGENTS_WITHIN_M * _AGENTS_WITHIN_M:
            heading = angle_of(float(velo_from_agent[0, 0]), float(velo_from_agent[1, 0]))
            yield str(agent.id), [round(value, 6) for value in (x, y, z, heading)]
