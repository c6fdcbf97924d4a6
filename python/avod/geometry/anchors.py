"""The grid of anchors, and the filter that drops those over empty ground."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from avod.config import AnchorConfig, ObjectClass, Size
from cadet.bev import BevConfig

_X, _Y, _Z, _DX, _DZ = 0, 1, 2, 3, 5
_ROTATIONS: Final = 2


@lru_cache(maxsize=16)
def _flat_grid(
    sizes: tuple[Size, ...], stride_m: float, x_m: tuple[float, float], z_m: tuple[float, float]
) -> NDArray[np.float64]:
    x = np.arange(x_m[0] + stride_m / 2.0, x_m[1], stride_m)
    z = np.arange(z_m[1] - stride_m / 2.0, z_m[0], -stride_m)
    lengths, widths, heights = np.array(sizes, np.float64).T
    grid = np.zeros((len(z), len(x), len(sizes), _ROTATIONS, 6))
    grid[..., _X] = x[None, :, None, None]
    grid[..., _Z] = z[:, None, None, None]
    grid[..., 3] = np.stack([lengths, widths], axis=1)
    grid[..., 4] = heights[:, None]
    grid[..., 5] = np.stack([widths, lengths], axis=1)
    return grid.reshape(-1, 6)


def occupancy(
    points_cam: NDArray[Any], plane: NDArray[np.float64], config: AnchorConfig, bev: BevConfig
) -> NDArray[np.bool_]:
    """Tell which cells of the ground hold a point between the two heights of the configuration.

    Args:
        points_cam: (N, 3) or wider, meters; those that the image sees. May be empty.
        plane: (4,) [a, b, c, d].
        config: the heights.
        bev: extent and size of the cells.

    Returns:
        (cells in x, cells in z) bool, x and z rising.
    """
    xyz = points_cam[:, :3]
    height = xyz @ plane[:3] + plane[3]
    x, y, z = xyz[:, 0], xyz[:, 1], xyz[:, 2]
    is_in = (height >= config.min_height_m) & (height < config.max_height_m)
    is_in &= (y > bev.y_m[0]) & (y < bev.y_m[1])
    is_in &= (x > bev.x_m[0]) & (x < bev.x_m[1]) & (z > bev.z_m[0]) & (z < bev.z_m[1])
    _, num_z, num_x = bev.shape
    cells = np.zeros((num_x, num_z), np.bool_)
    columns = np.floor(x[is_in] / bev.cell_m).astype(np.intp) - round(bev.x_m[0] / bev.cell_m)
    rows = np.floor(z[is_in] / bev.cell_m).astype(np.intp) - round(bev.z_m[0] / bev.cell_m)
    cells[np.clip(columns, 0, num_x - 1), np.clip(rows, 0, num_z - 1)] = True
    return cells


def anchors_over(
    cells: NDArray[np.bool_],
    plane: NDArray[np.float64],
    classes: Sequence[ObjectClass],
    config: AnchorConfig,
    bev: BevConfig,
) -> NDArray[np.float64]:
    """Make those anchors of the grid that stand over enough occupied cells.

    A summed-area table gives a count in four look-ups. An anchor covers the cells from that of its lower corner up to,
    but without, that of its upper corner; corners are float32 and truncate toward zero, as in AVOD, so the keep
    masks agree to the last anchor. Where they lie does not depend on the plane, so it is computed once.

    Args:
        cells: (cells in x, cells in z) bool, from `occupancy`.
        plane: (4,) [a, b, c, d], cam frame, unit normal, b < 0.
        classes: whose sizes the anchors take.
        config: the stride, and how many cells are enough.
        bev: extent and size of the cells.

    Returns:
        (N, 6) anchors. A class's come together; within, z falls, then x rises, then the sizes in turn, each along x and
        along z.
    """
    sizes = tuple(item.anchor_sizes_lwh_m for item in classes)
    flat = np.asarray(cv2.integral(cells.view(np.uint8)), np.int32).ravel()
    far, low_x, low_z, near = _corners(sizes, config.stride_m, bev.x_m, bev.z_m, bev.cell_m, cells.shape)
    counts = flat[far] - flat[low_x] - flat[low_z] + flat[near]
    return _on_plane(_flat_grids(sizes, config.stride_m, bev.x_m, bev.z_m)[counts >= config.min_occupied_cells], plane)


@lru_cache(maxsize=16)
def _flat_grids(
    sizes: tuple[tuple[Size, ...], ...], stride_m: float, x_m: tuple[float, float], z_m: tuple[float, float]
) -> NDArray[np.float64]:
    grids = np.concatenate([_flat_grid(item, stride_m, x_m, z_m) for item in sizes])
    grids.setflags(write=False)
    return grids


@lru_cache(maxsize=16)
def _corners(
    sizes: tuple[tuple[Size, ...], ...],
    stride_m: float,
    x_m: tuple[float, float],
    z_m: tuple[float, float],
    cell_m: float,
    shape: tuple[int, int],
) -> tuple[NDArray[np.intp], ...]:
    """Return the places of the anchors' corners in a flat summed-area table."""
    anchors = _flat_grids(sizes, stride_m, x_m, z_m)
    half_x, half_z = anchors[:, _DX] / 2.0, anchors[:, _DZ] / 2.0
    x1, x2 = (_cell(anchors[:, _X] + half, x_m[0], cell_m, shape[0]) for half in (-half_x, half_x))
    z1, z2 = (_cell(anchors[:, _Z] + half, z_m[0], cell_m, shape[1]) for half in (-half_z, half_z))
    width = shape[1] + 1
    return x2 * width + z2, x1 * width + z2, x2 * width + z1, x1 * width + z1


def _on_plane(anchors: NDArray[np.float64], plane: NDArray[np.float64]) -> NDArray[np.float64]:
    a, b, c, d = plane
    placed = anchors.copy()
    placed[:, _Y] = -(a * placed[:, _X] + c * placed[:, _Z] + d) / b
    return placed


def _cell(corner_m: NDArray[np.float64], start_m: float, cell_m: float, num_cells: int) -> NDArray[np.intp]:
    steps = corner_m.astype(np.float32) / np.float32(cell_m)
    first = round(start_m / cell_m)
    cells: NDArray[np.intp] = np.clip(np.trunc(steps).astype(np.intp) - first, 0, num_cells)
    return cells
