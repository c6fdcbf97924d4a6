"""LIDARs that do not spin: rasters, rosettes and tables of directions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet.formats.kitti.files.range_image import range_image
from cadet.generate import Settings, generate

RASTER = cadet.RasterFiring(lines=8, columns=30, azimuth_span_deg=(20.0, -20.0), elevation_span_deg=(-2.0, -9.0))
ROSETTE = cadet.RosetteFiring(firings=400, deflections_deg=(6.0, 4.0), prism_rates_hz=(121.0, -77.0))
TABLE = cadet.TableFiring(aims=((-0.02, 5.0, -4.0), (0.0, 0.0, -5.0), (0.0, -5.0, -6.0)))


def lidar(
    firing: cadet.RasterFiring | cadet.RosetteFiring | cadet.TableFiring, *, rolling: bool = False
) -> cadet.Lidar:
    rings = (cadet.Laser(elevation_deg=0.0), cadet.Laser(elevation_deg=-1.0, azimuth_offset_deg=2.0))
    table = cadet.BeamTable(name="mine", rings=rings, firing=firing, range_noise_m=0.0, detection_range_m=1000.0)
    return cadet.Lidar("mine", table=table, rolling=rolling)


@pytest.mark.parametrize("firing", [RASTER, ROSETTE, TABLE], ids=["raster", "rosette", "table"])
def test_points_lie_on_the_beams_and_on_the_ground(firing: cadet.RasterFiring) -> None:
    sensor = lidar(firing)
    scene = cadet.Scene.empty()
    origins, directions, ring, column = sensor.rays(time_s=scene.time_s)
    assert (ring.max(), column.max() + 1) == (1, sensor.beam_table().num_columns)
    for ideal in (True, False):
        scan = scene.scan(sensor, ideal=ideal)
        beam = scan.ring * sensor.beam_table().num_columns + scan.column
        hit = np.isfinite(scan.range_m)
        expected = origins[beam] + directions[beam] * scan.range_m[:, None]
        np.testing.assert_allclose(scan.points_velo[hit, :3], expected[hit], rtol=0.0, atol=1e-3)
        # The sensor stands 1.73 m over a plane.
        assert hit.sum() >= (directions[:, 2] < -0.06).sum() > 4
        assert np.ptp(scan.points_velo[scan.range_m < 15.0, 2]) < 0.3 and (scan.time_s == 0.0).all()


def test_a_raster_goes_line_by_line_through_its_period() -> None:
    sensor = lidar(RASTER, rolling=True)
    _, directions, ring, column = sensor.rays()
    first = ring == 0
    azimuth_deg = np.degrees(np.arctan2(directions[first, 1], directions[first, 0])).reshape(8, 30)
    elevation_deg = np.degrees(np.arcsin(directions[first, 2])).reshape(8, 30)
    np.testing.assert_allclose(azimuth_deg, np.tile(np.linspace(20, -20, 30), (8, 1)), atol=1e-9)
    np.testing.assert_allclose(elevation_deg, np.tile(np.linspace(-2, -9, 8)[:, None], (1, 30)), atol=1e-9)
    scan = cadet.Scene.empty().scan(sensor)
    np.testing.assert_allclose(scan.time_s, ((scan.column + 0.5) / 240 - 0.5) * 0.1, atol=1e-7)
    image = range_image(scan, sensor)
    assert image.shape == (16, 30)
    assert (np.diff(image[:8].mean(axis=1)) < 0).all(), "lower lines meet nearer ground"


def test_a_rosette_goes_on_and_the_same_moment_is_the_same_scan() -> None:
    def points(time_s: float) -> NDArray[np.float32]:
        scene = cadet.Scene.random(seed=3, weather="clear_noon")
        scene.step(time_s)
        return scene.scan(cadet.Lidar.livox_mid40()).points_velo

    at_once, later = points(0.0), points(0.1)
    np.testing.assert_array_equal(points(0.1), later)

    def azimuths_deg(p: NDArray[np.float32]) -> NDArray[np.float64]:
        return np.degrees(np.arctan2(p[:, 1], p[:, 0]), dtype=np.float64)

    # Of the first scan's columns hardly any is met again, in a cone that both fill.
    assert len(np.intersect1d(azimuths_deg(at_once).round(3), azimuths_deg(later).round(3))) < 0.3 * len(later)
    for p in (at_once, later):
        off_axis_deg = np.degrees(np.arccos(p[:, 0] / np.linalg.norm(p[:, :3], axis=1)))
        assert 18.5 < off_axis_deg.max() < 19.3


@pytest.mark.parametrize("name", ["livox_mid40", "rs_m1"])
def test_presets_write_sets_and_files(tmp_path: Path, name: str) -> None:
    sensor = cadet.Lidar(name, rolling=True)
    rig = replace(cadet.Rig(), lidar=sensor)
    _ = generate(
        tmp_path / "out", Settings(num_frames=2, seed=4, policy=cadet.ResetPolicy.kitti().with_rig(rig)), workers=1
    )
    assert cadet.kitti.lint(tmp_path / "out", strict=True) == []
    table = sensor.beam_table()
    assert table == sensor.table
    text = tmp_path / "mine.toml"
    text.write_text(replace(table, name="mine").to_toml())
    assert cadet.Lidar.read(text).table == replace(table, name="mine")


def test_a_table_is_read_from_its_file(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("time_s,azimuth_deg,elevation_deg\n-0.02,5,-4\n0,0,-5\n0,-5,-6\n")
    toml = tmp_path / "mine.toml"
    toml.write_text(
        'name = "mine"\nrings = [{ elevation_deg = 0.0 }]\n[firing]\npattern = "table"\nfile = "path.csv"\n'
    )
    assert cadet.BeamTable.read(toml).firing == TABLE
    for text, reason in (
        ("time_s,azimuth_deg\n", "path.csv:1: expected the first line to be time_s,azimuth_deg,elevation_deg"),
        ("time_s,azimuth_deg,elevation_deg\n0,1,2\n0,1\n", "path.csv:3: expected three numbers, got '0,1'"),
        (
            "time_s,azimuth_deg,elevation_deg\n0,1,2\n-0.1,1,2\n",
            "aims[1] time: expected a number from 0 to 10, got -0.1",
        ),
        ("time_s,azimuth_deg,elevation_deg\n", "number of aims"),
    ):
        (tmp_path / "path.csv").write_text(text)
        with pytest.raises(cadet.CadetError, match=r"path\.csv") as caught:
            cadet.BeamTable.read(toml)
        assert reason in str(caught.value)


def test_numbers_of_spinning_sensors_are_refused() -> None:
    table = lidar(RASTER).table
    assert table is not None
    for changes, reason in (
        ({"spin": "ccw"}, "lidar.spin: expected none for a LIDAR that does not spin"),
        ({"start_azimuth_deg": 90.0}, "lidar.start_azimuth_deg: expected none"),
        ({"halo_share": 1e-4}, "lidar.halo_share: expected none"),
        ({"rings": (cadet.Laser(elevation_deg=0.0, left_m=0.1),)}, r"rings\[0\].left_m: expected 0"),
        ({"rings": ()}, "expected 1 to"),
    ):
        with pytest.raises(cadet.CadetError, match=reason):
            replace(table, **changes)
    with pytest.raises(cadet.CadetError, match="divergence"):
        cadet.Lidar("mine", table=table, divergence_mrad=2.0)
    steep = replace(table, rings=(cadet.Laser(elevation_deg=-85.0),))
    with pytest.raises(cadet.CadetError, match="ring elevation"):
        cadet.Lidar("mine", table=steep)
    with pytest.raises(cadet.CadetError, match="deflections_deg"):
        replace(ROSETTE, deflections_deg=(50.0, 50.0))
    with pytest.raises(cadet.CadetError, match="lines x columns"):
        replace(RASTER, lines=2000, columns=2000)
    with pytest.raises(cadet.CadetError, match=r"aims\[0\]: expected time, azimuth and elevation"):
        cadet.TableFiring(aims=((0.0, 1.0),))  # type: ignore[arg-type]
