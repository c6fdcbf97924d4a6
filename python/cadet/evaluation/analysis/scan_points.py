"""How many LIDAR returns lie in the boxes of a folder's frames."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet.errors import MissingFileError
from cadet.evaluation.packed import Packed
from cadet.formats import kitti
from cadet.formats.kitti.boxes import points_in_boxes
from cadet.formats.kitti.files.velodyne import points_from_bytes


def count_points(scans: Path, ids: Sequence[str], sides: Sequence[Packed[Any]]) -> tuple[NDArray[np.int64], ...]:
    """Count the returns in boxes; faces count as inside.

    Args:
        scans: the folder that holds `velodyne` and `calib`.
        ids: of the frames.
        sides: boxes of the same frames; a box without a size has no points.

    Returns:
        (n,) for each side.

    Raises:
        MissingFileError: a frame without a scan or a calibration.
        KittiFormatError: a damaged one.
    """
    counts = tuple(np.zeros(len(side.objects.types), np.int64) for side in sides)
    for frame, frame_id in enumerate(ids):
        parts = [slice(int(side.starts[frame]), int(side.starts[frame + 1])) for side in sides]
        if all(part.start == part.stop for part in parts):
            continue
        path = scans / "velodyne" / f"{frame_id}.bin"
        if not path.is_file():
            raise MissingFileError(f"{path}: no such scan")
        points_velo = points_from_bytes(path.read_bytes(), f"velodyne/{path.name}")
        points_cam = kitti.read_calib(scans, frame_id).points_cam_from_velo(points_velo)
        for side, part, found in zip(sides, parts, counts, strict=True):
            boxes_cam = side.objects.boxes_cam[part].astype(np.float64)
            found[part] = points_in_boxes(points_cam, boxes_cam).sum(axis=0)
    return counts
