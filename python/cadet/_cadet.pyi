"""The Rust core. Private: use the wrappers of `cadet`, which are typed, documented and keyword-only."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Assets",
    "Lidar",
    "Scene",
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
        rig: Mapping[str, Any],
        config: Mapping[str, Any],
        assets: Assets | None,
    ) -> Scene: ...
    @staticmethod
    def empty(
        *,
        map_name: str | None,
        map_xodr: str | None,
        weather: str,
        rig: Mapping[str, Any],
        config: Mapping[str, Any],
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
    def capture(self, sample: int, maps: bool) -> dict[str, Any]: ...
    def capture_labelled(self, sample: int, maps: bool) -> dict[str, Any] | None: ...
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
