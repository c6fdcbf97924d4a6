"""Bird's-eye-view maps, slowly and clearly: the definition that faster ones are compared with.

Points outside the extent, which is open on all sides, take no part, nor do those outside -5 < y < 3. Heights are over
the ground plane. Cells are floor(x / cell), floor(z / cell); row 0 is the farthest, column 0 the leftmost. A slice
holds lo <= height < hi. Empty cells are 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cadet.bev import BevConfig

EXTENT_Y_M = (-5.0, 3.0)


def maps(
    points_cam: NDArray[np.float64],
    plane: NDArray[np.float64],
    config: BevConfig,
    out: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]:
    """Make the maps: (C, H, W) float32, the slices' from the lowest up, features in turn, then the cloud's."""
    result = np.zeros(config.shape, np.float32) if out is None else out
    result[:] = 0.0
    x, y, z = points_cam[:, 0], points_cam[:, 1], points_cam[:, 2]
    height = points_cam[:, :3] @ plane[:3] + plane[3]
    inside = (x > config.x_m[0]) & (x < config.x_m[1]) & (z > config.z_m[0]) & (z < config.z_m[1])
    inside &= (y > EXTENT_Y_M[0]) & (y < EXTENT_Y_M[1])
    thickness = (config.height_hi_m - config.height_lo_m) / config.num_slices
    bounds = [(config.height_lo_m + k * thickness, thickness) for k in range(config.num_slices)]
    bounds.append((config.height_lo_m, config.height_hi_m - config.height_lo_m))
    features = [*[config.slice_maps] * config.num_slices, config.cloud_maps]
    channel = 0
    for (low, span), names in zip(bounds, features, strict=True):
        members = inside & (height >= low) & (height < low + span)
        cells = _cells(points_cam[members], height[members], config)
        for name in names:
            for (row, column), (points, heights) in cells.items():
                result[channel, row, column] = _value(name, points, heights, low, span, config)
            channel += 1
    return result


def _cells(
    points_cam: NDArray[np.float64], height: NDArray[np.float64], config: BevConfig
) -> dict[tuple[int, int], tuple[NDArray[np.float64], NDArray[np.float64]]]:
    columns = np.floor(points_cam[:, 0] / config.cell_m).astype(int) - round(config.x_m[0] / config.cell_m)
    rows = config.shape[1] - 1 - np.floor(points_cam[:, 2] / config.cell_m).astype(int)
    rows += round(config.z_m[0] / config.cell_m)
    key = rows * config.shape[2] + columns
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[order], prepend=-1))
    groups = np.split(order, starts[1:]) if len(order) else []
    return {(int(rows[g[0]]), int(columns[g[0]])): (points_cam[g], height[g]) for g in groups}


def _value(
    name: str, points_cam: NDArray[np.float64], height: NDArray[np.float64], low: float, span: float, config: BevConfig
) -> float:
    if name == "density":
        return float(min(1.0, np.log(len(height) + 1.0) / np.log(16.0)))
    if config.height == "reference":
        # The first point, in scan order, of the topmost (or, for least heights, lowest) bin of 0.1 m in y.
        bins = np.floor(points_cam[:, 1] / config.cell_m)
        chosen = height[np.argmin(bins) if name == "max_height" else np.argmax(bins)]
    else:
        chosen = height.max() if name == "max_height" else height.min()
    return float((chosen - low) / span)
