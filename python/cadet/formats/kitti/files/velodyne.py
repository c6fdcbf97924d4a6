"""KITTI's `velodyne` files: little-endian float32 x, y, z, intensity; others' columns are read where they are known."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import check_array
from cadet.errors import KittiFormatError
from cadet.formats.kitti.files.dialects import accept
from cadet.formats.kitti.files.scan_columns import Layout, count_of, layout_of

_BYTES_PER_POINT: Final = 16
_LEAST: Final = 1e-6
_FEW_ROWS: Final = 600
_FARTHEST_M: Final = 1000.0
_MOST: Final = float(np.finfo(np.float32).max)


def points_from_bytes(data: bytes, file: str = "velodyne") -> NDArray[np.float32]:
    """Read a scan.

    Columns after the fourth are left out where they are known to be rings, times or the like; so are points that are
    not finite. Both are dialects (`cadet.formats.kitti.files.dialects`).

    Args:
        data: the file's bytes.
        file: its name for messages.

    Returns:
        (N, 4) float32 [x, y, z, intensity], meters in the velo frame.

    Raises:
        KittiFormatError: the file is cut off inside a point, or holds no points of x, y, z, intensity.
    """
    if len(data) % _BYTES_PER_POINT == 0:
        points_velo = np.frombuffer(data, "<f4").astype(np.float32).reshape(-1, 4)
        if _is_plain(points_velo):
            return points_velo
    layout = layout_of(data, file)
    rows = layout.rows(data)[:, :4]
    if layout != Layout("<f4", 4):
        rest = "" if layout.count == 4 else ", the others left out"
        accept("scan-columns", f"{layout}: the first four read as x y z intensity in float32{rest}", file)
    is_finite = is_whole_point(rows)
    if not is_finite.all():
        found = int((~is_finite).sum())
        if found == len(rows):
            raise KittiFormatError(f"none of {found} points is finite", file)
        accept("scan-not-finite", f"{found} of {len(rows)} points are not finite and left out", file)
    return np.ascontiguousarray(rows[is_finite], np.float32)


def is_whole_point(rows: NDArray[Any]) -> NDArray[np.bool_]:
    """Tell which rows (N, 4) of any type hold numbers that float32 can hold, as nothing that returned does not."""
    whole: NDArray[np.bool_] = (np.abs(rows) <= _MOST).all(axis=1)
    return whole


def _is_plain(points_velo: NDArray[np.float32]) -> bool:
    """Tell whether points are as KITTI's: then no other count of columns can be meant."""
    if len(points_velo) == 0:
        return True
    low, high = float(points_velo.min()), float(points_velo.max())
    intensity = points_velo[:, 3]
    brightest = float(intensity.max())
    # Text and whole numbers, taken for floats, are tiny; comparisons with NaN are false.
    if 0.0 < max(high, -low) < _LEAST or 0.0 < brightest < _LEAST or not (low >= -_FARTHEST_M and high <= _FARTHEST_M):
        return False
    if float(intensity.min()) < 0.0 or brightest > 1.0:
        return False
    # Of eight or more numbers a point, rows would hold places and other things in turn.
    return count_of(points_velo[:_FEW_ROWS].reshape(-1)) in (None, 4)


def bytes_from_points(points_velo: NDArray[np.float32]) -> bytes:
    """Write a scan.

    Raises:
        ShapeError: not (N, 4) float32.
        NonFiniteError: NaN or infinity.
    """
    check_array(points_velo, "points_velo", ("N", 4), np.float32, finite=True)
    return np.ascontiguousarray(points_velo, dtype="<f4").tobytes()
