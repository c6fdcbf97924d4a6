"""Points that are left out, and noise of their ranges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avod.data.augmentation import Augmentation


def drop_points(points_cam: NDArray[np.float64], augmentation: Augmentation) -> NDArray[np.float64]:
    """Leave a share of points (N, 3) out, drawn for each sample up to `point_dropout`; the rest keep their order."""
    most = augmentation.settings.point_dropout
    if not most:
        return points_cam
    rng = augmentation.stream("dropout")
    share = rng.uniform(0.0, most)
    return points_cam[rng.random(len(points_cam)) >= share]


def shift_ranges(
    points_cam: NDArray[np.float64], lidar_cam: NDArray[np.float64], augmentation: Augmentation
) -> NDArray[np.float64]:
    """Move points along their beams by normal noise of deviation `range_noise_m`; none passes the LIDAR.

    Args:
        points_cam: (N, 3).
        lidar_cam: (3,), where the beams come from, cam frame.
        augmentation: says how much.
    """
    deviation_m = augmentation.settings.range_noise_m
    if not deviation_m:
        return points_cam
    beams = points_cam - lidar_cam
    range_m = np.linalg.norm(beams, axis=1)
    noise_m = augmentation.stream("ranges").normal(0.0, deviation_m, len(points_cam))
    stretch = np.divide(np.maximum(range_m + noise_m, 0.0), range_m, out=np.ones_like(range_m), where=range_m > 0.0)
    moved: NDArray[np.float64] = lidar_cam + beams * stretch[:, None]
    return moved
