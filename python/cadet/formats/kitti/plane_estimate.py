"""The ground plane of a scan that comes without a plane file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.arrays import check_array
from cadet._util.checks import as_seed, check_kind
from cadet.errors import ShapeError
from cadet.formats.kitti.calib import Calibration


def estimate_plane(points_velo: NDArray[Any], calib: Calibration, seed: int = 0) -> NDArray[np.float64]:
    """Estimate the road's plane ahead of the camera by random sample consensus and least squares.

    Looks at points 2 to 50 m ahead, 8 m to either side and below the camera. The same seed gives the same plane.

    Args:
        points_velo: (N, 3) or wider, meters, velo frame.
        calib: the calibration.
        seed: of the random samples, at least 0.

    Returns:
        (4,) float64 a, b, c, d in the frame of camera 0: unit normal, b < 0, d the camera's height in meters.

    Raises:
        ShapeError: `points_velo` has fewer than three columns.
        NonFiniteError: NaN or infinity in the points.
        CadetError: no calibration, an invalid seed, too few points ahead, or none of them in a plane that a car
            could stand on.

    Reference: Fischler and Bolles, "Random Sample Consensus" (1981); cells, weights and prior are ours.
    """
    check_array(points_velo, "points_velo", ("N", "C"), finite=True)
    if points_velo.shape[1] < 3:
        raise ShapeError(f"points_velo: expected (N, 3) or wider, got {points_velo.shape}")
    if points_velo.dtype not in (np.float32, np.float64):
        points_velo = points_velo.astype(np.float64)
    check_kind("", "calib", calib, Calibration)
    cam_from_velo = calib.cam_from_velo[:3].tolist()
    return np.array(_cadet.estimate_ground_plane(points_velo, cam_from_velo, as_seed(seed)), np.float64)
