"""The Rust core. Private: use the wrappers of `cadet`, which are typed, documented and keyword-only."""

from collections.abc import Sequence
from os import PathLike
from typing import Any, Final, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ActorMesh",
    "Agent",
    "Assets",
    "BevConfig",
    "Camera",
    "Capture",
    "Lidar",
    "Pose",
    "Request",
    "Rig",
    "Scene",
    "SceneConfig",
    "Sighting",
    "Weather",
    "__version__",
    "_panic",
    "bev_maps",
    "box_iou",
    "check_props",
    "decode_image",
    "encode_png",
    "estimate_ground_plane",
    "evaluate",
    "evaluate_draws",
    "limits",
    "nms_bev",
    "read_detections",
    "read_truths",
    "settings",
    "weather_names",
    "weather_preset",
    "weather_recorded_scan",
]

__version__: str

# A folder and each frame's id, or packed objects: where each frame begins and the end, type names, numbers.
_EvaluationSource: TypeAlias = (
    tuple[str | PathLike[str], Sequence[str | None]] | tuple[Sequence[int], Sequence[str], NDArray[np.float64]]
)

# Of a configuration's numbers: name, then defaults (none where it is drawn), least and greatest value, and whether it
# counts.
_Settings: TypeAlias = list[tuple[str, tuple[list[float], float, float, bool]]]

@final
class ActorMesh:
    """An actor's mesh, not yet built (see `cadet.ActorMesh`)."""

    MAX_TRIANGLES: int
    MAX_MATERIALS: int
    def __new__(
        cls,
        *,
        name: str,
        class_name: str,
        file: str,
        corners: NDArray[np.float32],
        material_ids: NDArray[np.uint32],
        part_ids: NDArray[np.uint32],
        source_materials: Sequence[tuple[str, tuple[float, float, float] | None, float]],
        parts: Sequence[Sequence[str]],
        scale: float,
        yaw_rad: float,
        y_up: bool,
        size_lwh: tuple[float, float, float] | None,
        materials: Sequence[tuple[str, Sequence[str]]],
        leave_out: Sequence[str] | None,
    ) -> ActorMesh: ...

@final
class Assets:
    """Actors built from a user's meshes, and a user's props (see `cadet.Assets`)."""

    def __new__(cls, share: float, actors: Sequence[ActorMesh], props: Sequence[tuple[str, str]]) -> Assets: ...
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
    def return_modes() -> list[str]: ...
    @staticmethod
    def materials() -> list[str]: ...
    @staticmethod
    def from_table(table: object) -> Lidar: ...
    name: Final[str]
    num_rings: Final[int]
    num_columns: Final[int]
    def single_origin(self) -> Lidar: ...
    def scanning(self, *, rolling: bool, returns: str, divergence_mrad: float) -> Lidar: ...
    def table(self) -> dict[str, Any]: ...
    def span_s(self) -> list[float] | None: ...
    def rays(
        self, *, time_s: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]: ...

@final
class SceneConfig:
    """How full a scene is, what stands in it, and its sun (see `cadet.SceneConfig`)."""

    def __new__(cls, config: object) -> SceneConfig: ...
    @staticmethod
    def vehicle_classes() -> list[str]: ...

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
        is_fisheye: bool,
        projection: NDArray[np.float64],
        distortion: Sequence[float],
        rolling_shutter_s: float,
        motion_blur_s: float,
        exposure_ev: float,
        noise: float,
        white_balance: Sequence[float],
        response: str | Sequence[Sequence[float]],
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

    id: Final[int]
    class_name: Final[str]
    model: Final[str]
    size_lwh: Final[list[float]]
    world_from_agent: Final[list[list[float]]]
    velocity_world: Final[list[float]]
    brakes_for: Final[tuple[str, int | None] | None]
    pixels: Final[list[float] | None]

@final
class Sighting:
    """What a camera sees of an actor."""

    actor_id: Final[int]
    class_name: Final[str]
    model: Final[str]
    is_labeled: Final[bool]
    truncation: Final[float]
    occlusion_level: Final[int]
    observation_angle: Final[float]
    bbox: Final[tuple[float, float, float, float]]
    visible_fraction: Final[float]
    visible_pixels: Final[float]
    contrast: Final[float]
    num_points: Final[int]
    velocity_world: Final[list[float]]
    silhouette_bbox: Final[tuple[float, float, float, float] | None]
    corner_visible: Final[list[bool]]
    size_lwh: Final[list[float]]
    location_cam: Final[list[float]]
    rotation_y: Final[float]

@final
class Request:
    """What is to be captured; `sample` names the noise."""

    def __new__(
        cls,
        sample: int,
        *,
        maps: bool,
        normals: bool,
        scene_flow: bool,
        optical_flow_s: float | None,
        radiance: bool,
        pixels: bool,
        sightings: bool,
        cameras: Sequence[int],
        lidars: Sequence[int],
    ) -> Request: ...

@final
class Capture:
    """Everything that was asked for at one instant (see `cadet.Sample`)."""

    time_s: Final[float]
    world_from_ego: Final[list[list[float]]]
    ego_from_velo: Final[list[list[float]]]
    ego_speed_mps: Final[float]
    ego_velocity_world: Final[list[float]]
    ego_angular_velocity_world: Final[list[float]]
    map: Final[str]
    map_offset_m: Final[list[float]]
    map_geo_reference: Final[tuple[str, list[float], float] | None]
    weather: Final[str]
    sun_rad: Final[tuple[float, float]]
    boxes: Final[str]
    plane: Final[NDArray[np.float64]]
    agents: Final[list[Agent]]
    names: Final[tuple[list[str], list[str]]]
    def sightings(self, index: int) -> list[Sighting] | None: ...
    def image(self, index: int) -> NDArray[np.uint8]: ...
    def radiance(self, index: int) -> NDArray[np.float32] | None: ...
    def png(self, index: int) -> bytes: ...
    def maps(self, index: int) -> dict[str, NDArray[Any]] | None: ...
    def scan(self, index: int) -> dict[str, Any]: ...

@final
class Weather:
    """A weather in numbers (see `cadet.Weather`)."""

    def __new__(
        cls,
        name: str,
        *,
        rain_mm_h: float,
        fog_visibility_m: float | None,
        snow_mm_h: float,
        wetness: float,
        cloud_cover: float,
        wind_mps: float,
        sun_elevation_deg: float | None,
        sun_azimuth_deg: float | None,
    ) -> Weather: ...

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
        weather: Weather,
        rig: Rig,
        config: SceneConfig,
        assets: Assets | None,
    ) -> Scene: ...
    @staticmethod
    def empty(
        *,
        map_name: str | None,
        map_xodr: str | None,
        weather: Weather,
        rig: Rig,
        config: SceneConfig,
        assets: Assets | None,
    ) -> Scene: ...
    def map_warnings(self) -> list[str]: ...
    def shortfalls(self) -> list[tuple[str, int, int]]: ...
    time_s: Final[float]
    num_triangles: Final[int]
    num_actors: Final[int]
    agents: Final[list[Agent]]
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
    def hide_actor(self, actor_id: int) -> None: ...
    def shift_actor(self, actor_id: int, forward_m: float, left_m: float, yaw_rad: float) -> None: ...
    def command_ego(self, command: tuple[float, float] | None) -> None: ...
    def step(self, seconds: float, ego_returns: bool = False) -> None: ...
    ego_brakes_for: Final[tuple[str, int | None] | None]
    ego_is_at_road_end: Final[bool]
    def drive(self, distance_m: float, blocked_s: float) -> None: ...
    def capture(self, request: Request) -> Capture: ...
    def capture_labeled(self, request: Request) -> Capture | None: ...
    def scan(self, lidar: Lidar | None, *, ideal: bool, surfaces: bool, sample: int) -> dict[str, Any]: ...
    def cast_rays(
        self, origins_world: NDArray[np.float64], directions_world: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]: ...
    def triangles(self) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.int32]]: ...
    def sensor_poses(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

def evaluate(
    truths: _EvaluationSource,
    detections: _EvaluationSource,
    *,
    classes: Sequence[tuple[Sequence[str], Sequence[str], Sequence[float]]],
    levels: Sequence[tuple[float, bool, float, float]],
) -> dict[str, Any]: ...
def evaluate_draws(
    truths: _EvaluationSource,
    detections: _EvaluationSource,
    *,
    classes: Sequence[tuple[Sequence[str], Sequence[str], Sequence[float]]],
    levels: Sequence[tuple[float, bool, float, float]],
    draws: tuple[Sequence[int], NDArray[np.uint32]],
) -> list[dict[str, Any]]: ...
def read_truths(
    folder: str | PathLike[str], ids: Sequence[str | None]
) -> tuple[list[int], list[str], NDArray[np.float64]]: ...
def read_detections(
    folder: str | PathLike[str], ids: Sequence[str | None]
) -> tuple[list[int], list[str], NDArray[np.float64]]: ...
def box_iou(a: NDArray[np.float64], b: NDArray[np.float64], is_3d: bool) -> NDArray[np.float64]: ...
def check_props(files: Sequence[tuple[str, str]]) -> None: ...
def limits() -> dict[str, tuple[float, float]]: ...
def nms_bev(boxes: NDArray[np.float64], scores: NDArray[np.float64], threshold: float) -> NDArray[np.int64]: ...
def settings() -> dict[str, _Settings]: ...

@final
class BevConfig:
    """Bird's-eye-view maps (see `cadet.bev.BevConfig`)."""

    def __new__(
        cls,
        *,
        slice_maps: Sequence[str],
        cloud_maps: Sequence[str],
        num_slices: int,
        height_m: tuple[float, float],
        range_cam_m: Sequence[tuple[float, float]],
        cell_m: float,
        height: str,
    ) -> BevConfig: ...

def bev_maps(
    points_cam: NDArray[np.float32] | NDArray[np.float64],
    plane: list[float],
    config: BevConfig,
    out: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]: ...
def estimate_ground_plane(
    points_velo: NDArray[np.float32] | NDArray[np.float64], cam_from_velo: list[list[float]], seed: int
) -> list[float]: ...
def decode_image(data: bytes, max_pixels: int) -> tuple[NDArray[np.uint8] | NDArray[np.uint16], str, bool, bool]: ...
def encode_png(image: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes: ...
def weather_preset(name: str) -> tuple[float, float | None, float, float, float, float]: ...
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
