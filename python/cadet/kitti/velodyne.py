"""KITTI's `velodyne` files: little-endian float32 x, y, z, intensity."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.arrays import check_array
from cadet.errors import KittiFormatError

_BYTES_PER_POINT: Final = 16


def points_from_bytes(data: bytes, file: str = "velodyne") -> NDArray[np.float32]:
    """Read a scan.

    Args:
        data: the file's bytes.
        file: its name for messages.

    Returns:
        (N, 4) float32 [x, y, z, intensity], meters in the velo frame.

    Raises:
        KittiFormatError: the file is cut off inside a point, or holds NaN or infinity.
    """
    if len(data) % _BYTES_PER_POINT:
        whole = len(data) // _BYTES_PER_POINT
        raise KittiFormatError(f"truncated: {len(data)} bytes are {whole} points and {len(data) % 16} bytes", file)
    points_velo = np.frombuffer(data, "<f4").astype(np.float32).reshape(-1, 4)
    # Row by row only where it is needed: that takes forty times as long.
    if not np.isfinite(points_velo).all():
        is_finite = np.isfinite(points_velo).all(axis=1)
        raise KittiFormatError(f"point {int(np.argmin(is_finite))} is not finite", file)
    return points_velo


def bytes_from_points(points_velo: NDArray[np.float32]) -> bytes:
    """Write a scan.

    Raises:
        ShapeError: not (N, 4) float32.
        NonFiniteError: NaN or infinity.
    """
    check_array(points_velo, "points_velo", ("N", 4), np.float32, finite=True)
    return np.ascontiguousarray(points_velo, dtype="<f4").tobytes()
