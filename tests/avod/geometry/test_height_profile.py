"""How high points reach in a box, against the points themselves."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from avod.config import Config, SecondStageConfig
from avod.geometry.height_profile import cell_tops, height_profiles
from cadet import bev
from cadet.bev import BevConfig
from cadet.errors import CadetError

PLANE = np.array([0.0, -1.0, 0.0, 1.65])
CONFIGS = [
    BevConfig(cell_m=0.2, x_m=(-20.0, 20.0), z_m=(0.0, 40.0)),
    dataclasses.replace(BevConfig.max3_density3(), cell_m=0.2, x_m=(-20.0, 20.0), z_m=(0.0, 40.0)),
    dataclasses.replace(BevConfig.max_min_density(), cell_m=0.2, x_m=(-20.0, 20.0), z_m=(0.0, 40.0)),
]


def points_over_ground(seed: int) -> NDArray[np.float64]:
    """Points in the cam frame over the plane y = 1.65, in the maps' range of heights."""
    rng = np.random.default_rng(seed)
    x, z, height = rng.uniform(-20, 20, 4000), rng.uniform(0, 40, 4000), rng.uniform(-0.1, 2.2, 4000)
    return np.stack([x, 1.65 - height, z], axis=1)


@pytest.mark.parametrize("cell_m", [0.2, 0.1, 0.05])
@pytest.mark.parametrize("config", CONFIGS)
def test_profiles_are_the_greatest_heights_of_the_points_in_each_part(config: BevConfig, cell_m: float) -> None:
    config = dataclasses.replace(config, cell_m=cell_m)
    points = points_over_ground(0)
    tops_m = cell_tops(torch.from_numpy(bev.maps(points, PLANE, config)), config)
    # Corners and parts on the borders of cells, so that a point in a part is a cell in it.
    boxes = torch.tensor([[2.0, 1.65, 20.0, 4.8, 1.5, 1.6], [-11.2, 1.65, 8.8, 1.6, 1.5, 4.8]])
    found = height_profiles(tops_m, boxes, config, 4).numpy()
    for (x, _, z, dx, _, dz), profile in zip(boxes.numpy(), found, strict=True):
        across = np.floor((points[:, 0] - (x - dx / 2)) / dx * 4)
        ahead = np.floor(((z + dz / 2) - points[:, 2]) / dz * 4)
        for i in range(4):
            for j in range(4):
                inside = points[(ahead == i) & (across == j)]
                expected = max(0.0, float((1.65 - inside[:, 1]).max(initial=0.0)))
                assert profile[4 * i + j] == pytest.approx(expected, abs=1e-5)
        assert profile[16] == profile[:16].max()


@pytest.mark.parametrize("num_cells", [1, 3, 4])
def test_profiles_are_those_of_every_cell_that_a_part_covers(num_cells: int) -> None:
    config = BevConfig(cell_m=0.1, x_m=(-6.0, 6.0), z_m=(0.0, 9.0))
    rng = np.random.default_rng(2)
    # Few cells hold something, and a part's greatest height lies in one of them; boxes reach over all borders.
    tops_m = np.where(rng.random(config.shape[1:]) < 0.02, rng.uniform(-0.2, 2.0, config.shape[1:]), 0.0)
    boxes = rng.uniform((-7, 1.6, -1, 0.2, 1, 0.2), (7, 1.7, 10, 7, 2, 7), (200, 6))
    found = height_profiles(torch.from_numpy(tops_m), torch.from_numpy(boxes), config, num_cells).numpy()
    around = np.pad(tops_m, 100)

    def covered(edge_m: float, side_m: float, part: int) -> slice:
        # Half a cell, or a sixteenth of a short part, is left out at each end.
        length = side_m / num_cells / 0.1
        start, margin = edge_m / 0.1 + part * length, min(0.5, length / 16)
        return slice(int(np.floor(start + margin)) + 100, int(np.floor(start + length - margin)) + 101)

    for (x, _, z, dx, _, dz), profile in zip(boxes, found, strict=True):
        for i, j in np.ndindex(num_cells, num_cells):
            rows, columns = covered(9.0 - (z + dz / 2), dz, i), covered(x - dx / 2 + 6.0, dx, j)
            assert profile[num_cells * i + j] == around[rows, columns].max(), (i, j)
        assert profile[-1] == profile[:-1].max()
    odd = torch.tensor([[np.nan] * 6, [np.inf, 1.6, 4, 2, 1, 2], [0, 1.6, 4, np.nan, 1, np.inf]])
    assert height_profiles(torch.from_numpy(tops_m), odd, config, num_cells).isfinite().all()
    none = height_profiles(torch.from_numpy(tops_m), torch.zeros((0, 6)), config, num_cells)
    assert none.shape == (0, num_cells**2 + 1)


def test_what_is_off_the_maps_or_empty_is_ground() -> None:
    config = CONFIGS[0]
    tops_m = cell_tops(torch.zeros(config.shape), config)
    assert not tops_m.any()
    boxes = torch.tensor([[2.0, 1.65, 20.0, 4.8, 1.5, 1.6], [400.0, 1.65, -90.0, 4.8, 1.5, 1.6]])
    assert not height_profiles(torch.full_like(tops_m, 1.5), boxes, config, 2)[1].any()
    assert (height_profiles(torch.full_like(tops_m, 1.5), boxes, config, 2)[0] == 1.5).all()


def test_maps_without_heights_are_refused() -> None:
    flat = dataclasses.replace(BevConfig(), slice_maps=("density",))
    second = SecondStageConfig(height_cells=4)
    with pytest.raises(
        CadetError, match=r"^Config\.second_stage\.height_cells: expected 0 where no map holds max_height$"
    ):
        Config(bev=flat, second_stage=second)
    assert Config(bev=flat).second_stage.height_cells == 0


def test_standing_heights_need_measured_ones() -> None:
    with pytest.raises(
        CadetError, match=r"^SecondStageConfig\.standing_heights_m: expected \(0, 0\) without height_cells$"
    ):
        SecondStageConfig(standing_heights_m=(1.0, 2.0))
    with pytest.raises(CadetError, match=r"^SecondStageConfig\.standing_heights_m: expected \(low, high\), got \(2"):
        SecondStageConfig(height_cells=2, standing_heights_m=(2.0, 1.0))
