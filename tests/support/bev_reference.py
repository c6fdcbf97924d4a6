"""AVOD's bird's-eye-view maps written out slowly, cell by cell: what the core's one pass is compared with."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet.bev import BevConfig


def maps(points_cam: NDArray[Any], plane: NDArray[Any], config: BevConfig) -> NDArray[np.float64]:
    """Return (C, H, W): every point is filed under its cell, then every cell is looked at."""
    a, b, c, d = (float(v) for v in plane)
    norm = math.sqrt(a * a + b * b + c * c) * (-1.0 if b > 0 else 1.0)
    a, b, c, d = a / norm, b / norm, c / norm, d / norm
    channels, rows, columns = config.shape
    out = np.zeros((channels, rows, columns))
    thickness = (config.height_hi_m - config.height_lo_m) / config.num_slices
    # Lower end, thickness, first channel and features of each group of maps.
    groups = [
        (config.height_lo_m + k * thickness, thickness, k * len(config.slice_maps), config.slice_maps)
        for k in range(config.num_slices)
    ]
    whole = config.height_hi_m - config.height_lo_m
    groups.append((config.height_lo_m, whole, config.num_slices * len(config.slice_maps), config.cloud_maps))
    for low, height, first, features in groups:
        cells: dict[tuple[int, int], list[tuple[int, float]]] = defaultdict(list)
        for x, y, z in points_cam[:, :3].astype(np.float64):
            ranges = ((x, config.x_m), (y, config.y_m), (z, config.z_m))
            if not all(lo < v < hi for v, (lo, hi) in ranges):
                continue
            over = a * x + b * y + c * z + d
            if low <= over < low + height:
                ix = math.floor(x / config.cell_m) - round(config.x_m[0] / config.cell_m)
                iz = math.floor(z / config.cell_m) - round(config.z_m[0] / config.cell_m)
                cells[rows - 1 - iz, ix].append((math.floor(y / config.cell_m), (over - low) / height))
        for (row, column), inside in cells.items():
            heights = [h for _, h in inside]
            topmost = min(y for y, _ in inside)
            value = {
                "max_height": max(heights) if config.height == "max" else next(h for y, h in inside if y == topmost),
                "min_height": min(heights),
                "density": min(1.0, math.log(len(inside) + 1) / math.log(16)),
                "density_log64": min(1.0, math.log(len(inside) + 1) / math.log(64)),
            }
            for i, feature in enumerate(features):
                out[first + i, row, column] = value[feature]
    return out
