"""A stand-in for the compiled core: small, quick, and as deterministic as the real one must be.

Its scenes depend on (seed, episode, attempt) and on how far was driven, so a test can tell a frame that was reached by
another way. `CADET_FAKE` makes it misbehave: "die=E", "panic=E" and "object=E" in episode E, "slow=S" seconds a view,
"empty" for worlds that never show an object, "blank=A" for no object before attempt A, "stand=E" for an ego that stands
in the episodes before E.
"""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from zlib import crc32

import cv2
import numpy as np
from numpy.typing import NDArray

from fake_settings import LabelConfig, PropConfig, SceneConfig, SuburbConfig, limits

__all__ = ["LabelConfig", "PropConfig", "SceneConfig", "SuburbConfig", "limits"]

# The real core's, so that a folder that a process with the one began is no other version's to a process with the other.
_VERSION = re.search(r'^version = "(.+)"$', (Path(__file__).parents[1] / "Cargo.toml").read_text("utf-8"), re.MULTILINE)
assert _VERSION is not None
__version__ = _VERSION.group(1)

WEATHERS = ["clear_noon", "cloudy_noon", "wet_noon", "wet_cloudy_noon", "soft_rain_noon", "mid_rain_noon"]
WEATHERS += ["hard_rain_noon", "clear_sunset", "cloudy_sunset", "wet_sunset", "wet_cloudy_sunset"]
WEATHERS += ["soft_rain_sunset", "mid_rain_sunset", "hard_rain_sunset", "light_fog", "dense_fog", "snow", "dusk"]
WEATHERS += ["clear_night", "wet_night", "rain_night"]


def _error(message: str) -> Exception:
    # Imported late: the fake must stand before the package, whose import needs a core, is touched.
    from cadet.errors import CadetError

    return CadetError(message)


class Panic(BaseException):
    """What a panic of the core looks like from Python."""


def weather_names() -> list[str]:
    return list(WEATHERS)


def encode_png(image: NDArray[Any]) -> bytes:
    stored = image[..., [2, 1, 0, 3][: image.shape[2]]] if image.ndim == 3 else image
    done, data = cv2.imencode(".png", stored)
    assert done
    return data.tobytes()


def decode_image(data: bytes, max_pixels: int) -> tuple[NDArray[Any], str, bool, bool]:
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data.startswith(b"\x89PNG") else None
    if pixels is None:
        from cadet.errors import FileFormatError

        raise FileFormatError(f"no PNG, JPEG or WebP image ({len(data)} bytes); save it as PNG")
    return (pixels[..., None] if pixels.ndim == 2 else pixels[..., ::-1]), "PNG", False, False


class UniformFiring(SimpleNamespace):
    pass


class EncoderFiring(SimpleNamespace):
    pass


class ListedFiring(SimpleNamespace):
    pass


class Laser(SimpleNamespace):
    pass


class BeamTable(SimpleNamespace):
    pass


class Lidar:
    def __init__(self, name: str, height_m: float) -> None:
        self.name = name
        self.num_rings, self.num_columns = 2, 3
        self._height_m = height_m

    @staticmethod
    def preset(name: str) -> Lidar:
        return Lidar(name, 0.2)

    @staticmethod
    def presets() -> list[str]:
        return ["hdl64e_kitti", "hdl64e_uniform", "cadet"]

    @staticmethod
    def from_table(table: BeamTable) -> Lidar:
        return Lidar(table.name, table.rings[0].height_m)

    def single_origin(self) -> Lidar:
        return Lidar(self.name, 0.0)

    def scanning(self, *, rolling: bool, returns: str, divergence_mrad: float) -> Lidar:
        return self

    def table(self) -> BeamTable:
        rest = {"height_m": self._height_m, "left_m": 0.0, "azimuth_offset_deg": 0.0, "gain": 1.0}
        rest["range_offset_m"] = rest["focus_m"] = 0.0
        rings = [
            Laser(elevation_deg=2.0, blind_deg=[], **rest),
            Laser(elevation_deg=-2.0, blind_deg=[(170.0, 190.0)], **rest),
        ]
        firing, ranges = UniformFiring(columns=3), {"min_range_m": 1.45, "max_range_m": 80.0, "range_noise_m": 0.0078}
        return BeamTable(name=self.name, rings=rings, firing=firing, **ranges)

    def rays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
        ring, column = np.divmod(np.arange(6, dtype=np.int32), np.int32(3))
        return np.full((6, 3), [0.0, 0.0, self._height_m]), np.eye(3)[column], ring, column


class VehicleMesh(SimpleNamespace):
    MAX_TRIANGLES = 2_000_000
    MAX_MATERIALS = 256


class Assets:
    def __init__(self, share: float, vehicles: Sequence[VehicleMesh], props: Sequence[tuple[str, str]]) -> None:
        self.names = [vehicle.name for vehicle in vehicles]

    def assumptions(self) -> list[str]:
        return []

    def models(self) -> list[tuple[str, str, list[float]]]:
        return [(name, "Car", [4.0, 1.8, 1.5]) for name in self.names]


def check_props(files: Sequence[tuple[str, str]]) -> None:
    pass


class Pose:
    @staticmethod
    def mounted(position_m: Sequence[float], roll_pitch_yaw_deg: Sequence[float]) -> Pose:
        return Pose()

    @staticmethod
    def rigid(matrix: NDArray[np.float64]) -> Pose:
        assert matrix.shape == (3, 4)
        return Pose()

    def inverse(self) -> Pose:
        return self


class Camera:
    def __init__(
        self,
        name: str,
        *,
        width: int,
        height: int,
        projection: NDArray[np.float64],
        distortion: Sequence[float],
        rolling_shutter_s: float,
        mount: Sequence[Pose],
    ) -> None:
        self.name, self.width, self.height = name, width, height


class Rig:
    def __init__(
        self, name: str, *, cameras: Sequence[Camera], lidars: Sequence[tuple[str, Lidar, Sequence[Pose]]]
    ) -> None:
        self.name, self.cameras, self.lidars = name, cameras, lidars


class Sighting:
    def __init__(self, actor_id: int, *, is_labeled: bool) -> None:
        self.actor_id, self.is_labeled = actor_id, is_labeled
        self.class_name, self.model = "Car", "saloon/1"
        self.truncation, self.occlusion_level, self.observation_angle = 0.0, 0, 0.1
        self.bbox = (10.0, 5.0, 20.0, 9.0) if is_labeled else (1.0, 2.0, 3.0, 4.0)
        self.visible_fraction = self.contrast = 1.0
        self.visible_pixels, self.num_points = 40.0, 7
        self.velocity_world = [0.0, 0.0, 0.0]
        self.silhouette_bbox = self.bbox
        self.corner_visible = [True] * 8
        self.size_lwh, self.location_cam, self.rotation_y = [3.9, 1.6, 1.5], [1.0, 1.6, 20.0], 0.15


class Agent:
    def __init__(self, pixels: list[float] | None) -> None:
        self.id, self.class_name, self.model = 1, "Car", "saloon/1"
        self.size_lwh, self.velocity_world = [3.9, 1.6, 1.5], [0.0, 0.0, 0.0]
        self.world_from_agent = np.eye(4).tolist()
        self.pixels, self.brakes_for = pixels, None


class Request:
    def __init__(self, sample: int, *, maps: bool, pixels: bool, cameras: Sequence[int], lidars: Sequence[int]) -> None:
        self.sample, self.maps, self.cameras, self.lidars = sample, maps, cameras, lidars


class Capture:
    def __init__(
        self,
        scene: Scene,
        words: list[int],
        sightings: list[Sighting],
        cameras: list[Camera],
        lidars: list[str],
        maps: bool,
    ) -> None:
        self.time_s = scene.time_s
        self.ego_speed_mps = 0.0 if scene.key[1] < int(scene.faults.get("stand", 0)) else 5.0
        self.ego_velocity_world = [0.0, 0.0, 0.0]
        self.world_from_ego = np.eye(4).tolist()
        self.world_from_ego[0][3] = scene.driven_m
        self.ego_from_velo = np.eye(4).tolist()
        self.map_offset_m = [0.0, 0.0]
        self.map_geo_reference = None
        self.map, self.weather, self.sun_rad, self.boxes = (
            scene.map_name or "suburb",
            scene.weather,
            (0.7, 0.1),
            "kitti",
        )
        self.plane = np.array([0.0, -1.0, 0.0, 1.65])
        self.agents = [Agent([80.0, 40.0])]
        self.sightings = sightings
        self.names = ([camera.name for camera in cameras], lidars)
        self._words, self._cameras, self._maps = words, cameras, maps

    def image(self, index: int) -> NDArray[np.uint8]:
        camera = self._cameras[index]
        return self._noise(index).integers(0, 256, (camera.height, camera.width, 3), np.uint8)

    def png(self, index: int) -> bytes:
        return encode_png(self.image(index))

    def maps(self, index: int) -> dict[str, NDArray[Any]] | None:
        shape = (self._cameras[index].height, self._cameras[index].width)
        if not self._maps:
            return None
        depth, instance = np.full(shape, 12.5, np.float32), np.zeros(shape, np.int32)
        return {"depth": depth, "instance": instance, "semantic": np.ones(shape, np.uint8)}

    def scan(self, index: int) -> dict[str, NDArray[Any]]:
        points_velo = self._noise(100 + index).uniform(5.0, 9.0, (50, 4)).astype(np.float32)
        zeros = np.zeros(len(points_velo), np.int32)
        return {
            "points_velo": points_velo,
            "ring": zeros,
            "column": zeros,
            "actor_id": zeros + 1,
            "semantic": zeros.astype(np.uint8) + 11,
            "range_m": zeros.astype(np.float64),
        }

    def _noise(self, index: int) -> np.random.Generator:
        return np.random.default_rng([*self._words, index])


class Scene:
    def __init__(self, key: tuple[int, int, int], rig: Rig, weather: str, map_name: str | None) -> None:
        self.key, self.rig, self.weather, self.map_name = key, rig, weather, map_name
        self.driven_m = self.time_s = 0.0
        self.num_views = 0
        self.ego_is_at_road_end = False
        self.ego_brakes_for = None
        self.calls: list[str] = []
        self.map_warnings = lambda: [f'{map_name}: road "7": lost'] if map_name == "lossy.xodr" else []
        self.num_triangles, self.num_actors = 1, 1
        self.faults = dict(part.partition("=")[::2] for part in os.environ.get("CADET_FAKE", "").split(",") if part)

    def shortfalls(self) -> list[tuple[str, int, int]]:
        return []

    @staticmethod
    def random(
        seed: int,
        episode: int,
        attempt: int,
        *,
        map_name: str | None,
        map_xodr: str | None,
        weather: str,
        rig: Rig,
        config: SceneConfig,
        assets: Assets | None,
    ) -> Scene:
        _check_map(map_name, map_xodr)
        return Scene((seed, episode, attempt), rig, weather, map_name)

    @staticmethod
    def empty(
        *,
        map_name: str | None,
        map_xodr: str | None,
        weather: str,
        rig: Rig,
        config: SceneConfig,
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

    def step(self, seconds: float, ego_returns: bool = False) -> None:
        self.time_s += seconds

    def drive(self, distance_m: float, blocked_s: float) -> None:
        self.driven_m += distance_m
        self.time_s += blocked_s / 2

    def capture(self, request: Request) -> Capture:
        self._misbehave()
        words = [*self.key, request.sample, round(self.driven_m), round(self.time_s * 60), crc32(self.weather.encode())]
        sightings = [Sighting(2, is_labeled=False)]
        blank = int(self.faults.get("blank", 0)) > self.key[2]
        # A third of the views shows nothing, so that sample and view numbers part.
        if "empty" not in self.faults and not blank and (self.num_views % 3 or self.num_views == 0):
            sightings.append(Sighting(1, is_labeled=True))
        seen = [self.rig.cameras[i] for i in (0, *request.cameras)]
        turned = [self.rig.lidars[i][0] for i in (0, *request.lidars)]
        return Capture(self, words, sightings, seen, turned, request.maps)

    def capture_labeled(self, request: Request) -> Capture | None:
        self.num_views += 1
        captured = self.capture(request)
        return captured if any(seen.is_labeled for seen in captured.sightings) else None

    def scan(self, lidar: Lidar | None, ideal: bool, sample: int) -> dict[str, NDArray[Any]]:
        name = "rig" if lidar is None else lidar.name
        self.calls.append(f"scan {name} {ideal} {sample}")
        n = 4
        return {
            "points_velo": np.zeros((n, 4), np.float32),
            "ring": np.zeros(n, np.int32),
            "column": np.zeros(n, np.int32),
            "actor_id": np.full(n, -1, np.int32),
            "semantic": np.zeros(n, np.uint8),
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
