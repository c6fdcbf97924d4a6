"""LIDARs that are data: each file is a preset by its name alone, with the numbers of its data sheet."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet.sensors.lidar import LIDAR_PRESETS

FOLDER = Path(cadet.__file__).parent / "sensors" / "presets" / "lidars"

# Name: rings, top and bottom elevation in degrees, points a second at ten turns, maximal range, range for 10 % of
# reflectance: where a sheet has one for 80 % alone, or names none, the maximal range over the root of 8.
DATA_SHEETS = {
    "hdl32e": (32, 10.67, -30.67, 694_400, 100.0, 35.4),
    "os1_128": (128, 22.5, -22.5, 2_621_440, 120.0, 40.0),
    "os1_64": (64, 22.5, -22.5, 655_360, 120.0, 40.0),
    "vlp16": (16, 15.0, -15.0, 289_352, 100.0, 35.4),
    "vls128": (128, 15.0, -25.0, 2_400_000, 245.0, 220.0),
}
# Of those that do not spin: lasers, points a second at ten scans, degrees to either side across and up, maximal range,
# range for 10 % of reflectance.
FIELDS = {
    "livox_mid40": (1, 100_000, 19.2, 19.2, 260.0, 90.0),
    "rs_m1": (5, 787_500, 60.0, 12.5, 200.0, 150.0),
}
# Of origins, directions, ring, and column of every beam, as the core's own code made them before they were files.
BEAMS = {
    "hdl32e": "299a53afdd1aeba3",
    "os1_128": "4545b73c82eba28f",
    "os1_64": "80776427b4c9ef1d",
    "vlp16": "bef1542993d97ac1",
}


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_a_file_is_a_preset(path: Path) -> None:
    assert path.stem in LIDAR_PRESETS and path.stem in {**DATA_SHEETS, **FIELDS}
    lidar = cadet.Lidar(path.stem)
    assert lidar == cadet.Lidar.named(path.stem) and lidar.table == cadet.BeamTable.read(path)


@pytest.mark.parametrize("name", DATA_SHEETS)
def test_numbers_are_the_data_sheets(name: str) -> None:
    rings, top, bottom, points_per_s, farthest_m, detection_m = DATA_SHEETS[name]
    table = cadet.Lidar(name).beam_table()
    elevations = [laser.elevation_deg for laser in table.rings]
    assert len(table.rings) == rings
    assert [elevations[0], elevations[-1]] == pytest.approx([top, bottom], abs=0.005)
    assert rings * table.num_columns * 10 == pytest.approx(points_per_s, rel=2e-3)
    assert (table.max_range_m, table.detection_range_m) == (farthest_m, detection_m)


@pytest.mark.parametrize("name", FIELDS)
def test_fields_of_view_are_the_data_sheets(name: str) -> None:
    lasers, points_per_s, azimuth_deg, elevation_deg, farthest_m, detection_m = FIELDS[name]
    lidar = cadet.Lidar(name)
    table = lidar.beam_table()
    _, directions, ring, _ = lidar.rays()
    assert (ring.max() + 1, len(ring) * 10) == (lasers, points_per_s)
    for seen_deg, most_deg in (
        (np.degrees(np.arctan2(directions[:, 1], directions[:, 0])), azimuth_deg),
        (np.degrees(np.arcsin(directions[:, 2])), elevation_deg),
    ):
        assert [seen_deg.min(), seen_deg.max()] == pytest.approx([-most_deg, most_deg], abs=0.2)
    assert (table.max_range_m, table.detection_range_m) == (farthest_m, detection_m)


@pytest.mark.parametrize("name", BEAMS)
def test_beams_are_the_same_bit_for_bit(name: str) -> None:
    found = hashlib.sha256()
    for array in cadet.Lidar(name).rays():
        found.update(np.ascontiguousarray(array).tobytes())
    assert found.hexdigest()[:16] == BEAMS[name]


def test_the_hdl32e_hops_between_its_banks() -> None:
    beams = cadet.Lidar("hdl32e").beam_table()
    column_deg = 360.0 / beams.num_columns
    # The manual's firing order: -30.67, -9.33, -29.33, -8.00, ... -10.67, 10.67, one each 1.152 us.
    for order, degrees in ((0, -30.67), (1, -9.33), (2, -29.33), (15, 0.0), (16, -20.0), (31, 10.67)):
        laser = next(laser for laser in beams.rings if abs(laser.elevation_deg - degrees) < 0.01)
        late_deg = order * 1.152e-6 * 10 * 360
        assert laser.azimuth_offset_deg % column_deg == pytest.approx(-late_deg % column_deg, abs=1e-6)


def test_the_vlp16s_lasers_seem_to_leave_one_circle() -> None:
    # The manual's table is what a circle of 41.9 mm gives, to its rounding.
    for laser in cadet.Lidar("vlp16").beam_table().rings:
        assert laser.height_m == pytest.approx(-0.0419 * math.tan(math.radians(laser.elevation_deg)), abs=1e-4)


def test_the_vls128_is_densest_about_the_horizon() -> None:
    elevations = np.array([laser.elevation_deg for laser in cadet.Lidar("vls128").beam_table().rings])
    steps = -np.diff(elevations)
    middle = (elevations[:-1] > -6.0) & (elevations[1:] < 4.5)
    # The manual: 0.11 degrees between lasers in the middle, degrees at the rim.
    assert np.abs(steps[middle & (elevations[:-1] < 4.0)] - 0.11).max() < 0.002 and steps.max() > 4.0
    scan = cadet.Scene.random(seed=3, weather="clear_noon").scan(cadet.Lidar("vls128"))
    assert len(np.unique(scan.ring)) > 100 and len(scan.points_velo) > 80_000
