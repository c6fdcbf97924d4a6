"""Other sensors than KITTI's: scans keep their tables' promises, and datasets are whole."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cadet import CadetError, Camera, EncoderFiring, Lidar, Rig, Scene, kitti
from cadet.formats.kitti.lint import lint
from cadet.sensors.firing import TURNING
from cadet.sensors.lidar import LIDAR_PRESETS

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene.random(seed=3, weather="clear_noon")


@pytest.mark.parametrize("name", LIDAR_PRESETS)
def test_points_lie_on_their_beams(scene: Scene, name: str) -> None:
    lidar = Lidar(name)
    table = lidar.beam_table()
    scan = scene.scan(lidar)
    origins, directions, _, _ = lidar.rays(time_s=scene.time_s)
    beam = scan.ring * table.num_columns + scan.column
    expected = origins[beam] + directions[beam] * scan.range_m[:, None]
    if isinstance(table.firing, EncoderFiring):
        # Points are reported at the tick nearest to where their beams went.
        tick = 2.0 * np.pi / table.firing.ticks_per_turn
        fired = np.arctan2(directions[beam, 1], directions[beam, 0]) / tick
        late = (np.rint(fired) - fired) * tick
        assert 0.8 < np.ptp(late) / tick <= 1.0
        expected[:, :2] = np.stack(
            [
                expected[:, 0] * np.cos(late) - expected[:, 1] * np.sin(late),
                expected[:, 0] * np.sin(late) + expected[:, 1] * np.cos(late),
            ],
            axis=1,
        )
    np.testing.assert_allclose(scan.points_velo[:, :3], expected, rtol=0.0, atol=0.00052)
    distance_m = np.linalg.norm(scan.points_velo[:, :3].astype(np.float64), axis=1)
    assert distance_m.min() >= table.min_range_m
    assert distance_m.max() < table.max_range_m
    # Ring-major, azimuth rising counter-clockwise from forward, each ring's last beam before the turn's end. What
    # lasers beside the axis see near by and far away overtakes: there the written azimuths rise.
    if all(laser.left_m == 0.0 for laser in table.rings):
        assert (np.diff(beam) > 0).all()
    else:
        assert len(np.unique(beam)) == len(beam)
        written = np.degrees(np.arctan2(scan.points_velo[:, 1].astype(float), scan.points_velo[:, 0])) % 360.0
        assert (np.diff(scan.ring * 360.0 + written) >= 0.0).all()
    if not isinstance(table.firing, TURNING):
        return
    azimuth = np.degrees(np.arctan2(directions[:, 1], directions[:, 0])) % 360.0
    assert (np.diff(azimuth.reshape(len(table.rings), -1), axis=1) > 0.0).all()
    # A street returns most of what is sent below the horizon; the KITTI car hides a tenth of it.
    is_down = np.repeat([laser.elevation_deg < -5.0 for laser in table.rings], table.num_columns)
    assert is_down[beam].sum() > 0.8 * is_down.sum()


@pytest.mark.parametrize("name", ["hdl32e", "vlp16"])
def test_staggered_rings_meet_what_single_rays_meet(scene: Scene, name: str) -> None:
    lidar = Lidar(name)
    ideal = scene.scan(lidar, ideal=True)
    origins, directions, _, _ = lidar.rays()
    some = np.random.Generator(np.random.PCG64(0)).permutation(len(origins))[:4000]
    pose = scene.sensor_poses()["world_from_velo"]
    hits = scene.cast_rays(
        (origins[some] @ pose[:3, :3].T + pose[:3, 3]).astype(np.float64),
        (directions[some] @ pose[:3, :3].T).astype(np.float64),
    )
    ours, theirs = ideal.range_m[some], hits.range_m
    both = np.isfinite(ours) & np.isfinite(theirs)
    assert (np.isfinite(ours) == np.isfinite(theirs)).mean() > 0.999
    assert (np.abs(ours[both] - theirs[both]) < 1e-3).mean() > 0.999


def test_a_wrong_table_of_a_rig_is_refused() -> None:
    table = Lidar.hdl64e_kitti().beam_table()
    assert isinstance(table.firing, EncoderFiring)
    with pytest.raises(CadetError, match="tick of the last firing"):
        Rig(lidar=Lidar.custom(replace(table, firing=replace(table.firing, firings=2160))))


def test_a_rig_with_a_table_sees_what_the_preset_sees() -> None:
    small = replace(Rig.kitti(), camera=Camera.kitti().resized(310, 94))
    table = Lidar.hdl64e_kitti().beam_table()
    scans = [
        Scene.random(seed=4, weather="clear_noon", rig=rig).capture().points_velo
        for rig in (small, replace(small, lidar=Lidar.custom(table)))
    ]
    np.testing.assert_array_equal(scans[0], scans[1])


def cadet_gen(*arguments: object) -> subprocess.CompletedProcess[str]:
    code = "from cadet.cli import run_cadet_gen\nif __name__ == '__main__':\n    run_cadet_gen()"
    command = [sys.executable, "-c", code, *map(str, arguments)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
    return subprocess.run(command, env=environment, text=True, capture_output=True, timeout=110, check=False)


@pytest.mark.parametrize("lidar", ["vlp16", "os1_128", "mine.toml"])
def test_datasets_of_other_sensors_are_whole(tmp_path: Path, lidar: str) -> None:
    if lidar.endswith(".toml"):
        (tmp_path / lidar).write_text(
            Lidar.hdl32e().beam_table().to_toml().replace("max_range_m = 100.0", "max_range_m = 30.0")
        )
    named = tmp_path / lidar if lidar.endswith(".toml") else lidar
    out = tmp_path / "out"
    arguments = (out, "-n", 2, "--workers", 1, "--image-size", "310x94", "--lidar", named)
    done = cadet_gen(*arguments)
    assert done.returncode == 0, done.stderr
    assert lint(out) == []
    sensor = Lidar.named(named)
    recorded = json.loads((out / "manifest.json").read_text())["rig"]
    assert recorded["lidar"] == (sensor.table.to_dict() if lidar == "mine.toml" and sensor.table else lidar)
    for frame in kitti.Dataset(out):
        assert 0.3 * sensor.beam_table().num_columns * len(sensor.beam_table().rings) < len(frame.points_velo)
    # Another sensor's frames must not be mixed in.
    other = cadet_gen(*arguments[:-1], "cadet", "--resume")
    assert other.returncode == 2
    assert "rig" in other.stderr


def test_an_unknown_sensor_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    done = cadet_gen(tmp_path / "out", "-n", 1, "--lidar", "hdl65e")
    assert done.returncode == 2
    assert done.stderr.startswith("cadet-gen: --lidar: unknown lidar 'hdl65e'; known: hdl64e_kitti,")
    assert not (tmp_path / "out").exists()
