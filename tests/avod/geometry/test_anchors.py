"""Anchors against the numbers of the paper's code, and the filter against a count cell by cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from avod.config import AnchorConfig, Config, ObjectClass
from avod.data.build import build_sample, normal_plane
from avod.geometry.anchors import anchors_over, occupancy
from cadet.bev import BevConfig
from cadet.formats.kitti import read_frame
from real_kitti import ROOT, needs_kitti

PLANE = normal_plane(np.array([0.02, -0.999, 0.01, 1.65]))


def whole_grid(classes: tuple[ObjectClass, ...], config: AnchorConfig, bev: BevConfig) -> NDArray[np.float64]:
    cells = np.zeros(bev.shape[:0:-1], np.bool_)
    return anchors_over(cells, PLANE, classes, replace(config, min_occupied_cells=0), bev)


@pytest.mark.parametrize("name", ["car_default", "people_default"])
def test_the_grid_has_the_published_places(name: str) -> None:
    config = Config.named(name)
    grid = whole_grid(config.classes, config.anchors, config.bev)
    assert grid.shape == (89_600, 6)
    assert grid[:, 0].min() == -39.75 and grid[:, 0].max() == 39.75
    assert grid[:, 2].min() == 0.25 and grid[0, 2] == 69.75
    np.testing.assert_allclose(grid @ np.array([*PLANE[:3], 0, 0, 0]) + PLANE[3], 0.0, atol=1e-12)


def test_the_grids_order_is_z_then_x_then_size_then_rotation() -> None:
    config = Config.named("car_default")
    grid = whole_grid(config.classes, config.anchors, config.bev)
    first, second = config.classes[0].anchor_sizes_lwh_m
    assert grid[:4, 3:].tolist() == [
        [first[0], first[2], first[1]],
        [first[1], first[2], first[0]],
        [second[0], second[2], second[1]],
        [second[1], second[2], second[0]],
    ]
    assert grid[4, 0] == -39.25 and grid[4, 2] == 69.75
    assert grid[160 * 4, 0] == -39.75 and grid[160 * 4, 2] == 69.25
    people = Config.named("people_default")
    grid = whole_grid(people.classes, people.anchors, people.bev)
    assert set(grid[: 22_400 * 2, 4]) == {1.768} and set(grid[22_400 * 2 :, 4]) == {1.723}


def test_the_filter_counts_cells() -> None:
    rng = np.random.default_rng(0)
    bev = BevConfig(x_m=(-8.0, 8.0), z_m=(0.0, 12.0))
    config = AnchorConfig(stride_m=0.7, min_occupied_cells=2)
    classes = Config.named("all_default").classes
    anchors = whole_grid(classes, config, bev)
    points = np.column_stack([rng.uniform(-9, 9, 300), rng.uniform(-1, 2, 300), rng.uniform(-1, 13, 300)])
    cells = occupancy(points, PLANE, config, bev)
    heights = points @ PLANE[:3] + PLANE[3]
    expected_cells = {
        (int(np.floor(x / 0.1)) + 80, int(np.floor(z / 0.1)))
        for (x, _, z), height in zip(points, heights, strict=True)
        if 0.2 <= height < 2.0 and -8 < x < 8 and 0 < z < 12
    }
    assert {(int(x), int(z)) for x, z in np.argwhere(cells)} == expected_cells
    found = anchors_over(cells, PLANE, classes, config, bev)
    kept = []
    for x, _, z, dx, _, dz in anchors:
        x1, x2 = (min(max(int(np.float32(x + s * dx / 2) / np.float32(0.1)) + 80, 0), 160) for s in (-1, 1))
        z1, z2 = (min(max(int(np.float32(z + s * dz / 2) / np.float32(0.1)), 0), 120) for s in (-1, 1))
        kept.append(sum(x1 <= i < x2 and z1 <= j < z2 for i, j in expected_cells) >= 2)
    np.testing.assert_array_equal(found, anchors[kept])
    assert 0 < sum(kept) < len(kept)


def test_points_over_and_under_the_range_of_the_maps_do_not_count() -> None:
    points = np.array([[0.5, 1.2, 5.5], [1.5, 0.9, 5.5], [2.5, 0.2, 5.5]])
    found = {}
    for y_m in ((-5.0, 3.0), (0.5, 1.0)):
        bev = BevConfig(x_m=(-8.0, 8.0), y_m=y_m, z_m=(0.0, 12.0), cell_m=1.0)
        found[y_m] = [int(x) - 8 for x, _ in np.argwhere(occupancy(points, PLANE, AnchorConfig(), bev))]
    assert found == {(-5.0, 3.0): [0, 1, 2], (0.5, 1.0): [1]}


def test_no_points_leave_no_anchors() -> None:
    config = Config.named("car_default")
    cells = occupancy(np.zeros((0, 3)), PLANE, config.anchors, config.bev)
    assert not len(anchors_over(cells, PLANE, config.classes, config.anchors, config.bev))


@needs_kitti
@pytest.mark.parametrize(("name", "count"), [("car_default", 13_839), ("people_default", 5_428)])
def test_a_real_frame_keeps_as_many_anchors_as_in_the_original(name: str, count: int) -> None:
    frame = read_frame(ROOT, "000001")
    assert frame.plane is not None
    sample = build_sample(frame.points_velo, frame.image, frame.calib, frame.plane, Config.named(name))
    assert len(sample.anchors) == count
