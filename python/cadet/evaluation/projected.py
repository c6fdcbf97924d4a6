"""2D boxes of objects that have none: what their 3D boxes make of themselves in the image."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.evaluation.objects import Detections, GroundTruth
from cadet.evaluation.packed import Packed
from cadet.formats import kitti
from cadet.formats.kitti import boxes
from cadet.formats.kitti.files import images
from cadet.formats.kitti.files.folder import file_path
from cadet.formats.kitti.frame_files import FolderFiles

IMAGE_SIZE: Final = (1242, 375)
"""KITTI's, in pixels: that of frames without an image."""

_UNKNOWN_PLACE: Final = -1000.0
_PNG_HEADER: Final = struct.Struct(">8s4x4sII")


def project_sides(
    truths: Packed[GroundTruth], detections: Packed[Detections], ids: Sequence[str], folder: Path
) -> tuple[Packed[GroundTruth], Packed[Detections]]:
    """Give each detection the 2D box and the observation angle of its 3D box, and objects without a 2D box theirs.

    What has no 3D box, or one behind the camera, keeps what it has.

    Args:
        truths: of the frames.
        detections: of the same frames.
        ids: of the frames.
        folder: holds `calib`, and `image_2` if there are images, whose sizes 2D boxes are clipped to.

    Raises:
        MissingFileError: a frame without a calibration.
        KittiFormatError: a damaged one.
    """
    seen_truths, seen_detections = (side.objects.boxes_img.astype(np.float64) for side in (truths, detections))
    alphas = detections.objects.alphas.astype(np.float64)
    is_empty = (seen_truths[:, 0] == seen_truths[:, 2]) | (seen_truths[:, 1] == seen_truths[:, 3])
    wanted = (_has_box(truths) & is_empty, _has_box(detections))
    sides: tuple[Packed[Any], Packed[Any]] = (truths, detections)
    for frame, frame_id in enumerate(ids):
        parts = [_rows(side, frame, rows) for side, rows in zip(sides, wanted, strict=True)]
        if not any(map(len, parts)):
            continue
        calib, size = kitti.read_calib(folder, frame_id), _image_size(folder, frame_id)
        for side, seen, rows in zip(sides, (seen_truths, seen_detections), parts, strict=True):
            whole = boxes.project_boxes(side.objects.boxes_cam[rows], calib)
            is_ahead = np.isfinite(whole).all(axis=1)
            seen[rows[is_ahead]] = boxes.clip_boxes_img(whole[is_ahead], size)
        alphas[parts[1]] = boxes.alpha_from_boxes(detections.objects.boxes_cam[parts[1]])
    return truths.changed(boxes_img=seen_truths), detections.changed(boxes_img=seen_detections, alphas=alphas)


def _has_box(side: Packed[Any]) -> NDArray[np.bool_]:
    boxes_cam = side.objects.boxes_cam
    has_box: NDArray[np.bool_] = (boxes_cam[:, 3:6] > 0.0).all(axis=1) & (boxes_cam[:, :3] != _UNKNOWN_PLACE).all(
        axis=1
    )
    return has_box


def _rows(side: Packed[Any], frame: int, is_wanted: NDArray[np.bool_]) -> NDArray[np.int64]:
    first, end = int(side.starts[frame]), int(side.starts[frame + 1])
    return first + np.flatnonzero(is_wanted[first:end])


def _image_size(folder: Path, frame_id: str) -> tuple[int, int]:
    """Return width and height of a frame's image: of a PNG file from its header, without decoding it."""
    path = file_path(folder, "image_2", frame_id)
    if path.is_file():
        with path.open("rb") as file:
            start = file.read(_PNG_HEADER.size)
        if start.startswith(b"\x89PNG") and len(start) == _PNG_HEADER.size:
            _, _, width, height = _PNG_HEADER.unpack(start)
            return width, height
    files = FolderFiles(folder)
    if not files.has("image_2", frame_id):
        return IMAGE_SIZE
    image = images.decode_image(*files.read("image_2", frame_id))
    return image.shape[1], image.shape[0]
