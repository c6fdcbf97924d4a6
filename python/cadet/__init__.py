"""KITTI-format driving data from procedurally generated suburbs: images, LIDAR scans, exact 3D labels, with no GPU."""

from cadet import bev, kitti
from cadet._cadet import __version__
from cadet.analysis import Analysis, Comparison, analyze
from cadet.assets import Assets, VehicleMesh
from cadet.beam_table import BeamTable, EncoderFiring, Laser, ListedFiring, UniformFiring
from cadet.bev import BevConfig
from cadet.camera import Camera
from cadet.config import LabelConfig, PropConfig, SceneConfig, SuburbConfig
from cadet.districts import District
from cadet.environment import Environment
from cadet.errors import (
    CadetError,
    CadetWarning,
    FrameExistsError,
    KittiFormatError,
    MissingFileError,
    NonFiniteError,
    ShapeError,
)
from cadet.evaluation import (
    Detections,
    EvalClass,
    GroundTruth,
    Level,
    Report,
    box_iou_3d,
    box_iou_bev,
    evaluate,
    nms_bev,
    read_detections,
    read_ground_truth,
    read_rules,
)
from cadet.extrinsics import Extrinsics
from cadet.kitti import Calibration, Frame, FrameObject, Label
from cadet.lidar import Lidar
from cadet.mounted import MountedCamera, MountedLidar
from cadet.policy import ResetPolicy
from cadet.pose import Pose
from cadet.props import Props
from cadet.rig import Rig
from cadet.road_map import RoadMap
from cadet.sample import Agent, Sample, Scan
from cadet.scene import RayHits, Scene
from cadet.semantic import Semantic
from cadet.simulation import Simulation
from cadet.streaming import FrameStream, stream
from cadet.weather import weather_names

__all__ = [
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
    "EncoderFiring",
    "Environment",
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
    "RayHits",
    "Report",
    "ResetPolicy",
    "Rig",
    "RoadMap",
    "Sample",
    "Scan",
    "Scene",
    "SceneConfig",
    "Semantic",
    "ShapeError",
    "Simulation",
    "SuburbConfig",
    "UniformFiring",
    "VehicleMesh",
    "__version__",
    "analyze",
    "bev",
    "box_iou_3d",
    "box_iou_bev",
    "evaluate",
    "kitti",
    "nms_bev",
    "read_detections",
    "read_ground_truth",
    "read_rules",
    "stream",
    "weather_names",
]
