"""`cadet fit-lidar`: sensors come back from their scans, KITTI's from its own, and what is no scan is refused."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import struct
import subprocess
import sys
import termios
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

import real_kitti
from cadet import BeamTable, CadetError, EncoderFiring, Laser, Lidar, MissingFileError, Scene, UniformFiring
from cadet.cli import run_cadet
from cadet.cli.lidar import _ring_table
from cadet.datasets.lidar_fit import LidarFit, fit_lidar
from cadet.datasets.lidar_fit.fit import RingFit
from scans.lidar_scans import ring_of, write_scan, yard_scan
from scans.scan_writers import pcd, ply

CUSTOM = BeamTable(
    name="custom",
    # Two blocks at different heights and uneven steps.
    rings=tuple(
        Laser(
            elevation_deg=7.0 - 1.31 * k + 0.2 * (k % 3),
            height_m=0.15 if k < 11 else 0.03 + 0.002 * k,
            azimuth_offset_deg=round(0.04 * (k % 4), 3),
        )
        for k in range(22)
    ),
    firing=UniformFiring(columns=1500),
)
ENCODER = replace(
    CUSTOM,
    rings=tuple(replace(laser, azimuth_offset_deg=0.0) for laser in CUSTOM.rings),
    firing=EncoderFiring(ticks_per_turn=3000, ticks_per_firing=1.4, firings=2142),
)


def check(fit: LidarFit, table: BeamTable, elevation_deg: float, height_m: float) -> None:
    assert len(fit.rings) == len(table.rings)
    for ring, laser in zip(fit.rings, table.rings, strict=True):
        assert ring.laser.elevation_deg == pytest.approx(laser.elevation_deg, abs=elevation_deg)
        assert ring.laser.height_m == pytest.approx(laser.height_m, abs=height_m)


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("yard")
    for seed in range(3):
        write_scan(folder / f"{seed}.bin", yard_scan(CUSTOM, seed))
    return folder


def test_a_custom_sensor_comes_back_from_its_scans(yard: Path) -> None:
    fit = fit_lidar([yard])
    check(fit, CUSTOM, 0.005, 0.0005)
    assert fit.table.firing == CUSTOM.firing
    for ring, laser in zip(fit.rings, CUSTOM.rings, strict=True):
        assert ring.laser.azimuth_offset_deg == pytest.approx(laser.azimuth_offset_deg, abs=0.003)
        assert ring.missing_share == pytest.approx(0.1, abs=0.03)
        assert ring.zero_share == pytest.approx(0.1, abs=0.03)
        assert ring.outlier_share == 0.0
    assert fit.median_residual_m < 0.0004
    assert fit.unassigned_points == 0
    assert fit.table.range_noise_m == pytest.approx(0.01, rel=0.25)
    assert BeamTable.from_toml(fit.to_toml()) == fit.table


def test_an_encoders_ticks_come_back(tmp_path: Path) -> None:
    for seed in range(2):
        write_scan(tmp_path / f"{seed}.bin", yard_scan(ENCODER, seed))
    fit = fit_lidar([tmp_path])
    check(fit, ENCODER, 0.005, 0.0005)
    firing = fit.table.firing
    assert isinstance(firing, EncoderFiring)
    assert firing.ticks_per_turn == 3000
    assert firing.ticks_per_firing == pytest.approx(1.4, abs=0.002)
    assert abs(firing.firings - 2142) <= 3


@pytest.mark.parametrize("order", ["shuffled", "by column", "clockwise", "from behind"])
def test_the_order_of_points_does_not_matter(yard: Path, tmp_path: Path, order: str) -> None:
    generator = np.random.Generator(np.random.PCG64(5))
    for path in yard.glob("*.bin"):
        points = np.fromfile(path, "<f4").reshape(-1, 4)
        azimuth, ring = np.degrees(np.arctan2(points[:, 1], points[:, 0])) % 360.0, ring_of(points)
        keys = {
            "shuffled": (generator.permutation(len(points)),),
            "by column": (ring, np.round(azimuth, 1)),
            "clockwise": (-azimuth, ring),
            "from behind": ((azimuth - 180.0) % 360.0, ring),
        }
        write_scan(tmp_path / path.name, points[np.lexsort(keys[order])])
    fit = fit_lidar([tmp_path])
    check(fit, CUSTOM, 0.01, 0.001)
    assert fit.in_ring_order == (order in ("clockwise", "from behind"))
    assert fit.table.firing == CUSTOM.firing


def test_a_ring_that_sees_one_side_alone_is_told_from_the_next(tmp_path: Path) -> None:
    """Where one ring ends before the next begins, azimuths rise on: only the heights tell them apart."""
    for seed in range(2):
        points = yard_scan(CUSTOM, seed)
        azimuth, ring = np.degrees(np.arctan2(points[:, 1], points[:, 0])) % 360.0, ring_of(points)
        is_kept = ((ring != 0) | (azimuth < 100.0)) & ((ring != 1) | (azimuth > 150.0))
        write_scan(tmp_path / f"{seed}.bin", points[is_kept])
    check(fit_lidar([tmp_path]), CUSTOM, 0.005, 0.0005)


PANDAR40 = BeamTable(
    name="pandar40",
    # 15 to -25 degrees, a third of a degree apart in the middle, in groups that look to either side.
    rings=tuple(
        Laser(elevation_deg=elevation, azimuth_offset_deg=1.042 * (number % 3))
        for number, elevation in enumerate(
            (15.0, 11.0, 8.0, 5.0, 3.0, *(2.0 - k / 3.0 for k in range(25)), *range(-7, -15, -1), -19.0, -25.0)
        )
    ),
    firing=UniformFiring(columns=1800),
)
SENSORS = {
    "HDL-32E": Lidar.hdl32e().beam_table(),
    "VLP-16": Lidar.vlp16().beam_table(),
    "OS1-64": Lidar.os1_64().beam_table(),
    "Pandar40": PANDAR40,
}


def driver_scan(table: BeamTable, seed: int, *, moved_m: float = 0.0) -> NDArray[np.float64]:
    """Return a scan (N, 5) as drivers write it: clockwise in the order of firing, intensities to 255, lasers' numbers.

    What did not return is a row at the origin. With `moved_m` the vehicle drove that far to the left in the turn, which
    lifted its nose and turned it, and points were moved to where they are seen from at the turn's end.
    """
    points = yard_scan(table, seed).astype(np.float64)
    heights = np.array([laser.height_m for laser in table.rings])
    elevations = np.radians([laser.elevation_deg for laser in table.rings])
    off = np.abs(points[:, 2:3] - heights - np.tan(elevations) * np.hypot(points[:, :1], points[:, 1:2]))
    ring = len(table.rings) - 1 - np.argmin(off, axis=1)
    rows = np.column_stack([points[:, :3], np.round(255.0 * points[:, 3]), ring])
    # Each fourth row stands for no return, as it does where the sky is.
    rows = np.concatenate([rows, np.column_stack([np.zeros((len(rows) // 3, 4)), ring[: len(rows) // 3]])])
    when = -np.arctan2(points[:, 1], points[:, 0]) / (2.0 * np.pi) % 1.0
    when = np.concatenate([when, np.random.default_rng(seed).random(len(rows) - len(points))])
    order = np.lexsort((rows[:, 4], np.round(360.0 * when, 1)))
    # To one side most rows are lost altogether: rows in order are not even in time.
    order = order[(when[order] < 0.6) | (np.arange(len(order)) % 4 == 0)]
    rows, late = np.asarray(rows[order], np.float64), (when[order] - 1.0)[:, None]
    if moved_m:
        xyz = rows[:, :3]
        rows[:, :3] += late * (np.array([0.02, moved_m, 0.01]) + np.cross([0.0015, -0.0007, 0.002], xyz))
    return rows


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("kind", ["five columns", "moved", "PCD", "PLY", "four columns"])
def test_other_sensors_come_back_as_their_drivers_write_them(sensor: str, kind: str, tmp_path: Path) -> None:
    table = SENSORS[sensor]
    for seed in range(2):
        rows = driver_scan(table, seed, moved_m=0.45 if kind == "moved" else 0.0)
        columns = dict(zip(("x", "y", "z", "intensity"), rows[:, :4].T.astype("<f4"), strict=True))
        columns |= {"ring": rows[:, 4].astype("<u2")}
        columns["x"][[5, 700, 701]] = np.nan
        if kind in ("PCD", "PLY"):
            data = pcd(columns, "binary_compressed") if kind == "PCD" else ply(columns, "binary_big_endian")
        else:
            data = np.column_stack(list(columns.values())[: 4 if kind == "four columns" else 5]).astype("<f4").tobytes()
        (tmp_path / f"{seed}.{kind.lower() if kind in ('PCD', 'PLY') else 'bin'}").write_bytes(data)
    fit = fit_lidar([tmp_path])
    check(fit, table, 0.03, 0.003)
    assert fit.num_left_out == pytest.approx(2 * len(rows) / 4, rel=0.05)
    assert f"{fit.num_left_out} more rows mean no return (not finite, or at the origin)." in fit.remarks()
    assert fit.moved_m == pytest.approx(0.45 if kind == "moved" else 0.0, abs=0.03)
    assert any("motion, which is undone" in line for line in fit.remarks()) == (kind == "moved")
    assert fit.table.num_columns == pytest.approx(table.num_columns, rel=0.005)


def test_whole_columns_tell_the_lasers(tmp_path: Path) -> None:
    """Without numbers, where the rows for no return are kept: 32 lasers in turn, 1,085 times."""
    table = replace(SENSORS["HDL-32E"], firing=UniformFiring(columns=1085))
    rows = driver_scan(table, 0)
    returned = rows[np.abs(rows[:, :3]).max(axis=1) > 0.0]
    column = np.round(np.degrees(np.arctan2(returned[:, 1], returned[:, 0])) % 360.0 / 360.0 * 1085).astype(int) % 1085
    grid = np.zeros((1085, 32, 4))
    grid[column, returned[:, 4].astype(int)] = returned[:, :4]
    late = (np.arange(1085) / 1085 - 1.0)[:, None, None]
    grid[..., :3] += late * np.array([0.3, 0.1, 0.01])
    (tmp_path / "whole.bin").write_bytes(grid.astype("<f4").tobytes())
    fit = fit_lidar([tmp_path / "whole.bin"])
    check(fit, table, 0.1, 0.01)
    assert fit.moved_m == pytest.approx(0.316, abs=0.03)


def test_what_cannot_be_undone_is_said(tmp_path: Path) -> None:
    """Moved points without lasers' numbers, or in no order, and numbers that are none."""
    rows = driver_scan(SENSORS["VLP-16"], 0, moved_m=0.45)
    generator = np.random.default_rng(0)
    for bad in (rows[:, :4], generator.permutation(rows)):
        (tmp_path / "bad.bin").write_bytes(bad.astype("<f4").tobytes())
        with pytest.raises(CadetError, match=r"^bad\.bin: only .* need their lasers' numbers .* the order of firing"):
            fit_lidar([tmp_path / "bad.bin"])
    rows = driver_scan(SENSORS["VLP-16"], 0)
    rows[:, 4] = generator.integers(0, 20, len(rows))
    (tmp_path / "classes.bin").write_bytes(rows.astype("<f4").tobytes())
    check(fit_lidar([tmp_path / "classes.bin"]), SENSORS["VLP-16"], 0.1, 0.01)


@real_kitti.needs_kitti
def test_kittis_own_scans_give_the_table_of_its_sensor() -> None:
    fit = fit_lidar([real_kitti.ROOT])
    assert fit.num_scans >= 6
    assert fit.median_residual_m < 0.001
    assert max(ring.median_residual_m for ring in fit.rings) < 0.001
    check(fit, Lidar.hdl64e_kitti().beam_table(), 0.01, 0.002)
    firing = fit.table.firing
    assert isinstance(firing, EncoderFiring)
    assert firing.ticks_per_turn == 4000
    assert firing.ticks_per_firing == pytest.approx(1.8587, abs=0.003)
    assert fit.table.min_range_m == pytest.approx(1.46, abs=0.02)
    assert fit.table.max_range_m == 80.0
    assert 0.006 < fit.table.range_noise_m < 0.0095, "walls and roads, not grass"

    # What KITTI's car hides, as it was told by other means and from fewer frames.
    def hidden(table: BeamTable) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
        degrees = np.arange(720) / 2.0 + 0.25
        return np.array([[any(a <= d <= b for a, b in laser.blind_deg) for d in degrees] for laser in table.rings])

    ours, theirs = hidden(fit.table), hidden(Lidar.hdl64e_kitti().beam_table())
    assert (ours & theirs).sum() > 0.9 * theirs.sum()
    assert (ours & theirs).sum() > 0.8 * ours.sum()
    # Rings with weak receivers are known for their zero intensities.
    zeros = [ring.zero_share for ring in fit.rings]
    assert min(zeros[ring] for ring in (15, 21, 36, 51)) > 0.2
    assert max(fit.rings[ring].laser.gain for ring in (15, 21, 36, 51)) < 0.75


@pytest.fixture(scope="module")
def suburbs() -> list[Scene]:
    return [Scene.random(seed=seed, weather="clear_noon") for seed in range(4)]


@pytest.mark.parametrize("lidar", [Lidar.hdl64e_kitti(), Lidar.vlp16(), Lidar.custom(CUSTOM)], ids=lambda x: x.name)
def test_generated_scans_give_the_sensor_that_made_them(suburbs: list[Scene], lidar: Lidar, tmp_path: Path) -> None:
    table = lidar.beam_table()
    for seed, scene in enumerate(suburbs):
        write_scan(tmp_path / f"{seed}.bin", scene.scan(lidar).points_velo)
    fit = fit_lidar([tmp_path])
    check(fit, table, 0.01, 0.002)
    if isinstance(table.firing, UniformFiring):
        assert fit.table.firing == table.firing
        offsets = [ring.laser.azimuth_offset_deg for ring in fit.rings]
        np.testing.assert_allclose(offsets, [laser.azimuth_offset_deg for laser in table.rings], rtol=0.0, atol=0.002)
    else:
        assert isinstance(fit.table.firing, EncoderFiring)
        assert abs(fit.table.num_columns - table.num_columns) < 10
    # And what was fitted makes scans again.
    again = suburbs[0].scan(Lidar.custom(fit.table))
    first = np.fromfile(tmp_path / "0.bin", "<f4").reshape(-1, 4)
    # Where receivers are focused is not fitted.
    assert len(again.points_velo) == pytest.approx(len(first), rel=0.07)


def test_scans_that_are_none_are_refused_in_one_line(yard: Path, tmp_path: Path) -> None:
    points = np.fromfile(yard / "0.bin", "<f4").reshape(-1, 4)
    generator = np.random.Generator(np.random.PCG64(0))

    def refusal(name: str, data: bytes) -> str:
        (tmp_path / name).write_bytes(data)
        with pytest.raises(CadetError) as caught:
            fit_lidar([tmp_path / name])
        assert "\n" not in str(caught.value)
        return str(caught.value)

    assert refusal("cut.bin", points.tobytes()[:-3]).startswith("cut.bin: truncated: ")
    assert refusal("empty.bin", b"") == "empty.bin: 0 points, at least 1000 are needed"
    assert refusal("few.bin", points[:999].tobytes()) == "few.bin: 999 points, at least 1000 are needed"
    noise = (generator.normal(0.0, 10.0, (20_000, 4)) * [1, 1, 0.1, 0]).astype(np.float32)
    assert "lie on the cones of lasers on the z axis" in refusal("noise.bin", noise.tobytes())
    # A scan in the frame of a vehicle's middle.
    moved = points + np.array([1.3, 0.0, -0.9, 0.0], np.float32)
    assert "lie on the cones of lasers on the z axis" in refusal("moved.bin", moved.tobytes())
    same = np.tile(np.array([[5.0, 1.0, 0.2, 0.5]], np.float32), (2000, 1))
    assert "lie on the cones" in refusal("one_point.bin", same.tobytes())
    with pytest.raises(MissingFileError, match="no such file or folder"):
        fit_lidar([tmp_path / "nowhere"])
    (tmp_path / "none").mkdir()
    with pytest.raises(MissingFileError, match=r"no \.bin, \.pcd, \.ply or \.npy files in it"):
        fit_lidar([tmp_path / "none"])


def test_the_command_writes_what_the_generator_reads(
    yard: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(*arguments: object) -> int | str | None:
        monkeypatch.setattr(sys, "argv", ["cadet", "fit-lidar", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            run_cadet()
        return ended.value.code

    out = tmp_path / "mine.toml"
    assert run(yard / "0.bin", yard / "1.bin", "-o", out) == 0
    printed = capsys.readouterr().out
    assert "22 rings, 1500 columns" in printed
    assert printed.endswith(f"wrote {out}\n")
    assert Lidar.read(out).name == "mine"
    assert run(yard, "-o", tmp_path / "mine.txt") == 2
    assert capsys.readouterr().err.startswith("cadet: -o: expected a file that ends in .toml")
    assert run("nothing", "-o", "/nodir/x.toml") == 2
    assert capsys.readouterr().err == "cadet: /nodir/x.toml: no such folder: /nodir\n"
    assert run(tmp_path / "mine.toml", "-o", out) == 2
    assert capsys.readouterr().err.startswith("cadet: mine.toml: ")


def rows_of(printed: str) -> list[list[float]]:
    """Return the numbers of the table's rows."""
    lines = [line.split() for line in printed.splitlines()]
    return [[float(field) for field in line] for line in lines if line and line[0].isdigit() and len(line) == 13]


def fitted_rows(fit: LidarFit) -> list[list[float]]:
    """Return what the table's rows should say, unrounded."""
    return [
        [
            *(number, ring.laser.elevation_deg, ring.elevation_sd_deg, 1e3 * ring.laser.height_m),
            *(1e3 * ring.height_sd_m, ring.laser.azimuth_offset_deg, 1e3 * ring.laser.range_offset_m),
            *(ring.num_points, 1e3 * ring.median_residual_m),
            *(100 * ring.outlier_share, 100 * ring.missing_share, 100 * ring.zero_share, ring.laser.gain),
        ]
        for number, ring in enumerate(fit.rings)
    ]


ROUNDED = [0, 5e-4, 5e-5, 0.05, 5e-3, 5e-4, 0.5, 0, 5e-3, 0.05, 0.5, 0.5, 5e-3]


@pytest.mark.parametrize("columns", [None, 80, 40])
def test_the_command_prints_its_whole_table(yard: Path, tmp_path: Path, columns: int | None) -> None:
    """Into a pipe, and in terminals that are wide enough and that are not."""
    code = "from cadet.cli import run_cadet; run_cadet()"
    command = [sys.executable, "-c", code, "fit-lidar", str(yard / "0.bin"), "-o", str(tmp_path / "mine.toml")]
    environment = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
    environment |= {"PYTHONPATH": str(Path(__file__).parents[3] / "python"), "TERM": "xterm"}
    if columns is None:
        printed = subprocess.run(
            command, env=environment, text=True, stdout=subprocess.PIPE, timeout=110, check=True
        ).stdout
    else:
        printed = output_in_terminal(command, environment, columns)
    assert "\N{HORIZONTAL ELLIPSIS}" not in printed
    rows = rows_of(printed)
    expected = fitted_rows(fit_lidar([yard / "0.bin"]))
    assert len(rows) == len(expected) == 22
    assert (np.abs(np.array(rows) - np.array(expected)) <= np.array(ROUNDED) * 1.001 + 1e-9).all()
    table = printed[: printed.index("22 rings")].splitlines()
    assert max(map(len, table)) <= 80, "it fits a terminal of 80 columns"
    heads = " ".join(table[:2])
    for head in ("ring", "elev.", "height", "offset", "range", "points", "resid.", "outl.", "lost", "zero", "gain"):
        assert head in heads


def test_the_table_of_large_sets_fits_80_columns() -> None:
    laser = Laser(elevation_deg=-24.123, height_m=0.1234, azimuth_offset_deg=359.123, range_offset_m=-0.1234)
    ring = RingFit(laser, 0.0123, 0.00123, 0.0123, 14_123_456, 0.00123, 0.123, 1.0, 0.99)
    lines = _ring_table(SimpleNamespace(rings=[ring] * 101))  # type: ignore[arg-type]
    assert max(map(len, lines)) <= 80
    assert lines[-1].split() == "100 -24.123 0.0123 123.4 1.23 359.123 -123 14.1M 1.23 12.3 100 99 1.00".split()


def output_in_terminal(command: list[str], environment: dict[str, str], columns: int) -> str:
    """Run a command in a terminal of that many columns and return what it wrote, colors taken off."""
    ours, theirs = os.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    with subprocess.Popen(command, env=environment, stdout=theirs, stderr=theirs, stdin=theirs) as process:
        os.close(theirs)
        written = b""
        with contextlib.suppress(OSError):  # the terminal is gone with its last writer
            while chunk := os.read(ours, 65_536):
                written += chunk
        os.close(ours)
    assert process.returncode == 0, written
    return re.sub(r"\x1b\[[0-9;]*m", "", written.decode()).replace("\r\n", "\n")
