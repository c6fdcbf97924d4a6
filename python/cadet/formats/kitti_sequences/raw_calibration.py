"""KITTI raw's three calibration files, for images that are rectified already."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.files.numbers import scientific_text
from cadet.sensors.pose import inverse, product


def calibration_files(calib: Calibration, image_size: tuple[int, int], day: str) -> dict[str, str]:
    """Return the files of a day by name.

    `S`, `K`, and `D` of a camera are those of its rectified images, since there are no others: `D` is 0.

    Args:
        calib: the calibration.
        image_size: width and height in pixels.
        day: such as "01-Jan-2020".
    """
    time = f"calib_time: {day} 12:00:00"
    velo_to_cam = calib.Tr_velo_to_cam
    imu_to_velo = calib.Tr_imu_to_velo
    return {
        "calib_cam_to_cam.txt": _text([time, "corner_dist: 0.000000e+00", *_cameras(calib, image_size)]),
        "calib_velo_to_cam.txt": _text(
            [time, *_rigid(velo_to_cam), _line("delta_f", (0.0, 0.0)), _line("delta_c", (0.0, 0.0))]
        ),
        "calib_imu_to_velo.txt": _text([time, *_rigid(imu_to_velo)]),
    }


def _cameras(calib: Calibration, image_size: tuple[int, int]) -> Iterable[str]:
    width, height = image_size
    unrectified = np.eye(4)
    unrectified[:3, :3] = calib.R0_rect.T
    for index, projection in enumerate((calib.P0, calib.P1, calib.P2, calib.P3)):
        intrinsic = np.eye(4)
        intrinsic[:3, :3] = projection[:, :3]
        # Where the cam frame's origin stands in the camera's.
        shift = np.eye(4)
        shift[:3, 3] = product(inverse(intrinsic)[:3, :3], projection[:, 3:])[:, 0]
        place = product(unrectified, shift)[:3, 3]
        size = f"{scientific_text(width)} {scientific_text(height)}"
        yield f"S_{index:02d}: {size}"
        yield _line(f"K_{index:02d}", projection[:, :3].flat)
        yield _line(f"D_{index:02d}", (0.0,) * 5)
        yield _line(f"R_{index:02d}", np.eye(3).flat)
        yield _line(f"T_{index:02d}", place)
        yield f"S_rect_{index:02d}: {size}"
        yield _line(f"R_rect_{index:02d}", calib.R0_rect.flat)
        yield _line(f"P_rect_{index:02d}", projection.flat)


def _rigid(matrix: NDArray[np.float64]) -> Iterable[str]:
    return _line("R", matrix[:, :3].flat), _line("T", matrix[:, 3])


def _line(key: str, values: Iterable[float]) -> str:
    return f"{key}: {' '.join(scientific_text(value) for value in values)}"


def _text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)
