"""Scans as PLY, PCD, LAS, and .npz: read back by this package, and by the programs that they are made for."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

import cadet
from cadet import kitti
from cadet.cli.tools import cadet as command
from cadet.errors import CadetError
from cadet.formats.convert import convert
from cadet.formats.kitti.files.range_image import range_image
from cadet.formats.point_files import POINT_FILES, columns_of_points
from cadet.formats.scan_files.read import scan_from_data
from cadet.generate import Settings, generate
from synthetic import make_frame

N = 400
RING, TIME_S = np.arange(N) % 64, np.linspace(-0.05, 0.05, N, dtype=np.float32)


def points() -> NDArray[np.float32]:
    """Return points at whole millimeters, as scans have them."""
    rng = np.random.default_rng(0)
    xyz = np.round(rng.normal(0, (20, 20, 1), (N, 3)), 3)
    return np.column_stack([xyz, rng.integers(0, 100, N) / 100]).astype(np.float32)


def encoded(suffix: str) -> bytes:
    return POINT_FILES[suffix](columns_of_points(points(), RING, TIME_S))


@pytest.mark.parametrize("suffix", ["ply", "pcd"])
def test_our_own_reader_gives_the_scan_back(suffix: str) -> None:
    scan = scan_from_data(encoded(suffix), "scan")
    np.testing.assert_array_equal(scan.points_velo, points())
    assert scan.ring is not None and scan.time is not None and scan.num_left_out == 0
    np.testing.assert_array_equal(scan.ring, RING)
    np.testing.assert_array_equal(scan.time, TIME_S)
    bare = scan_from_data(POINT_FILES[suffix](columns_of_points(points())), "scan")
    assert bare.ring is None and bare.time is None and len(bare.points_velo) == N


def test_headers_are_what_pcl_and_the_devices_drivers_write() -> None:
    """PCL's page "The PCD file format", and the fields of velodyne_pointcloud's PointXYZIRT."""
    head, _, body = encoded("pcd").partition(b"DATA binary\n")
    assert head.decode().splitlines()[1:] == [
        *("VERSION 0.7", "FIELDS x y z intensity ring time", "SIZE 4 4 4 4 2 4", "TYPE F F F F U F"),
        *("COUNT 1 1 1 1 1 1", f"WIDTH {N}", "HEIGHT 1", "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {N}"),
    ]
    assert len(body) == 22 * N
    head, _, body = encoded("ply").partition(b"end_header\n")
    assert head.decode().splitlines()[:2] == ["ply", "format binary_little_endian 1.0"] and len(body) == 24 * N
    with np.load(io.BytesIO(encoded("npz"))) as arrays:
        assert {name: str(arrays[name].dtype) for name in arrays} == {
            **dict.fromkeys(("x", "y", "z", "intensity", "time"), "float32"),
            "ring": "uint16",
        }
        np.testing.assert_array_equal(arrays["x"], points()[:, 0])


def test_a_las_file_holds_what_the_specification_says_at_its_offsets() -> None:
    """Offsets counted in tables 3, 16, and 24 of "LAS Specification 1.4 - R15"."""
    data = encoded("las")
    assert data[:4] == b"LASF" and data[24:26] == b"\x01\x04"
    header_size, start, num_records, kind, length = struct.unpack_from("<HIIBH", data, 94)
    assert (header_size, start, num_records, kind, length) == (375, 375 + 54 + 192, 1, 6, 32)
    assert struct.unpack_from("<Q", data, 247)[0] == N and len(data) == start + N * length
    scale = struct.unpack_from("<3d", data, 131)
    highest_m = struct.unpack_from("<d", data, 179)[0]
    assert scale == (0.001, 0.001, 0.001) and highest_m == pytest.approx(points()[:, 0].max(), abs=1e-6)
    x, y, z, intensity = struct.unpack_from("<3iH", data, start + 7 * length)
    time_s, ring = struct.unpack_from("<dH", data, start + 7 * length + 22)
    assert (x / 1000, y / 1000, z / 1000) == pytest.approx(points()[7, :3].tolist(), abs=1e-6)
    assert intensity == round(65535 * float(points()[7, 3])) and (time_s, ring) == (TIME_S[7], 7)
    assert data[375 + 54 + 2 : 375 + 54 + 8] == b"\x03\0ring"


def test_laspy_reads_every_field() -> None:
    laspy = pytest.importorskip("laspy", reason="needs laspy")
    las = laspy.read(io.BytesIO(encoded("las")))
    np.testing.assert_allclose(np.asarray(las.xyz), points()[:, :3], atol=1e-5)
    np.testing.assert_array_equal(las.intensity, np.rint(points()[:, 3].astype(np.float64) * 65535))
    np.testing.assert_array_equal(las["ring"], RING)
    np.testing.assert_array_equal(las.gps_time, TIME_S)
    assert list(las.point_format.extra_dimension_names) == ["ring"] and las.header.creation_date is None
    assert set(np.asarray(las.number_of_returns)) == set(np.asarray(las.return_number)) == {1}
    bare = laspy.read(io.BytesIO(POINT_FILES["las"](columns_of_points(points()))))
    assert len(bare.points) == N and not list(bare.point_format.extra_dimension_names)


@pytest.mark.parametrize("suffix", ["ply", "pcd"])
def test_open3d_reads_every_field(suffix: str, tmp_path: Path) -> None:
    open3d = pytest.importorskip("open3d", reason="needs Open3D", exc_type=ImportError)
    path = tmp_path / f"scan.{suffix}"
    path.write_bytes(encoded(suffix))
    cloud = open3d.t.io.read_point_cloud(str(path))
    np.testing.assert_array_equal(cloud.point.positions.numpy(), points()[:, :3])
    np.testing.assert_array_equal(cloud.point.intensity.numpy()[:, 0], points()[:, 3])
    np.testing.assert_array_equal(cloud.point.ring.numpy()[:, 0], RING)
    np.testing.assert_array_equal(cloud.point.time.numpy()[:, 0], TIME_S)
    old = open3d.io.read_point_cloud(str(path))
    np.testing.assert_allclose(np.asarray(old.points), points()[:, :3], atol=1e-6)


@pytest.mark.parametrize("suffix", POINT_FILES)
def test_an_empty_scan_is_a_file_of_no_points(suffix: str) -> None:
    empty = np.zeros((0, 4), np.float32)
    data = POINT_FILES[suffix](columns_of_points(empty, np.zeros(0, np.int32), np.zeros(0, np.float32)))
    assert data == POINT_FILES[suffix](columns_of_points(empty, np.zeros(0, np.int32), np.zeros(0, np.float32)))
    assert len(data) > 100


def test_generated_scans_are_the_same_in_every_format(tmp_path: Path) -> None:
    rig = cadet.Rig(camera=cadet.Camera.kitti().resized(310, 94), lidar=cadet.Lidar.vlp16(rolling=True))
    kinds = tuple(f"points_{suffix}" for suffix in POINT_FILES)
    write = (*kinds, "range_image", "point_times")
    settings = Settings(seed=2, num_frames=2, policy=cadet.ResetPolicy.kitti().with_rig(rig), write=write)
    generate(tmp_path / "out", settings, workers=1)
    assert kitti.lint(tmp_path / "out", strict=True) == []
    training = tmp_path / "out" / "training"
    points_velo = kitti.read_frame(tmp_path / "out", 1).points_velo
    for suffix in ("ply", "pcd"):
        scan = scan_from_data((training / f"points_{suffix}" / f"000001.{suffix}").read_bytes(), suffix)
        np.testing.assert_array_equal(scan.points_velo, points_velo)
        assert scan.ring is not None and set(scan.ring.tolist()) == set(range(16))
        # Ring 0 is the highest laser, and times are those beside KITTI's scans.
        elevation = np.arctan2(points_velo[:, 2], np.hypot(points_velo[:, 0], points_velo[:, 1]))
        means = [elevation[scan.ring == ring].mean() for ring in range(16)]
        assert sorted(means, reverse=True) == means
        times_s = np.fromfile(training / "point_times" / "000001.bin", "<f4")
        np.testing.assert_array_equal(scan.time, times_s)
        # Each beam that returned is a pixel, of its ring's row, as far away as its point.
        image = np.load(training / "range_image" / "000001.npy")
        assert image.shape == (16, 1808) and (image > 0.0).sum() == len(points_velo)
        np.testing.assert_array_equal((image > 0.0).sum(axis=1), np.bincount(scan.ring, minlength=16))
        np.testing.assert_allclose(image[image > 0.0], np.linalg.norm(points_velo[:, :3], axis=1), atol=0.03)
    # Columns rise counter-clockwise from forward, as far as lasers fire one after the other.
    row, column = np.nonzero(image)
    azimuth = np.arctan2(points_velo[:, 1], points_velo[:, 0])
    off_rad = np.angle(np.exp(1j * (azimuth - 2 * np.pi * column / 1808)))
    assert np.abs(off_rad).max() < np.deg2rad(1.0)

    convert(tmp_path / "out", tmp_path / "scans", "ply")
    scan = scan_from_data((tmp_path / "scans/training/points_ply/000001.ply").read_bytes(), "converted")
    np.testing.assert_array_equal(scan.points_velo, points_velo)
    np.testing.assert_array_equal(scan.time, times_s)
    assert scan.ring is None

    damaged = training / "range_image" / "000000.npy"
    image = np.load(damaged)
    image[tuple(np.argwhere(image == 0.0)[0])] = 9.0
    np.save(damaged, image)
    (training / "range_image" / "000001.npy").write_bytes(b"\x93NUMPY")
    found = [(finding.file, finding.rule) for finding in kitti.lint(tmp_path / "out")]
    assert found == [("range_image/000000.npy", "damaged-file"), ("range_image/000001.npy", "damaged-file")]


def test_a_pixel_of_a_range_image_is_the_nearest_of_its_beams_echoes() -> None:
    lidar = cadet.Lidar.vlp16(returns="triple", divergence_mrad=3.0)
    scan = cadet.Scene.random(seed=4, weather="snow").scan(lidar)
    image = range_image(scan, lidar)
    assert (image > 0.0).sum() == len(set(zip(scan.ring.tolist(), scan.column.tolist(), strict=True))) < len(scan.ring)
    nearest = np.full(image.shape, np.inf)
    np.minimum.at(nearest, (scan.ring, scan.column), scan.range_m)
    np.testing.assert_allclose(image, np.where(np.isinf(nearest), 0.0, nearest), rtol=1e-6)


def test_scans_of_any_set_are_converted(tmp_path: Path) -> None:
    root = tmp_path / "kitti"
    for number in range(2):
        kitti.write_frame(root, number, make_frame(seed=number), split="train" if number else "val")
    done = CliRunner().invoke(command, ["convert", str(root), str(tmp_path / "las"), "--to", "las"])
    assert (done.exit_code, done.stderr) == (0, f"2 frames in {tmp_path / 'las'}\n")
    names = sorted(str(path.relative_to(tmp_path / "las")) for path in (tmp_path / "las").rglob("*") if path.is_file())
    assert names[-2:] == ["training/points_las/000000.las", "training/points_las/000001.las"]
    assert {"ImageSets/train.txt", "ImageSets/val.txt"} <= set(names)
    convert(root, tmp_path / "shards", "webdataset")
    convert(tmp_path / "shards", tmp_path / "again", "las")
    for name in names[-2:]:
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / "las" / name).read_bytes()
    (root / "training" / "velodyne" / "000001.bin").unlink()
    with pytest.raises(CadetError, match=r"velodyne/000001\.bin: no such file"):
        convert(root, tmp_path / "pcd", "pcd")
