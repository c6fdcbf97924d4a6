"""What OpenPCDet and MMDetection3D know of a frame, by the rules of their code that makes info files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cadet import kitti


@dataclass
class Info:
    """What a toolbox knows of a frame once its info file is made."""

    names: list[str]
    """Of the first n lines, n being the number of objects."""
    boxes_cam: NDArray[np.float64]
    heights_px: NDArray[np.float64]
    truncated: NDArray[np.float64]
    occluded: list[int]
    calib: dict[str, NDArray[np.float32]]
    points_velo: NDArray[np.float32]
    image_size: tuple[int, int]


def read_info(root: Path, part: str, frame_id: str) -> Info:
    """Read a frame by place alone: lines of the calibration by their number, fields between single blanks."""
    folder = root / part
    rows = [line.strip().split(" ") for line in (folder / "label_2" / f"{frame_id}.txt").read_text().splitlines()]
    num_objects = sum(row[0] != "DontCare" for row in rows)
    rows = rows[:num_objects]
    numbers = np.array([[float(value) for value in row[3:15]] for row in rows]).reshape(-1, 12)
    lines = (folder / "calib" / f"{frame_id}.txt").read_text().split("\n")
    shapes = {"P2": (2, (3, 4)), "R0": (4, (3, 3)), "V2C": (5, (3, 4))}
    calib = {
        name: np.array(lines[number].strip().split(" ")[1:], np.float32).reshape(shape)
        for name, (number, shape) in shapes.items()
    }
    return Info(
        names=[row[0] for row in rows],
        boxes_cam=np.hstack([numbers[:, 8:11], numbers[:, [7, 6, 5]], numbers[:, 11:12]]),
        heights_px=numbers[:, 4] - numbers[:, 2],
        truncated=np.array([float(row[1]) for row in rows]),
        occluded=[int(row[2]) for row in rows],
        calib=calib,
        points_velo=np.fromfile(folder / "velodyne" / f"{frame_id}.bin", np.float32).reshape(-1, 4),
        image_size=kitti.read_frame(folder, frame_id).image_size,
    )


def ids_of(root: Path, split: str) -> list[str]:
    """Return the frames of a split's list."""
    return [f"{int(line):06d}" for line in (root / "ImageSets" / f"{split}.txt").read_text().splitlines()]
