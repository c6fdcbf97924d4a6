"""What scans tell of the road ahead: noise along rings, how alike neighboring intensities are, how plane it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SENSOR_HEIGHT_M = 1.73
MAX_STEP_DEG = 0.25
SAME_STEP_DEG = 0.03


@dataclass(frozen=True)
class RoadStatistics:
    """Of the road 4 to 20 m ahead in KITTI's frame of the LIDAR, 3 m to either side."""

    range_noise_m: float
    """Median absolute second difference of ranges along rings at equal steps, as a standard deviation of one range."""
    intensity_correlation: float
    """Of neighbors on a ring, less the mean of the ring there."""
    plane_residual_m: float
    """Root mean square height over the plane fitted to the lane, 1.2 m to either side: no curb is so near."""
    num_points: int


def road_statistics(points_velo: NDArray[np.float32]) -> RoadStatistics:
    """Measure a ring-major scan."""
    points = points_velo.astype(np.float64)
    x, y, z, intensity = points.T
    is_near = (x > 4.0) & (x < 20.0) & (np.abs(y) < 3.0) & (np.abs(z + SENSOR_HEIGHT_M) < 0.5)
    is_lane = is_near & (np.abs(y) < 1.2)
    a, b, c = _plane(points[is_lane])
    residual_m = z - (a * x + b * y + c)
    is_plane = is_near & (np.abs(residual_m) < 0.08)
    is_lane &= is_plane
    range_m = np.linalg.norm(points[:, :3], axis=1)
    is_road = is_plane & (range_m > 5.0) & (range_m < 20.0)
    azimuth_deg = np.degrees(np.arctan2(y, x)) % 360.0
    seconds, pairs = [], []
    for ring in np.split(np.arange(len(points)), np.flatnonzero(np.diff(azimuth_deg) < -180.0) + 1):
        step = np.diff(azimuth_deg[ring])
        on = is_road[ring]
        is_even = (np.abs(step[1:] - step[:-1]) < SAME_STEP_DEG) & (step[1:] < MAX_STEP_DEG)
        is_even &= on[2:] & on[1:-1] & on[:-2]
        seconds.append(np.diff(range_m[ring], 2)[is_even])
        beside = on[1:] & on[:-1] & (step < MAX_STEP_DEG)
        if beside.sum() > 30:
            left, right = intensity[ring][:-1][beside], intensity[ring][1:][beside]
            pairs.append(np.stack([left - left.mean(), right - right.mean()]))
    left, right = np.concatenate(pairs, axis=1)
    return RoadStatistics(
        # A second difference has six variances of one range; half of a normal variable lies within 0.6745 of its own.
        range_noise_m=float(np.median(np.abs(np.concatenate(seconds)))) / 0.6745 / 6.0**0.5,
        intensity_correlation=float((left * right).mean() / np.sqrt((left**2).mean() * (right**2).mean())),
        plane_residual_m=float(np.sqrt((residual_m[is_lane] ** 2).mean())),
        num_points=int(is_lane.sum()),
    )


def _plane(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fit z = a x + b y + c to most of the points: curbs and bumpers are left out step by step."""
    kept = points
    for tolerance_m in (0.3, 0.15, 0.1, 0.08, 0.08):
        matrix = np.c_[kept[:, :2], np.ones(len(kept))]
        found = np.linalg.lstsq(matrix, kept[:, 2], rcond=None)[0]
        kept = points[np.abs(points[:, 2] - points[:, :2] @ found[:2] - found[2]) < tolerance_m]
    return np.asarray(found, dtype=np.float64)
