"""`cadet fit-lidar`: each laser's own range error, from the planes that lasers see together."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet import BeamTable, Laser, Lidar, Scene, UniformFiring
from cadet.datasets.lidar_fit import LidarFit, fit_lidar
from scans.lidar_scans import ring_of, write_scan, yard_scan

TABLE = BeamTable(
    name="custom",
    rings=tuple(Laser(elevation_deg=8.0 - 0.6 * k, height_m=0.1 + 0.002 * k) for k in range(48)),
    firing=UniformFiring(columns=1500),
)


def with_offsets(table: BeamTable, seed: int) -> BeamTable:
    """Give each laser a range error of 25 mm, their mean 0."""
    offsets_m = np.random.default_rng(seed).normal(0.0, 0.025, len(table.rings))
    offsets_m -= offsets_m.mean()
    pairs = zip(table.rings, offsets_m, strict=True)
    return replace(table, rings=tuple(replace(laser, range_offset_m=float(offset)) for laser, offset in pairs))


def range_errors_m(fit: LidarFit, table: BeamTable) -> NDArray[np.float64]:
    """Return by how much the fitted range errors differ from the true ones."""
    pairs = zip(fit.rings, table.rings, strict=True)
    return np.array([ring.laser.range_offset_m - laser.range_offset_m for ring, laser in pairs])


def test_each_lasers_range_error_comes_back(tmp_path: Path) -> None:
    table = with_offsets(TABLE, 4)
    for seed in range(3):
        write_scan(tmp_path / f"{seed}.bin", yard_scan(table, seed))
    fit = fit_lidar([tmp_path])
    assert np.sqrt((range_errors_m(fit, table) ** 2).mean()) < 0.002
    assert np.abs(range_errors_m(fit, table)).max() < 0.005
    assert fit.num_offsets_unknown == 0
    assert f"their mean taken for 0, are those of {fit.num_flat_patches} flat patches." in fit.to_toml()
    # The lines that tell elevations and heights are not moved by what moves points along them.
    for ring, laser in zip(fit.rings, table.rings, strict=True):
        assert ring.laser.elevation_deg == pytest.approx(laser.elevation_deg, abs=0.005)
        assert ring.laser.height_m == pytest.approx(laser.height_m, abs=0.0005)


def test_without_walls_range_errors_are_unknown_and_0(tmp_path: Path) -> None:
    """Bushes: points at any range."""
    points = yard_scan(TABLE, 0).astype(np.float64)
    heights_m = points[:, 2] - np.array([laser.height_m for laser in TABLE.rings])[ring_of(points)]
    scale = np.random.default_rng(0).uniform(0.3, 1.0, len(points))
    points[:, :2] *= scale[:, None]
    points[:, 2] += (scale - 1.0) * heights_m
    write_scan(tmp_path / "bushes.bin", points.astype(np.float32))
    fit = fit_lidar([tmp_path])
    assert all(ring.laser.range_offset_m == 0.0 for ring in fit.rings)
    assert any("range errors are unknown, and 0 here: 0 flat patches" in line for line in fit.remarks())


def test_streets_tell_kittis_range_errors_but_for_their_trend(tmp_path: Path) -> None:
    """A trend from the top ring to the bottom one shows in nothing but how upright walls stand."""
    lidar = Lidar.hdl64e_kitti()
    for seed in range(4):
        scene = Scene.random(seed=seed, weather="clear_noon")
        write_scan(tmp_path / f"{seed}.bin", scene.scan(lidar).points_velo)
    errors_m = range_errors_m(fit_lidar([tmp_path]), lidar.beam_table())
    assert np.diff(errors_m).std() < 0.003
    assert errors_m.std() < 0.02
