"""The Rust core. Private: use the wrappers of `cadet`, which are typed, documented and keyword-only."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Agent",
    "Assets",
    "Camera",
    "Capture",
    "LabelConfig",
    "Lidar",
    "Pose",
    "Rig",
    "Scene",
    "SceneConfig",
    "Sighting",
    "__version__",
    "_panic",
    "bev_maps",
    "box_iou",
    "encode_png",
    "estimate_ground_plane",
    "evaluate",
    "nms_bev",
    "weather_air",
    "weather_names",
    "weather_recorded_scan",
]

__version__: str

# A folder and each frame's id, or packed objects: where each frame begins and the end, type names, numbers.
_EvaluationSource: TypeAlias = (
    tuple[str | PathLike[str], Sequence[str | None]] | tuple[Sequence[int], Sequence[str], NDArray[np.float64]]
)

@final
class Assets:
    """Vehicles built from a user's meshes (see `cadet.Assets`)."""

    def __new__(cls, share: float, vehicles: Sequence[Mapping[str, Any]]) -> Assets: ...
    def models(self) -> list[tuple[str, str, list[float]]]: ...
    def assumptions(self) -> list[str]: ...

@final
class Lidar:
    """A LIDAR's beams and returns (see `cadet.Lidar`)."""

    @staticmethod
    def preset(name: str) -> Lidar: ...
    @staticmethod
    def presets() -> list[str]: ...
    @staticmethod
    def from_table(table: Mapping[str, Any]) -> Lidar: ...
    @property
    def name(self) -> str: ...
    @property
    def num_rings(self) -> int: ...
    @property
    def num_columns(self) -> int: ...
    def single_origin(self) -> Lidar: ...
    def scanning(self, *, rolling: bool, returns: str, divergence_mrad: float) -> Lidar: ...
    def table(self) -> dict[str, Any]: ...
    def rays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]: ...

@final
class LabelConfig:
    """What gets a label (see `cadet.LabelConfig`)."""

    def __new__(
        cls,
        *,
        method: str,
        boxes: str,
        min_height_px: float,
        min_visible_fraction: float,
        max_depth_m: float,
        min_depth_m: float,
        max_truncation: float,
        min_contrast: float,
        min_points: int,
        dontcare_min_pixels: float,
        occlusion_levels: tuple[float, float],
        corner_tolerance_m: float,
        max_hidden_corners: int,
    ) -> LabelConfig: ...
    @staticmethod
    def settings() -> list[tuple[str, tuple[float, float, float, bool]]]: ...
    @staticmethod
    def default_occlusion_levels() -> tuple[float, float]: ...

@final
class SceneConfig:
    """How full a scene is (see `cadet.SceneConfig`)."""

    def __new__(
        cls,
        *,
        num_cars: int,
        num_pedestrians: int,
        parking_occupancy: float,
        vehicle_classes: Sequence[str],
        label: LabelConfig,
    ) -> SceneConfig: ...

@final
class Pose:
    """A rigid pose."""

    @staticmethod
    def mounted(position_m: Sequence[float], roll_pitch_yaw_deg: Sequence[float]) -> Pose: ...
    @staticmethod
    def rigid(matrix: NDArray[np.float64]) -> Pose: ...
    def inverse(self) -> Pose: ...
    def matrix(self) -> NDArray[np.float64]: ...

@final
class Camera:
    """A camera with its name and place."""

    def __new__(
        cls,
        name: str,
        *,
        width: int,
        height: int,
        projection: NDArray[np.float64],
        distortion: Sequence[float],
        mount: Sequence[Pose],
    ) -> Camera: ...

@final
class Rig:
    """Cameras and LIDARs on a car."""

    def __new__(
        cls, name: str, *, cameras: Sequence[Camera], lidars: Sequence[tuple[str, Lidar, Sequence[Pose]]]
    ) -> Rig: ...

@final
class Agent:
    """An actor around the ego (see `cadet.Agent`)."""

    @property
    def id(self) -> int: ...
    @property
    def class_name(self) -> str: ...
    @property
    def model(self) -> str: ...
    @property
    def size_lwh(self) -> list[float]: ...
    @property
    def world_from_agent(self) -> list[list[float]]: ...
    @property
    def velocity_world(self) -> list[float]: ...
    @property
    def pixels(self) -> list[float] | None: ...

@final
class Sighting:
    """What the first camera sees of an actor."""

    @property
    def actor_id(self) -> int: ...
    @property
    def class_name(self) -> str: ...
    @property
    def model(self) -> str: ...
    @property
    def is_labeled(self) -> bool: ...
    @property
    def truncation(self) -> float: ...
    @property
    def occlusion_level(self) -> int: ...
    @property
    def observation_angle(self) -> float: ...
    @property
    def bbox(self) -> tuple[float, float, float, float]: ...
    @property
    def visible_fraction(self) -> float: ...
    @property
    def visible_pixels(self) -> float: ...
    @property
    def contrast(self) -> float: ...
    @property
    def num_points(self) -> int: ...
    @property
    def velocity_world(self) -> list[float]: ...
    @property
    def silhouette_bbox(self) -> tuple[float, float, float, float] | None: ...
    @property
    def corner_visible(self) -> list[bool]: ...
    @property
    def size_lwh(self) -> list[float]: ...
    @property
    def location_cam(self) -> list[float]: ...
    @property
    def rotation_y(self) -> float: ...

@final
class Request:
    """What is to be captured; `sample` names the noise."""

    def __new__(
        cls, sample: int, *, maps: bool, pixels: bool, cameras: Sequence[int], lidars: Sequence[int]
    ) -> Request: ...

@final
class Capture:
    """Everything that was asked for at one instant (see `cadet.Sample`)."""

    @property
    def time_s(self) -> float: ...
    @property
    def world_from_ego(self) -> list[list[float]]: ...
    @property
    def ego_from_velo(self) -> list[list[float]]: ...
    @property
    def ego_speed_mps(self) -> float: ...
    @property
    def ego_velocity_world(self) -> list[float]: ...
    @property
    def map(self) -> str: ...
    @property
    def weather(self) -> str: ...
    @property
    def sun_rad(self) -> tuple[float, float]: ...
    @property
    def boxes(self) -> str: ...
    @property
    def plane(self) -> NDArray[np.float64]: ...
    @property
    def agents(self) -> list[Agent]: ...
    @property
    def sightings(self) -> list[Sighting]: ...
    @property
    def names(self) -> tuple[list[str], list[str]]: ...
    def image(self, index: int) -> NDArray[np.uint8]: ...
    def png(self, index: int) -> bytes: ...
    def maps(self, index: int) -> dict[str, NDArray[Any]] | None: ...
    def scan(self, index: int) -> dict[str, NDArray[Any]]: ...

@final
class Scene:
    """A town, its traffic and a rig (see `cadet.Scene`)."""

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
    ) -> Scene: ...
    @staticmethod
    def empty(
        *,
        map_name: str | None,
        map_xodr: str | None,
        weather: str,
        rig: Rig,
        config: SceneConfig,
        assets: Assets | None,
    ) -> Scene: ...
    def map_warnings(self) -> list[str]: ...
    @property
    def time_s(self) -> float: ...
    @property
    def num_triangles(self) -> int: ...
    @property
    def num_actors(self) -> int: ...
    def add(
        self,
        kind: str,
        model_seed: int,
        model: str | None,
        place: tuple[float, float, float] | None,
        speed: float | None,
        path: NDArray[np.float64] | None,
        may_overlap: bool,
    ) -> int: ...
    def move_ego(self, x: float, y: float, yaw: float, may_overlap: bool) -> None: ...
    def step(self, seconds: float) -> None: ...
    def drive(self, distance_m: float, blocked_s: float) -> None: ...
    def capture(self, request: Request) -> Capture: ...
    def capture_labeled(self, request: Request) -> Capture | None: ...
    def scan(self, lidar: Lidar | None, ideal: bool, sample: int) -> dict[str, NDArray[Any]]: ...
    def cast_rays(
        self, origins_world: NDArray[np.float64], directions_world: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]: ...
    def triangles(self) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.int32]]: ...
    def sensor_poses(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

def evaluate(
    truths: _EvaluationSource,
    detections: _EvaluationSource,
    *,
    classes: Sequence[tuple[str, Sequence[float]]],
    levels: Sequence[tuple[float, bool, float, float]],
) -> dict[str, Any]: ...
def box_iou(a: NDArray[np.float64], b: NDArray[np.float64], is_3d: bool) -> NDArray[np.float64]: ...
def nms_bev(boxes: NDArray[np.float64], scores: NDArray[np.float64], threshold: float) -> NDArray[np.int64]: ...
def bev_maps(
    points_cam: NDArray[np.float32] | NDArray[np.float64],
    plane: list[float],
    settings: dict[str, Any],
    out: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]: ...
def estimate_ground_plane(
    points_velo: NDArray[np.float32] | NDArray[np.float64], cam_from_velo: list[list[float]], seed: int
) -> list[float]: ...
def encode_png(image: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes: ...
def weather_air(name: str) -> tuple[float, float, float, float]: ...
def weather_names() -> list[str]: ...
def weather_recorded_scan(
    points_velo: NDArray[np.float32],
    *,
    fog: float,
    rain: float,
    snow: float,
    wetness: float,
    sensor_height_m: float,
    seed: int,
) -> tuple[NDArray[np.float32], NDArray[np.int8]]: ...
def _panic(text: str) -> None: ...
