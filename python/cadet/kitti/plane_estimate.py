"""The ground plane of a scan that comes without a plane file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet.arrays import check_array
from cadet.draws import Draws
from cadet.errors import CadetError
from cadet.kitti.calib import Calibration

_AHEAD_M = (2.0, 20.0)
_ASIDE_M = 8.0
# A car's sensors look down on the road from no lower and no higher than this.
_BELOW_CAMERA_M = (0.3, 4.0)
_MAX_TILT_RAD = np.radians(12.0)
_INLIER_M = 0.06
# A pavement lies a kerb's height over the road and would lift the plane: what stands out above is let go step by step.
_TIGHTER_M = (0.06, 0.0525, 0.045, 0.0375, 0.03, 0.03)
_HYPOTHESES = 400
_MIN_POINTS = 30


def estimate_plane(points_velo: NDArray[Any], calib: Calibration, seed: int = 0) -> NDArray[np.float64]:
    """Estimate the road's plane ahead of the camera by random sample consensus and least squares.

    Looks at points 2 to 20 m ahead, 8 m to either side and below the camera. The same seed gives the same plane.

    Args:
        points_velo: (N, 3) or wider, metres, velo frame.
        calib: the calibration.
        seed: of the random samples, at least 0.

    Returns:
        (4,) float64 a, b, c, d in the frame of camera 0: unit normal, b < 0, d the camera's height in metres.

    Raises:
        ShapeError: `points_velo` has fewer than three columns.
        NonFiniteError: NaN or infinity in the points.
        CadetError: too few points ahead, or none of them in a plane that a car could stand on.

    Reference: Fischler and Bolles, "Random Sample Consensus" (1981).
    """
    check_array(points_velo, "points_velo", ("N", "C"), finite=True)
    near_cam = _ahead(calib.velo_to_cam(points_velo))
    if len(near_cam) < _MIN_POINTS:
        raise CadetError(
            f"points_velo: expected at least {_MIN_POINTS} points of the ground {_AHEAD_M[0]:g} to {_AHEAD_M[1]:g} m"
            f" ahead of the camera, got {len(near_cam)}"
        )
    draws = Draws(seed, 0, 0, "ground plane")
    thinned_cam, weights = _thin_out(near_cam)
    samples = [[draws.count(0, len(thinned_cam) - 1) for _ in range(3)] for _ in range(_HYPOTHESES)]
    planes = [plane for plane in map(_through, thinned_cam[samples]) if plane is not None]
    if not planes:
        raise CadetError("points_velo: no plane that a car could stand on ahead of the camera")
    candidates = np.stack(planes)
    height_m = candidates[:, :3] @ thinned_cam.T + candidates[:, 3:]
    plane: NDArray[np.float64] = candidates[np.argmax((np.abs(height_m) < _INLIER_M) @ weights)]
    for above_m in _TIGHTER_M:
        height_m = thinned_cam @ plane[:3] + plane[3]
        near = (height_m < above_m) & (height_m > -_INLIER_M)
        refined = _least_squares(thinned_cam[near], weights[near])
        if refined is None:
            break
        plane = refined
    return plane


def _ahead(points_cam: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y, z = points_cam.T
    keep = (z > _AHEAD_M[0]) & (z < _AHEAD_M[1]) & (np.abs(x) < _ASIDE_M)
    keep &= (y > _BELOW_CAMERA_M[0]) & (y < _BELOW_CAMERA_M[1])
    ahead: NDArray[np.float64] = points_cam[keep]
    return ahead


def _thin_out(points_cam: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the lowest point of each cell of 0.25 m, so that dense rings near the car do not outvote the road."""
    cells = np.floor(points_cam[:, [0, 2]] / 0.25).astype(np.int64)
    order = np.lexsort((-points_cam[:, 1], cells[:, 1], cells[:, 0]))
    ordered = cells[order]
    is_first = np.ones(len(order), bool)
    is_first[1:] = (ordered[1:] != ordered[:-1]).any(1)
    thinned = points_cam[order[is_first]]
    # What is near decides: a label's height comes from there, and far ground may be another street's.
    weights: NDArray[np.float64] = 1.0 / (1.0 + np.maximum(thinned[:, 2] - 10.0, 0.0) / 5.0)
    return thinned, weights


def _through(corners_cam: NDArray[np.float64]) -> NDArray[np.float64] | None:
    normal = np.cross(corners_cam[1] - corners_cam[0], corners_cam[2] - corners_cam[0])
    length = float(np.sqrt(normal @ normal))
    if length < 1e-3:
        return None
    return _upward(normal / length, corners_cam[0])


def _least_squares(points_cam: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64] | None:
    mean = weights @ points_cam / weights.sum()
    offsets = points_cam - mean
    _, vectors = np.linalg.eigh((offsets * weights[:, None]).T @ offsets)
    return _upward(vectors[:, 0], mean)


def _upward(normal: NDArray[np.float64], point: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the plane with its normal up, or None where it is too steep."""
    if abs(normal[1]) < np.cos(_MAX_TILT_RAD):
        return None
    if normal[1] > 0.0:
        normal = -normal
    return np.append(normal, -(normal @ point))
