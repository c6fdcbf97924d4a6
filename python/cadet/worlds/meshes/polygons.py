"""Triangles of polygons, those with dents included."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

MAX_CORNERS: Final = 1000
"""Of one polygon."""


def triangles_of(
    positions: NDArray[np.float64], corners: NDArray[np.int64], counts: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cut polygons into triangles.

    Args:
        positions: (n, 3) where corners may be.
        corners: (c,) each polygon's corners as indices into `positions`, one polygon after the other.
        counts: (p,) each polygon's number of corners; polygons of fewer than three give nothing.

    Returns:
        (t, 3) indices into `corners`, and (t,) each triangle's polygon.
    """
    first = np.cumsum(counts) - counts
    triangles, owners = [], []
    for count in np.unique(counts[counts >= 3]).tolist():
        polygons = np.flatnonzero(counts == count)
        places = first[polygons, None] + np.arange(count)
        points = positions[corners[places]]
        if count == 3:
            order = np.zeros((len(places), 1), np.int64) + np.arange(3)
            cut = order[:, None, :]
        else:
            cut = _cut(points)
        triangles.append(np.take_along_axis(places[:, None, :], cut, axis=2).reshape(-1, 3))
        owners.append(np.repeat(polygons, count - 2))
    if not triangles:
        return np.empty((0, 3), np.int64), np.empty(0, np.int64)
    whole, owner = np.concatenate(triangles), np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return whole[order], owner[order]


def _cut(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Cut polygons of one number of corners, (p, n, 3), into (p, n - 2, 3) of those."""
    count = points.shape[1]
    flat = _flattened(points)
    turns = _turn(np.roll(flat, 1, axis=1), flat, np.roll(flat, -1, axis=1))
    scale = np.abs(turns).max(axis=1, keepdims=True)
    is_reflex = turns < -1e-9 * scale
    fan = np.stack([np.zeros(count - 2, np.int64), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    # A fan from the dent of a polygon with none, or of four corners with one, covers it.
    start = np.where(is_reflex.any(axis=1), is_reflex.argmax(axis=1), 0)
    cut = (fan[None] + start[:, None, None]) % count
    if count > 4:
        for polygon in np.flatnonzero(is_reflex.any(axis=1)).tolist():
            cut[polygon] = _ears(flat[polygon])
    return np.asarray(cut)


def _flattened(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Project polygons, (p, n, 3), along their normals (Newell's) to (p, n, 2), counter-clockwise."""
    centered = points - points.mean(axis=1, keepdims=True)
    normal = np.cross(centered, np.roll(centered, -1, axis=1)).sum(axis=1)
    axis = np.abs(normal).argmax(axis=1)
    rows = np.arange(len(points))
    flat = np.stack([centered[rows, :, (axis + 1) % 3], centered[rows, :, (axis + 2) % 3]], axis=2)
    flat[normal[rows, axis] < 0, :, 0] *= -1.0
    return flat


def _turn(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return twice the signed area of triangles of points (..., 2): above 0 where they turn counter-clockwise."""
    u, v = b - a, c - a
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def _ears(flat: NDArray[np.float64]) -> list[tuple[int, int, int]]:
    """Cut ears off a polygon, (n, 2), also off one that crosses itself: G. H. Meisters, "Polygons have ears" (1975)."""
    left = list(range(len(flat)))
    ears = []
    at, tried = 0, 0
    while len(left) > 3:
        before, here, after = left[at - 1], left[at], left[(at + 1) % len(left)]
        if tried >= len(left) or _is_ear(flat, left, before, here, after):
            ears.append((before, here, after))
            del left[at]
            tried = 0
        else:
            tried += 1
            at += 1
        at %= len(left)
    return [*ears, (left[0], left[1], left[2])]


def _is_ear(flat: NDArray[np.float64], left: list[int], before: int, here: int, after: int) -> bool:
    a, b, c = flat[before], flat[here], flat[after]
    if _turn(a, b, c) <= 0.0:
        return False
    others = flat[left]
    inside = (_turn(a, b, others) >= 0.0) & (_turn(b, c, others) >= 0.0) & (_turn(c, a, others) >= 0.0)
    is_corner = (others == a).all(1) | (others == b).all(1) | (others == c).all(1)
    return not (inside & ~is_corner).any()
