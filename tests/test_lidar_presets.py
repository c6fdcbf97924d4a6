"""LIDARs that are data: each file is a preset by its name alone, with the numbers of its data sheet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet.lidar import LIDAR_PRESETS

FOLDER = Path(cadet.__file__).parent / "presets" / "lidars"

# Name: rings, top and bottom elevation in degrees, points a second at ten turns, maximal range.
DATA_SHEETS = {"vls128": (128, 15.0, -25.0, 2_400_000, 245.0)}


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_a_file_is_a_preset(path: Path) -> None:
    assert path.stem in LIDAR_PRESETS and path.stem in DATA_SHEETS
    lidar = cadet.Lidar(path.stem)
    assert lidar == cadet.Lidar.named(path.stem) and lidar.table == cadet.BeamTable.read(path)


@pytest.mark.parametrize("name", DATA_SHEETS)
def test_numbers_are_the_data_sheets(name: str) -> None:
    rings, top, bottom, points_per_s, farthest_m = DATA_SHEETS[name]
    table = cadet.Lidar(name).beam_table()
    elevations = [laser.elevation_deg for laser in table.rings]
    assert (len(table.rings), elevations[0], elevations[-1]) == (rings, top, bottom)
    assert rings * table.num_columns * 10 == pytest.approx(points_per_s, rel=2e-3)
    assert table.max_range_m == farthest_m


def test_the_vls128_is_densest_about_the_horizon(core: object) -> None:
    elevations = np.array([laser.elevation_deg for laser in cadet.Lidar("vls128").beam_table().rings])
    steps = -np.diff(elevations)
    middle = (elevations[:-1] > -6.0) & (elevations[1:] < 4.5)
    # The manual: 0.11 degrees between lasers in the middle, degrees at the rim.
    assert np.abs(steps[middle & (elevations[:-1] < 4.0)] - 0.11).max() < 0.002 and steps.max() > 4.0
    scan = cadet.Scene.random(seed=3, weather="clear_noon").scan(cadet.Lidar("vls128"))
    assert len(np.unique(scan.ring)) > 100 and len(scan.points_velo) > 80_000
