"""A drive of KITTI's raw data, written by hand."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cadet.formats.kitti.files.images import encode_png
from cadet.formats.kitti.files.velodyne import bytes_from_points
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti_sequences.raw_calibration import calibration_files


def write_raw_drive(root: Path, frames: Sequence[Frame]) -> Path:
    """Write frames of one calibration; return the drive's folder."""
    day = root / "2011_09_26"
    drive = day / "2011_09_26_drive_0001_sync"
    for index, frame in enumerate(frames):
        height, width = frame.image.shape[:2]
        for name, text in calibration_files(frame.calib, (width, height), "26-Sep-2011").items():
            day.mkdir(exist_ok=True)
            (day / name).write_text(text)
        files = {"image_02/data": (encode_png(frame.image), "png")}
        files["velodyne_points/data"] = (bytes_from_points(frame.points_velo), "bin")
        for folder, (data, suffix) in files.items():
            (drive / folder).mkdir(parents=True, exist_ok=True)
            (drive / folder / f"{index:010d}.{suffix}").write_bytes(data)
    return drive
