"""Scans of other counts of numbers than four: read by their first four where they are known, or refused by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import real_kitti
from cadet.errors import KittiFormatError
from cadet.formats.kitti import lint, read_frame, write_frame
from cadet.formats.kitti.files import dialects
from cadet.formats.kitti.files.scan_columns import Layout, layout_of
from cadet.formats.kitti.files.velodyne import points_from_bytes
from scans.lidar_scans import VLP16, yard_scan
from synthetic import make_frame

Array = NDArray[np.float64]
RNG = np.random.default_rng(1)


def read(rows: NDArray[np.generic], name: str = "a.bin") -> tuple[NDArray[np.float32], list[str]]:
    with dialects.collected() as found:
        points_velo = points_from_bytes(rows.tobytes(), name)
    return points_velo, [dialect.kind for dialect in found]


def yard(intensity: float = 1.0) -> Array:
    """Return a scan (N, 4) ring by ring; 4 N, 5 N and 6 N numbers all divide by 60."""
    rows = yard_scan(VLP16, 0).astype(np.float64)
    rows[:, 3] *= intensity
    return rows[: len(rows) // 60 * 60]


def in_order(rows: Array, order: str) -> Array:
    if order == "by azimuth":
        return rows[np.argsort(np.arctan2(rows[:, 1], rows[:, 0]), kind="stable")]
    return np.random.default_rng(0).permutation(rows) if order == "shuffled" else rows


def ring_of(rows: Array) -> Array:
    rank = np.argsort(np.argsort(np.arctan2(rows[:, 2], np.hypot(rows[:, 0], rows[:, 1]))))
    return np.asarray(rank // (len(rows) // 15), np.float64)


def with_whole_intensities() -> NDArray[np.float32]:
    rows = yard().astype("<f4")
    rows[:, 3] = np.arange(len(rows), dtype="<u4").view("<f4")
    return rows


# What stands behind x, y, z and intensity, of rows (N, 4).
KNOWN: dict[str, Callable[[Array], list[NDArray[np.floating]]]] = {
    "ring": lambda rows: [ring_of(rows)],
    "a constant": lambda rows: [np.ones(len(rows))],
    "no time": lambda rows: [np.zeros(len(rows))],
    "time": lambda rows: [np.linspace(0.0, 0.1, len(rows))],
    "classes": lambda rows: [np.arange(len(rows)) % 7 * 10.0],
    "ring and time": lambda rows: [ring_of(rows), RNG.random(len(rows)) * 0.1],
    "time and ring": lambda rows: [RNG.random(len(rows)) * 0.1, ring_of(rows)],
    "elongation and microseconds": lambda rows: [
        RNG.random(len(rows)),
        np.full(len(rows), 1.5e15),
    ],
}
UNKNOWN: dict[str, Callable[[Array], Array]] = {
    "x y z": lambda rows: rows[:, :3],
    "one unknown": lambda rows: np.column_stack([rows, RNG.random(len(rows))]),
    "two unknown": lambda rows: np.column_stack([rows, RNG.random((len(rows), 2))]),
    "colors": lambda rows: np.column_stack([rows[:, :3], RNG.integers(0, 256, (len(rows), 3))]),
    "normals": lambda rows: np.column_stack([rows[:, :3], RNG.uniform(-1, 1, (len(rows), 3))]),
    "classes' shares": lambda rows: np.column_stack([rows, RNG.dirichlet([1.0] * 4, len(rows))]),
    "filled structures": lambda rows: np.insert(rows, [3, 4, 4, 4], [0.0, 3.0, 1e-42, 1e-3], axis=1),
}


@pytest.mark.parametrize("order", ["ring by ring", "by azimuth", "shuffled"])
@pytest.mark.parametrize("intensity", [1.0, 255.0])
@pytest.mark.parametrize("kind", KNOWN)
def test_known_columns_are_left_out(kind: str, intensity: float, order: str) -> None:
    rows = in_order(yard(intensity), order)
    wide = np.column_stack([rows, *KNOWN[kind](rows)])
    assert wide.size % 4 == 0, "as four numbers a point it would pass"
    for dtype in ("<f4", "<f8"):
        points_velo, kinds = read(wide.astype(dtype))
        np.testing.assert_array_equal(points_velo, rows.astype(np.float32))
        assert kinds == ["scan-columns"]
    # Cut off by one number: its own count is named, not four.
    count = "five" if wide.shape[1] == 5 else "six"
    with pytest.raises(
        KittiFormatError, match=rf"^a\.bin: truncated: .* points of {count} numbers and .*copy the file"
    ):
        points_from_bytes(wide.astype("<f4").tobytes()[:-4], "a.bin")


@pytest.mark.parametrize("kind", UNKNOWN)
def test_unknown_columns_are_refused_by_name(kind: str) -> None:
    wide = UNKNOWN[kind](yard())
    name = {3: "three", 5: "five", 6: "six", 8: "eight"}[wide.shape[1]]
    with pytest.raises(KittiFormatError, match=rf"^a\.bin: {name} numbers a point\? expected x y z intensity"):
        points_from_bytes(wide.astype("<f4").tobytes(), "a.bin")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"# .PCD v0.7\nVERSION 0.7\n", r"a PCD file, .*`cadet.formats.scan_files.read_scan` reads it"),
        (b"ply\nformat ascii 1.0\n", "a PLY file"),
        (b"\x93NUMPY\x01\x00v\x00", r"a \.npy file"),
        (b"1.0 2.0 3.0 0.5\n1.0 2.0 3.0 0.5\n", "a text file, .*convert it"),
        (b"PK\x03\x04" + bytes(28), r"a ZIP or \.npz file"),
        (np.arange(4000, dtype="<i4").tobytes(), "its numbers are not meters"),
        ((1000 * yard()).astype("<i2").tobytes(), "its numbers are not meters"),
        (yard().astype(">f4").tobytes(), "its numbers are not meters"),
        (yard().astype("<f2").tobytes(), "its numbers are not meters"),
        ((yard() + [691_000, 5_336_000, 0, 0]).astype("<f4").tobytes(), "its numbers are not meters from the sensor"),
        (with_whole_intensities().tobytes(), "its intensities are not float32"),
        (yard().T.astype("<f4").tobytes(), "all columns are alike: is it written column by column"),
        (np.full((60, 4), np.nan, "<f4").tobytes(), "none of 60 points is finite"),
        (np.full((6000, 4), np.nan, "<f4").tobytes(), "none of 6000 points is finite"),
    ],
)
def test_files_of_other_formats_are_named(data: bytes, message: str) -> None:
    with pytest.raises(KittiFormatError, match=f"^a.bin: {message}"):
        points_from_bytes(data, "a.bin")


def is_kitti(rows: NDArray[np.generic]) -> bool:
    return layout_of(rows.astype("<f4").tobytes(), "a.bin") == Layout("<f4", 4)


@pytest.mark.parametrize("scale", [1.0, 255.0])
def test_four_numbers_stay_four(scale: float) -> None:
    rows = yard(scale)
    for number in (0, 1, 2, 5, 15, 30, 60, 120, 240, 600, 2400, 12000, len(rows)):
        assert is_kitti(rows[:number]) and is_kitti(rows[::-1][:number]), number
    padded = np.concatenate([rows[:1000], np.zeros((20_000, 4)), rows[1000:]])
    assert is_kitti(padded) and is_kitti(in_order(padded, "shuffled"))
    for odd in (np.zeros((600, 4)), rows * [1, 1, 1, 0], rows * [1, 1, 1, 0] - [0, 0, 0, 1]):
        assert is_kitti(odd)
        np.testing.assert_array_equal(read(odd.astype("<f4"))[0], odd.astype(np.float32))


@real_kitti.needs_kitti
def test_no_scan_of_kittis_is_taken_for_another() -> None:
    for path in sorted((real_kitti.ROOT / "training" / "velodyne").glob("*.bin")):
        rows = np.fromfile(path, "<f4").reshape(-1, 4)
        for part in (rows, rows[:60], rows[-600:], rows[: len(rows) // 60 * 60]):
            assert is_kitti(part), path
            points_velo, kinds = read(part)
            assert not kinds and points_velo.tobytes() == part.tobytes()


def test_too_few_points_are_four_numbers_unless_the_name_says_five() -> None:
    rows = np.array([[3.0, 1.0, 0.25, 7.0, 4.0]] * 4)
    points_velo, kinds = read(rows.astype("<f4"), "LIDAR_TOP/1.pcd.bin")
    np.testing.assert_array_equal(points_velo, rows[:, :4])
    assert kinds == ["scan-columns"]
    assert read(rows.astype("<f4"))[0].shape == (5, 4)


def test_points_that_are_not_finite_are_left_out_and_said(tmp_path: Path) -> None:
    frame = make_frame()
    write_frame(tmp_path, 0, frame)
    path = tmp_path / "training" / "velodyne" / "000000.bin"
    rows = frame.points_velo.copy()
    rows[[3, 70]] = np.nan
    rows[5, 1] = np.inf
    rows[9] = 0.0
    path.write_bytes(rows.tobytes())
    with pytest.warns(match=f"000000.bin: 3 of {len(rows)} points are not finite and left out"):
        found = read_frame(tmp_path, 0)
    np.testing.assert_array_equal(found.points_velo, np.delete(rows, [3, 5, 70], axis=0))
    findings = [(f.rule, f.message) for f in lint(tmp_path, strict=False) if f.file == "velodyne/000000.bin"]
    assert findings == [
        ("dialect", f"3 of {len(rows)} points are not finite and left out"),
        ("scan", "1 points at the origin: no returns? Leave them out"),
    ]
