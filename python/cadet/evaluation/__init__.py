"""KITTI's average precision as the official program computes it, decision by decision (`docs/evaluation.md`)."""

from cadet.evaluation.levels import LEVELS, Level
from cadet.evaluation.objects import Detections, GroundTruth
from cadet.evaluation.overlaps import box_iou_3d, box_iou_bev, nms_bev
from cadet.evaluation.report import Curve, Report
from cadet.evaluation.run import evaluate

__all__ = [
    "LEVELS",
    "Curve",
    "Detections",
    "GroundTruth",
    "Level",
    "Report",
    "box_iou_3d",
    "box_iou_bev",
    "evaluate",
    "nms_bev",
]
