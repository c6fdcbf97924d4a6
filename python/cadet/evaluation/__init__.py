"""KITTI's average precision as the official program computes it, decision by decision (`docs/evaluation.md`)."""

from cadet.evaluation.classes import EvalClass
from cadet.evaluation.curve import Curve
from cadet.evaluation.foreign import read_detections, read_ground_truth
from cadet.evaluation.levels import LEVELS, Level
from cadet.evaluation.objects import Detections, GroundTruth
from cadet.evaluation.overlaps import box_iou_3d, box_iou_bev, nms_bev
from cadet.evaluation.report import Report
from cadet.evaluation.rules_file import Rules
from cadet.evaluation.run import evaluate

__all__ = [
    "LEVELS",
    "Curve",
    "Detections",
    "EvalClass",
    "GroundTruth",
    "Level",
    "Report",
    "Rules",
    "box_iou_3d",
    "box_iou_bev",
    "evaluate",
    "nms_bev",
    "read_detections",
    "read_ground_truth",
]
