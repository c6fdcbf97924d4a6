"""KITTI's object data: frozen dataclasses for its files, whole frames, and a lint."""

from cadet.formats.kitti.calib import Calibration, points_in_image
from cadet.formats.kitti.dataset import (
    Dataset,
    encode_frame,
    encode_meta,
    read_calib,
    read_frame,
    read_labels,
    read_meta,
    write_frame,
)
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.frame_object import FrameObject
from cadet.formats.kitti.from_sample import frame_from_sample
from cadet.formats.kitti.image_sets import ImageSet, read_image_set, write_image_set
from cadet.formats.kitti.label import TYPES, Label, boxes_cam_from_labels, labels_from_text, text_from_labels
from cadet.formats.kitti.lint import RULES, Finding, lint, lint_frame
from cadet.formats.kitti.plane_estimate import estimate_plane

__all__ = [
    "RULES",
    "TYPES",
    "Calibration",
    "Dataset",
    "Finding",
    "Frame",
    "FrameObject",
    "ImageSet",
    "Label",
    "boxes_cam_from_labels",
    "encode_frame",
    "encode_meta",
    "estimate_plane",
    "frame_from_sample",
    "labels_from_text",
    "lint",
    "lint_frame",
    "points_in_image",
    "read_calib",
    "read_frame",
    "read_image_set",
    "read_labels",
    "read_meta",
    "text_from_labels",
    "write_frame",
    "write_image_set",
]
