"""nuScenes' folder as an exporter's."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import tee
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from cadet._util.plain_text import json_from_text
from cadet._util.sink import Sink, read_each
from cadet.errors import CadetError, FileFormatError
from cadet.formats.exporter import Ending, FilesInPlace, Place, Split
from cadet.formats.nuscenes.point_categories import point_categories
from cadet.formats.nuscenes.scene_names import scene_names
from cadet.formats.nuscenes.tables import Tables, data_token
from cadet.formats.sequences import seen_agents
from cadet.sensors.camera import Camera
from cadet.sensors.pose import inverse, product, quaternion_of
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Agent, Sample, Scan, Wanted

VERSION: Final = "v1.0-trainval"
"""The folder of the tables: the version that the devkit is told."""
TEST_VERSION: Final = "v1.0-test"
"""The folder of test scenes' tables: what tools find in the other one and not in nuScenes' train, they take for val."""

KEY_FRAME_S: Final = 0.5
"""From one key frame to the next: nuScenes' 2 Hz."""
LIDARSEG: Final = "lidarseg"

_RECORDS: Final = "records"
_RECORD_NAME: Final = re.compile(r"[0-9]{6}\.json")
_SCAN: Final = ".pcd.bin"
_JPEG_QUALITY: Final = 95
_FULL_SCALE: Final = 255.0


@dataclass
class NuscenesExporter(FilesInPlace):
    """Images and scans of all sensors, and tables of what they show; see `cadet.formats.exporter.Exporter`."""

    samples_per_key: int = 1
    """From one key frame to the next; those between are sweeps."""
    name: str = "nuscenes"
    extras: tuple[str, ...] = (LIDARSEG,)
    base: tuple[str, ...] = ()
    needs_sequence: bool = True

    def at_time_step(self, time_step_s: float) -> NuscenesExporter:
        """Return the exporter of sequences with this time from one sample to the next.

        Raises:
            CadetError: key frames would not fall on samples.
        """
        count = max(1, round(KEY_FRAME_S / time_step_s))
        if time_step_s < KEY_FRAME_S and abs(count * time_step_s - KEY_FRAME_S) > 1e-6:
            raise CadetError(
                f"nuscenes: expected --hz up to 2, or 4, 6, 10, 12, 20, 30, or 60, got {1 / time_step_s:g}"
            )
        return replace(self, samples_per_key=count)

    def check(self, rig: Rig, extras: tuple[str, ...]) -> None:
        """Refuse names of sensors that are no names of folders, and lenses that nuScenes' tables have no room for."""
        for name in (*self._cameras(rig), *rig.lidar_names):
            if "." in name or "/" in name:
                raise CadetError(f"cannot write the sensor {name!r} of the rig {rig.name}: it names a folder")
            sensor = rig.sensor(name)
            if isinstance(sensor, Camera) and any(sensor.distortion):
                raise CadetError(f"cannot write the sensor {name!r} of the rig {rig.name}: nuScenes has no distortion")
            if isinstance(sensor, Camera) and sensor.model == "fisheye":
                raise CadetError(f"cannot write the sensor {name!r} of the rig {rig.name}: nuScenes has no fisheye")

    def wanted(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> Wanted:
        """Return all sensors, and how much of each agent the images show."""
        return Wanted(sensors=None, maps=False, labels=False, shares=True)

    def kinds(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> tuple[str, ...]:
        """Return the channels with their suffixes.

        Raises:
            CadetError: the rigs do not have the same sensors.
        """
        found = {
            (*(f"{name}.jpg" for name in self._cameras(rig)), *(f"{name}{_SCAN}" for name in rig.lidar_names))
            for rig in rigs
        }
        if len(found) != 1:
            raise CadetError("nuscenes: expected the same sensors on all rigs of the policy")
        kinds = found.pop()
        scans = (kind.partition(".")[0] for kind in kinds if kind.endswith(_SCAN))
        return (*kinds, *(f"{name}.{LIDARSEG}" for name in scans if LIDARSEG in extras))

    def check_size(self, num_episodes: Mapping[Split, int]) -> None:
        """Refuse more scenes than nuScenes has names for."""
        for split, number in num_episodes.items():
            most = len(scene_names(split))
            if number > most:
                raise CadetError(
                    f"nuscenes: {number} {split} scenes, but nuScenes' own splits name {most}: make scenes "
                    "longer (--length-s), change the share of the split, or write several folders, each with its --seed"
                )

    def path(self, place: Place, kind: str) -> str:
        """Return a file's name: `samples/CHANNEL/ID` with its suffix, that of points' classes, or of the record."""
        if kind == "record":
            return f"{_RECORDS}/{place.id}.json"
        channel, _, suffix = kind.partition(".")
        if suffix == LIDARSEG:
            # As the devkit looks for it.
            return f"{LIDARSEG}/{_version(place)}/{data_token(place, channel)}_{LIDARSEG}.bin"
        folder = "samples" if self._is_key_frame(place) else "sweeps"
        return f"{folder}/{channel}/{place.id}.{suffix}"

    def encode(self, sample: Sample, extras: tuple[str, ...]) -> dict[str, bytes]:
        """Return the images and scans by channel and suffix."""
        files = {f"{name}.jpg": _jpeg(sample.image(name)) for name in sample.image_names}
        for name in sample.scan_names:
            scan = sample.scan(name)
            files[f"{name}{_SCAN}"] = _pcd(scan)
            if LIDARSEG in extras:
                files[f"{name}.{LIDARSEG}"] = point_categories(scan, sample.agents).tobytes()
        return files

    def record(self, sample: Sample) -> dict[str, Any]:
        """Return the ego, the sensors' calibration and the annotated objects of a sample."""
        rig = sample.rig
        # nuScenes' ego frame begins under the rear axle.
        shift = np.eye(4)
        shift[:3, 3] = rig.origin_in_ego_m
        origin_from_ego = inverse(shift)
        sensors = {}
        for name in (*sample.image_names, *sample.scan_names):
            pose = product(origin_from_ego, rig.ego_from_sensor(name))
            sensor = rig.sensor(name)
            intrinsic = []
            if isinstance(sensor, Camera):
                intrinsic = [[sensor.fx, 0.0, sensor.cx], [0.0, sensor.fy, sensor.cy], [0.0, 0.0, 1.0]]
            sensors[name] = {
                "modality": "camera" if intrinsic else "lidar",
                "size": [sensor.width, sensor.height] if isinstance(sensor, Camera) else [0, 0],
                **_place(pose),
                "camera_intrinsic": intrinsic,
            }
        return {
            **sample.origin,
            "time_s": sample.time_s,
            "map": sample.map,
            "weather": sample.weather,
            "ego_speed_mps": sample.ego_speed_mps,
            "ego": _place(product(sample.world_from_ego, shift)),
            "sensors": sensors,
            "objects": [_object(agent, num_points) for agent, num_points in seen_agents(sample)],
        }

    def record_bytes(self, record: Mapping[str, Any]) -> bytes:
        """Return the record as JSON."""
        return (json.dumps(record, separators=(",", ":"), allow_nan=False) + "\n").encode("ascii")

    def written(self, sink: Sink) -> list[int]:
        """Return the numbers of the samples that have a record."""
        return [int(name[:6]) for name in sink.names(_RECORDS) if _RECORD_NAME.fullmatch(name)]

    def finish(self, sink: Sink, places: Iterable[Place]) -> Ending:
        """Return the tables, made of all records."""
        of_version = {VERSION: Tables(), TEST_VERSION: Tables()}
        places, same = tee(places)
        records = read_each(sink, (self.path(place, "record") for place in same))
        for place, data in zip(places, records, strict=True):
            name = self.path(place, "record")
            try:
                record = json_from_text(data, name)
            except FileFormatError:
                raise CadetError(f"{name} was changed by another program during the run") from None
            paths = {channel: self.path(place, kind) for channel, kind in _channels(record)}
            written = (kind.partition(".") for kind in record["sha256"])
            labels = {
                channel: self.path(place, f"{channel}.{LIDARSEG}") for channel, _, it in written if it == LIDARSEG
            }
            tables = of_version[_version(place)]
            tables.add(place, record, paths, labels, is_key_frame=self._is_key_frame(place))
        files = {}
        types: Counter[str] = Counter()
        for version, tables in of_version.items():
            if tables.is_empty:
                continue
            files[f"maps/{tables.map_token}.png"] = _blank_map()
            for table, content in tables.finished().items():
                files[f"{version}/{table}.json"] = (json.dumps(content, indent=0, allow_nan=False) + "\n").encode(
                    "ascii"
                )
            types += tables.num_of_type
        return Ending(files, types)

    def _is_key_frame(self, place: Place) -> bool:
        return place.sample % self.samples_per_key == 0

    @staticmethod
    def _cameras(rig: Rig) -> list[str]:
        """Return the cameras that take images unasked."""
        return [name for index, name in enumerate(rig.camera_names) if index in {0, *rig.wanted(None)[0]}]


def _version(place: Place) -> str:
    return TEST_VERSION if place.split == "test" else VERSION


def _channels(record: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for channel, sensor in record["sensors"].items():
        yield channel, f"{channel}.jpg" if sensor["modality"] == "camera" else f"{channel}{_SCAN}"


def _object(agent: Agent, num_points: int) -> dict[str, Any]:
    length, width, height = agent.size_lwh
    middle = np.eye(4)
    middle[2, 3] = 0.5 * height
    return {
        "id": agent.id,
        "type": agent.type,
        "model": agent.model,
        "size_wlh": [width, length, height],
        **_place(product(agent.world_from_agent, middle)),
        "speed_mps": agent.speed_mps,
        "visible_share": agent.visible_share,
        "num_points": num_points,
    }


def _place(pose: NDArray[np.float64]) -> dict[str, list[float]]:
    return {"translation": pose[:3, 3].tolist(), "rotation": list(quaternion_of(pose[:3, :3]))}


def _jpeg(image: NDArray[np.uint8]) -> bytes:
    done, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    if not done:
        raise CadetError("JPEG: OpenCV can't encode the image")
    return data.tobytes()


def _pcd(scan: Scan) -> bytes:
    """Return x, y, z, intensity 0..255 and ring of every point, float32; nuScenes counts rings from the lowest up."""
    num_rings = int(scan.ring.max()) + 1 if len(scan.ring) else 0
    ring = (num_rings - 1 - scan.ring).astype(np.float32)
    intensity = np.rint(scan.points_velo[:, 3] * np.float32(_FULL_SCALE))
    return np.column_stack([scan.points_velo[:, :3], intensity, ring]).astype("<f4").tobytes()


def _blank_map() -> bytes:
    """Return a map that says nothing: the devkit must find one."""
    done, data = cv2.imencode(".png", np.zeros((10, 10), np.uint8))
    assert done
    return data.tobytes()
