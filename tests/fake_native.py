"""A stand-in for the compiled core: small, quick, and as deterministic as the real one must be.

Its scenes depend on (seed, episode, attempt) and on how far was driven, so a test can tell a frame that was reached by
another way. `CADET_FAKE` makes it misbehave: "die=E", "panic=E" and "object=E" in episode E, "slow=S" seconds a view,
"empty" for worlds that never show an object, "blank=A" for no object before attempt A.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping, Sequence
from typing import Any
from zlib import crc32

import cv2
import numpy as np
from numpy.typing import NDArray

__version__ = "0.0.0-fake"

WEATHERS = ["clear_noon", "cloudy_noon", "wet_noon", "wet_cloudy_noon", "soft_rain_noon", "mid_rain_noon"]
WEATHERS += ["hard_rain_noon", "clear_sunset", "cloudy_sunset", "wet_sunset", "wet_cloudy_sunset"]
WEATHERS += ["soft_rain_sunset", "mid_rain_sunset", "hard_rain_sunset", "light_fog", "dense_fog", "snow", "dusk"]


def _error(message: str) -> Exception:
    # Imported late: the fake must stand before the package, whose import needs a core, is touched.
    from cadet.errors import CadetError

    return CadetError(message)


class Panic(BaseException):
    """What a panic of the core looks like from Python."""


def weather_names() -> list[str]:
    return list(WEATHERS)


def encode_png(image: NDArray[Any]) -> bytes:
    stored = image[..., ::-1] if image.ndim == 3 else image
    done, data = cv2.imencode(".png", stored)
    assert done
    return data.tobytes()


class Lidar:
    def __init__(self, name: str, height_m: float) -> None:
        self.name = name
        self.num_rings, self.num_columns = 2, 3
        self._height_m = height_m

    @staticmethod
    def preset(name: str) -> Lidar:
        return Lidar(name, 0.2)

    @staticmethod
    def from_table(table: Mapping[str, Any]) -> Lidar:
        return Lidar(table["name"], table["height_m"][0])

    def single_origin(self) -> Lidar:
        return Lidar(self.name, 0.0)

    def scanning(self, *, rolling: bool, returns: str, divergence_mrad: float) -> Lidar:
        return self

    def table(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "min_range_m": 1.45,
            "max_range_m": 80.0,
            "range_noise_m": 0.0078,
            "elevation_deg": [2.0, -2.0],
            "height_m": [self._height_m] * 2,
            "left_m": [0.0] * 2,
            "azimuth_offset_deg": [0.0, 0.0],
            "gain": [1.0, 1.0],
            "blind_deg": [[], [(170.0, 190.0)]],
            "firing": {"pattern": "uniform", "columns": 3},
        }

    def rays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
        ring, column = np.divmod(np.arange(6, dtype=np.int32), np.int32(3))
        return np.full((6, 3), [0.0, 0.0, self._height_m]), np.eye(3)[column], ring, column


class Assets:
    def __init__(self, share: float, vehicles: Sequence[Mapping[str, Any]]) -> None:
        for vehicle in vehicles:
            if "\nf " not in vehicle["obj"]:
                raise _error(f"{vehicle['file']}: no faces: is it a Wavefront OBJ file?")
        self.names = [vehicle["name"] for vehicle in vehicles]

    def assumptions(self) -> list[str]:
        return []

    def models(self) -> list[tuple[str, str, list[float]]]:
        return [(name, "Car", [4.0, 1.8, 1.5]) for name in self.names]


class Scene:
    def __init__(self, key: tuple[int, int, int], rig: Mapping[str, Any], weather: str, map_name: str | None) -> None:
        self.key, self.rig, self.weather, self.map_name = key, rig, weather, map_name
        self.driven_m = self.time_s = 0.0
        self.num_views = 0
        self.calls: list[str] = []
        self.map_warnings = lambda: [f'{map_name}: road "7": lost'] if map_name == "lossy.xodr" else []
        self.num_triangles, self.num_actors = 1, 1
        self.faults = dict(part.partition("=")[::2] for part in os.environ.get("CADET_FAKE", "").split(",") if part)

    @staticmethod
    def random(
        seed: int,
        episode: int,
        attempt: int,
        *,
        map_name: str | None,
        map_xodr: str | None,
        weather: str,
        rig: Mapping[str, Any],
        config: Mapping[str, Any],
        assets: Assets | None,
    ) -> Scene:
        _check_map(map_name, map_xodr)
        assert set(config) == {"num_cars", "num_pedestrians", "parking_occupancy", "vehicle_classes", "label"}
        return Scene((seed, episode, attempt), rig, weather, map_name)

    @staticmethod
    def empty(
        *,
        map_name: str | None,
        map_xodr: str | None,
        weather: str,
        rig: Mapping[str, Any],
        config: Mapping[str, Any],
        assets: Assets | None,
    ) -> Scene:
        _check_map(map_name, map_xodr)
        return Scene((0, 0, 0), rig, weather, map_name)

    def add(
        self,
        kind: str,
        model_seed: int,
        model: str | None,
        place: tuple[float, float, float] | None,
        speed: float | None,
        path: NDArray[np.float64] | None,
        may_overlap: bool,
    ) -> int:
        where = place if path is None else path.tolist()
        self.calls.append(f"add {kind} {model or model_seed} {where} {speed} {may_overlap}")
        return len(self.calls)

    def move_ego(self, x: float, y: float, yaw: float, may_overlap: bool) -> None:
        self.calls.append(f"move_ego {x} {y} {yaw} {may_overlap}")

    def step(self, seconds: float) -> None:
        self.time_s += seconds

    def drive(self, distance_m: float, blocked_s: float) -> None:
        self.driven_m += distance_m
        self.time_s += blocked_s / 2

    def capture(self, sample: int, maps: bool) -> dict[str, Any]:
        self._misbehave()
        self.num_views += 1
        camera = self.rig["camera"]
        shape = (camera["height"], camera["width"])
        words = [*self.key, sample, round(self.driven_m), round(self.time_s * 60), crc32(self.weather.encode())]
        noise = np.random.default_rng(words)
        labels = [_dont_care()]
        blank = int(self.faults.get("blank", 0)) > self.key[2]
        # A third of the views shows nothing, so that sample and view numbers part.
        if "empty" not in self.faults and not blank and (self.num_views % 3 or self.num_views == 0):
            labels.append(_car())
        matrices = ("P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo")
        captured = {
            "image": noise.integers(0, 256, (*shape, 3), np.uint8),
            "points_velo": noise.uniform(5.0, 9.0, (50, 4)).astype(np.float32),
            "labels": labels,
            "calib": {key: camera[key] for key in matrices},
            "plane": np.array([0.0, -1.0, 0.0, 1.65]),
            "meta": {"map": self.map_name or "suburb", "weather": self.weather, "driven_m": self.driven_m},
        }
        if maps:
            captured["depth"] = np.full(shape, 12.5, np.float32)
            captured["instance"] = np.zeros(shape, np.int32)
            captured["semantic"] = np.ones(shape, np.uint8)
        return captured

    def capture_labelled(self, sample: int, maps: bool) -> dict[str, Any] | None:
        captured = self.capture(sample, maps)
        return captured if any(label["type"] != "DontCare" for label in captured["labels"]) else None

    def scan(self, lidar: Lidar | None, ideal: bool, sample: int) -> dict[str, NDArray[Any]]:
        name = "rig" if lidar is None else lidar.name
        self.calls.append(f"scan {name} {ideal} {sample}")
        n = 4
        return {
            "points_velo": np.zeros((n, 4), np.float32),
            "ring": np.zeros(n, np.int32),
            "column": np.zeros(n, np.int32),
            "actor_id": np.full(n, -1, np.int32),
            "range_m": np.full(n, np.inf),
        }

    def cast_rays(
        self, origins_world: NDArray[np.float64], directions_world: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
        n = len(origins_world)
        return np.full(n, 7.0), np.zeros(n, np.int32), np.tile([0.0, 0.0, 1.0], (n, 1))

    def triangles(self) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.int32]]:
        return np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32), np.zeros(1, np.int32)

    def sensor_poses(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.eye(4), np.eye(4)

    def _misbehave(self) -> None:
        time.sleep(float(self.faults.get("slow", 0)))
        episode = str(self.key[1])
        if self.faults.get("die") == episode:
            os.kill(os.getpid(), signal.SIGKILL)
        if self.faults.get("panic") == episode:
            raise Panic("index out of bounds:\n the len is 3")
        if self.faults.get("object") == episode:
            raise _error("scene: no ground ahead of the camera")


def _check_map(name: str | None, text: str | None) -> None:
    if text is not None and "<OpenDRIVE" not in text:
        raise _error(f"{name}: no OpenDRIVE")


def _car() -> dict[str, Any]:
    return {
        "type": "Car",
        "truncated": 0.0,
        "occluded": 0,
        "alpha": 0.1,
        "bbox": (10.0, 5.0, 20.0, 9.0),
        "dimensions_hwl": (1.5, 1.6, 3.9),
        "location_cam": (1.0, 1.6, 20.0),
        "rotation_y": 0.15,
    }


def _dont_care() -> dict[str, Any]:
    return {
        "type": "DontCare",
        "truncated": -1.0,
        "occluded": -1,
        "alpha": -10.0,
        "bbox": (1.0, 2.0, 3.0, 4.0),
        "dimensions_hwl": (-1.0, -1.0, -1.0),
        "location_cam": (-1000.0, -1000.0, -1000.0),
        "rotation_y": -10.0,
    }
