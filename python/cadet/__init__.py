"""KITTI-format driving data from procedurally generated suburbs: images, LIDAR scans, exact 3D labels, with no GPU."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from cadet import bev
from cadet._cadet import __version__
from cadet.bev import BevConfig
from cadet.errors import (
    CadetError,
    CadetWarning,
    FrameExistsError,
    KittiFormatError,
    MissingFileError,
    NonFiniteError,
    ShapeError,
)
from cadet.formats import kitti
from cadet.formats.kitti import Calibration, Frame, FrameObject, Label
from cadet.sensors.beam_table import BeamTable, Laser
from cadet.sensors.camera import Camera
from cadet.sensors.extrinsics import Extrinsics
from cadet.sensors.firing import (
    EncoderFiring,
    ListedFiring,
    RasterFiring,
    RosetteFiring,
    TableFiring,
    UniformFiring,
)
from cadet.sensors.lidar import Lidar
from cadet.sensors.mounted import MountedCamera, MountedLidar
from cadet.sensors.pose import Pose
from cadet.sensors.rig import Rig
from cadet.sensors.sample import MATERIALS, Agent, Sample, Scan, ScanSurfaces
from cadet.sensors.semantic import Semantic
from cadet.simulation.environment import Environment
from cadet.simulation.scene import RayHits, Scene
from cadet.simulation.twin import twin
from cadet.worlds.assets import ActorMesh, Assets
from cadet.worlds.config import LabelConfig, PropConfig, SceneConfig, SuburbConfig
from cadet.worlds.districts import District
from cadet.worlds.draws import Draws
from cadet.worlds.policy import EpisodeSpec, ResetPolicy
from cadet.worlds.props import Props
from cadet.worlds.road_map import RoadMap
from cadet.worlds.weather import Weather, weather_names

if TYPE_CHECKING:
    from cadet import generate
    from cadet.evaluation import (
        Detections,
        EvalClass,
        GroundTruth,
        Level,
        Report,
        Rules,
        box_iou_3d,
        box_iou_bev,
        evaluate,
        nms_bev,
        read_detections,
        read_ground_truth,
    )
    from cadet.evaluation.analysis import Analysis, Comparison, analyze
    from cadet.figures.show import view
    from cadet.simulation.simulation import Simulation
    from cadet.simulation.streaming import FrameStream, stream

__all__ = [
    "MATERIALS",
    "ActorMesh",
    "Agent",
    "Analysis",
    "Assets",
    "BeamTable",
    "BevConfig",
    "CadetError",
    "CadetWarning",
    "Calibration",
    "Camera",
    "Comparison",
    "Detections",
    "District",
    "Draws",
    "EncoderFiring",
    "Environment",
    "EpisodeSpec",
    "EvalClass",
    "Extrinsics",
    "Frame",
    "FrameExistsError",
    "FrameObject",
    "FrameStream",
    "GroundTruth",
    "KittiFormatError",
    "Label",
    "LabelConfig",
    "Laser",
    "Level",
    "Lidar",
    "ListedFiring",
    "MissingFileError",
    "MountedCamera",
    "MountedLidar",
    "NonFiniteError",
    "Pose",
    "PropConfig",
    "Props",
    "RasterFiring",
    "RayHits",
    "Report",
    "ResetPolicy",
    "Rig",
    "RoadMap",
    "RosetteFiring",
    "Rules",
    "Sample",
    "Scan",
    "ScanSurfaces",
    "Scene",
    "SceneConfig",
    "Semantic",
    "ShapeError",
    "Simulation",
    "SuburbConfig",
    "TableFiring",
    "UniformFiring",
    "Weather",
    "__version__",
    "analyze",
    "bev",
    "box_iou_3d",
    "box_iou_bev",
    "evaluate",
    "generate",
    "kitti",
    "nms_bev",
    "read_detections",
    "read_ground_truth",
    "stream",
    "twin",
    "view",
    "weather_names",
]


_LATER = (
    "cadet.simulation.streaming",
    "cadet.simulation.simulation",
    "cadet.evaluation",
    "cadet.evaluation.analysis",
    "cadet.figures.show",
)


def __dir__() -> list[str]:
    """List what is public, and not the rooms that it comes from."""
    return sorted(__all__)


def __getattr__(name: str) -> Any:
    # Scenes and readers do without what writes datasets, starts processes, judges, and draws.
    if name == "generate":
        return import_module("cadet.generate")
    for module in map(import_module, _LATER) if name in __all__ else ():
        if hasattr(module, name):
            return globals().setdefault(name, getattr(module, name))
    raise AttributeError(f"module 'cadet' has no attribute {name!r}")
