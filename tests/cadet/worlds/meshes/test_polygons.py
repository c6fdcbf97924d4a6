"""Polygons become triangles that cover them, once: areas add up, and no triangle is turned around."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet.worlds.meshes.polygons import triangles_of


def area(points: NDArray[np.float64]) -> float:
    x, y = points.T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2.0)


def star(count: int, dent: float) -> NDArray[np.float64]:
    angles = np.arange(count) * 2.0 * np.pi / count
    return np.column_stack([np.cos(angles), np.sin(angles)]) * np.where(np.arange(count) % 2, dent, 1.0)[:, None]


L_SHAPE = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], float)
ARROW = np.array([[0, 0], [2, -1], [0.5, 0], [2, 1]], float)
COMB = np.array(
    [(0, -1), (20, -1)] + [p for k in range(9, -1, -1) for p in ((2 * k + 1.5, 3), (2 * k + 0.5, 0))], float
)
TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


@pytest.mark.parametrize("first", range(4))
@pytest.mark.parametrize("flat", [L_SHAPE, ARROW, star(10, 0.4), star(7, 1.0), star(200, 0.9), COMB])
def test_triangles_cover_a_polygon_once(flat: NDArray[np.float64], first: int) -> None:
    flat = np.roll(flat, first, axis=0)
    points = np.column_stack([flat, np.zeros(len(flat))]) @ TURN + 5.0
    cut, owners = triangles_of(points, np.arange(len(flat)), np.array([len(flat)]))
    assert cut.shape == (len(flat) - 2, 3)
    assert not owners.any()
    areas = [area(flat[triangle]) for triangle in cut]
    assert min(np.array(areas) * np.sign(area(flat))) > -1e-9, "no triangle is turned around"
    assert sum(areas) == pytest.approx(area(flat))


def test_polygons_of_all_sizes_keep_their_order() -> None:
    points = np.column_stack([np.vstack([L_SHAPE, star(3, 1.0), ARROW, L_SHAPE[:2]]), np.zeros(15)])
    cut, owners = triangles_of(points, np.arange(15), np.array([6, 3, 4, 2]))
    assert owners.tolist() == [0] * 4 + [1] + [2] * 2
    assert cut[4].tolist() == [6, 7, 8]
    assert set(cut[5:].ravel()) == {9, 10, 11, 12}


def test_a_polygon_that_crosses_itself_ends() -> None:
    crossed = np.random.default_rng(3).normal(size=(60, 3))
    cut, _ = triangles_of(crossed, np.arange(60), np.array([60]))
    assert len(cut) == 58
    flat, _ = triangles_of(np.zeros((5, 3)), np.arange(5), np.array([5]))
    assert len(flat) == 3
