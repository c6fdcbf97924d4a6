"""KITTI's `velodyne` files: little-endian float32 x, y, z, intensity; others' columns are read where they are known."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cadet.arrays import check_array
from cadet.kitti.dialects import accept
from cadet.kitti.scan_columns import layout_of

_BYTES_PER_POINT: Final = 16
_FARTHEST_M: Final = 1000.0
_MOST: Final = float(np.finfo(np.float32).max)


class ScanFile(NamedTuple):
    """A scan and, where its file has them, the numbers of its lasers."""

    points_velo: NDArray[np.float32]
    """(N, 4): x, y, z in meters, intensity as the file has it."""
    ring: NDArray[np.intp] | None
    """(N,), or None."""


def points_from_bytes(data: bytes, file: str = "velodyne") -> NDArray[np.float32]:
    """Read a scan.

    Columns after the fourth are left out where they are known to be rings, times or the like; so are points that are
    not finite. Both are dialects (`cadet.kitti.dialects`).

    Args:
        data: the file's bytes.
        file: its name for messages.

    Returns:
        (N, 4) float32 [x, y, z, intensity], meters in the velo frame.

    Raises:
        KittiFormatError: the file is cut off inside a point, or holds no points of x, y, z, intensity.
    """
    return scan_from_bytes(data, file).points_velo


def scan_from_bytes(data: bytes, file: str = "velodyne") -> ScanFile:
    """Read a scan and the numbers of its lasers: as `points_from_bytes`."""
    if len(data) % _BYTES_PER_POINT == 0:
        points_velo = np.frombuffer(data, "<f4").astype(np.float32).reshape(-1, 4)
        if _is_plain(points_velo):
            return ScanFile(points_velo, None)
    layout = layout_of(data, file)
    rows = np.frombuffer(data, layout.dtype).reshape(-1, layout.count)
    if layout.dtype != "<f4" or layout.count != 4:
        rest = "" if layout.count == 4 else ", the others left out"
        accept("scan-columns", f"{layout}: the first four read as x y z intensity in float32{rest}", file)
    is_finite = (np.abs(rows[:, :4]) <= _MOST).all(axis=1)
    if not is_finite.all():
        found = len(is_finite) - int(is_finite.sum())
        accept("scan-not-finite", f"{found} of {len(is_finite)} points are not finite and left out", file)
        rows = rows[is_finite]
    ring = None if layout.ring is None else _whole(rows[:, layout.ring])
    return ScanFile(np.ascontiguousarray(rows[:, :4], np.float32), ring)


def _is_plain(points_velo: NDArray[np.float32]) -> bool:
    """Tell whether points are as KITTI's: then no other count of columns can be meant."""
    if len(points_velo) == 0:
        return True
    low, high = float(points_velo.min()), float(points_velo.max())
    intensity = points_velo[:, 3]
    # Comparisons with NaN are false.
    return -_FARTHEST_M <= low and high <= _FARTHEST_M and float(intensity.min()) >= 0.0 and intensity.max() <= 1.0


def _whole(column: NDArray[Any]) -> NDArray[np.intp]:
    return np.where(np.isfinite(column), column, 0.0).astype(np.intp)


def bytes_from_points(points_velo: NDArray[np.float32]) -> bytes:
    """Write a scan.

    Raises:
        ShapeError: not (N, 4) float32.
        NonFiniteError: NaN or infinity.
    """
    check_array(points_velo, "points_velo", ("N", 4), np.float32, finite=True)
    return np.ascontiguousarray(points_velo, dtype="<f4").tobytes()
