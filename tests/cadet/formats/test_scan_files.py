"""Scans as PCD, PLY, .npy and .bin, written here from the formats' definitions; and what is damaged, refused."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet import CadetError, MissingFileError
from cadet.formats.kitti.files import dialects
from cadet.formats.scan_files import RecordedScan, read_scan
from cadet.formats.scan_files.read import scan_from_data
from scans.scan_writers import npy, pcd, ply

Columns = dict[str, NDArray[np.generic]]
N = 300


def columns() -> Columns:
    """Return an OS1's columns as its driver orders them."""
    rng = np.random.default_rng(0)
    return {
        "x": rng.normal(0, 10, N).astype("<f4"),
        "y": rng.normal(0, 10, N).astype("<f4"),
        "z": rng.normal(0, 1, N).astype("<f4"),
        "intensity": rng.integers(0, 256, N).astype("<f4"),
        "t": np.arange(N, dtype="<u4") * 1000,
        "reflectivity": rng.integers(0, 256, N).astype("<u2"),
        "ring": (np.arange(N) % 64).astype("<u1"),
        "range": rng.integers(0, 9000, N).astype("<u4"),
    }


def of_type(kind: str, **types: str) -> Columns:
    return {name: column.astype(types.get(name, kind or column.dtype.str)) for name, column in columns().items()}


def structured() -> NDArray[np.generic]:
    given = columns()
    array = np.zeros(N, [(name, column.dtype) for name, column in given.items()])
    for name, column in given.items():
        array[name] = column
    return array


WRITERS: dict[str, Callable[[], bytes]] = {
    "PCD of text": lambda: pcd(columns(), "ascii"),
    "PCD": lambda: pcd(columns(), "binary"),
    "PCD compressed": lambda: pcd(columns(), "binary_compressed"),
    "PCD with padding": lambda: pcd(columns(), "binary", padding=True),
    "PCD without a comment": lambda: pcd(columns(), "binary", version=""),
    "PCD of CRLF": lambda: pcd(columns(), "ascii").replace(b"\n", b"\r\n"),
    "PCD of doubles": lambda: pcd(of_type("<f8"), "binary_compressed"),
    "PCD turned around": lambda: pcd(dict(reversed(columns().items())), "binary"),
    "PCD whose header is filled up": lambda: pcd(columns(), "binary").replace(b"binary\n", b"binary\n     "),
    "PLY of text": lambda: ply(columns(), "ascii"),
    "PLY of little-endian": lambda: ply(columns(), "binary_little_endian"),
    "PLY of big-endian": lambda: ply(columns(), "binary_big_endian"),
    "PLY of CRLF": lambda: ply(columns(), "binary_little_endian", newline="\r\n"),
    "PLY by CloudCompare": lambda: ply(of_type("<f4"), "binary_little_endian", prefix="scalar_"),
    "PLY with more before": lambda: ply(columns(), "binary_big_endian", before=True),
    "PLY text with more before": lambda: ply(columns(), "ascii", before=True),
    ".npy of fields": lambda: npy(structured()),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_every_format_gives_the_same_scan(kind: str, tmp_path: Path) -> None:
    (tmp_path / "scan.any").write_bytes(WRITERS[kind]())
    scan = read_scan(tmp_path / "scan.any")
    given = columns()
    rows = np.column_stack([given[name] for name in ("x", "y", "z", "intensity")])
    np.testing.assert_array_equal(scan.points_velo, rows.astype(np.float32))
    assert scan.ring is not None and scan.time is not None
    np.testing.assert_array_equal(scan.ring, given["ring"])
    np.testing.assert_array_equal(scan.time, given["t"])
    assert scan.num_left_out == 0


def test_rows_that_stand_for_no_return_are_left_out_of_all_columns() -> None:
    given = columns()
    given["x"][[0, 7]], given["z"][9] = np.nan, np.inf
    left = np.delete(np.arange(N), [0, 7, 9])
    for data in (pcd(given, "binary"), pcd(given, "ascii"), ply(given, "ascii")):
        scan = scan_from_data(data, "a")
        assert scan.num_left_out == 3 and scan.ring is not None and scan.time is not None
        np.testing.assert_array_equal(scan.points_velo[:, 0], given["x"][left])
        np.testing.assert_array_equal(scan.ring, given["ring"][left])
        np.testing.assert_array_equal(scan.time, given["t"][left])


HESAI = (  # name, type, count in the header, offset in the driver's structure
    *(("x", "<f4", 1, 0), ("y", "<f4", 1, 4), ("z", "<f4", 1, 8), ("_", "<u1", 4, 12), ("intensity", "<f4", 1, 16)),
    *(("_", "<u1", 0, 0), ("timestamp", "<f8", 1, 24), ("_", "<u1", 6, 0), ("ring", "<u2", 1, 32), ("_", "<u1", 12, 0)),
)
OUSTER = (
    *(("x", "<f4", 1, 0), ("y", "<f4", 1, 4), ("z", "<f4", 1, 8), ("_", "<u1", 4, 12), ("intensity", "<f4", 1, 16)),
    *(("t", "<u4", 1, 20), ("reflectivity", "<u2", 1, 24), ("ring", "<u1", 1, 26), ("_", "<u1", 0, 0)),
    *(("noise", "<u2", 1, 28), ("_", "<u1", 0, 0), ("range", "<u4", 1, 32), ("_", "<u1", 15, 0)),
)


@pytest.mark.parametrize("fields", [HESAI, OUSTER], ids=["Hesai", "Ouster"])
def test_headers_whose_fillings_count_0_are_read_as_the_driver_aligns_fields(
    fields: tuple[tuple[str, str, int, int], ...],
) -> None:
    """Headers of public files (SUSTechPOINTS' Pandar40, PDAL's issue 3254): their gaps are not where they say."""
    given = {**columns(), "timestamp": columns()["t"], "noise": columns()["range"]}
    real = [(name, kind, offset) for name, kind, _, offset in fields if name != "_"]
    names, kinds, offsets = (list(part) for part in zip(*real, strict=True))
    record = np.zeros(N, np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": 48}))
    for name in names:
        record[name] = given[name]
    words = [(name, kind[2], {"f": "F", "u": "U"}[kind[1]], str(count)) for name, kind, count, _ in fields]
    lines = zip(("FIELDS", "SIZE", "TYPE", "COUNT"), zip(*words, strict=True), strict=True)
    head = "VERSION 0.7\n" + "".join(f"{key} {' '.join(line)}\n" for key, line in lines) + f"POINTS {N}\nDATA binary\n"
    scan = scan_from_data(head.encode() + record.tobytes(), "a.pcd")
    assert scan.ring is not None and scan.time is not None
    np.testing.assert_array_equal(scan.points_velo[:, 3], given["intensity"])
    np.testing.assert_array_equal(scan.ring, given["ring"])
    np.testing.assert_array_equal(scan.time, given["t"])


def test_arrays_and_bare_files_have_a_ring_in_their_fifth_column() -> None:
    given = columns()
    rows = np.column_stack([given[name] for name in ("x", "y", "z", "intensity", "ring")]).astype("<f4")
    for data in (npy(rows), npy(rows.astype(np.float64)), npy(np.asfortranarray(rows)), rows.tobytes()):
        scan = scan_from_data(data, "a.bin")
        np.testing.assert_array_equal(scan.points_velo, rows[:, :4])
        np.testing.assert_array_equal(scan.ring, given["ring"])
    assert scan_from_data(rows[:, :4].tobytes(), "a.bin").ring is None


def test_without_an_intensity_it_is_0_and_said() -> None:
    given = {name: column for name, column in columns().items() if name in "xyz"}
    with dialects.collected() as found:
        scan = scan_from_data(pcd(given, "binary"), "a.pcd")
    assert isinstance(scan, RecordedScan) and not scan.points_velo[:, 3].any() and scan.ring is None
    assert [str(dialect) for dialect in found] == ["a.pcd: no intensity, read as 0"]


def edited(data: bytes, old: str, new: str) -> bytes:
    assert old.encode() in data
    return data.replace(old.encode(), new.encode())


BINARY, ASCII, SQUEEZED = (pcd(columns(), kind) for kind in ("binary", "ascii", "binary_compressed"))
LITTLE, TEXT = ply(columns(), "binary_little_endian"), ply(columns(), "ascii")
DAMAGED: dict[str, tuple[bytes, str]] = {
    "no DATA": (b"# .PCD v0.7\nFIELDS x y z\n", "no DATA line"),
    "no fields": (edited(BINARY, "FIELDS x y z", "FIELDS x y"), "do not name as many fields"),
    "an odd size": (edited(BINARY, "SIZE 4", "SIZE 3"), "field 'x': expected F of 4 or 8 bytes"),
    "a letter for a size": (edited(BINARY, "SIZE 4", "SIZE four"), "field 'x'"),
    "an odd type": (edited(BINARY, "TYPE F", "TYPE Q"), "field 'x'"),
    "an endless count": (edited(BINARY, "COUNT 1", "COUNT " + "9" * 400), "field 'x': expected a COUNT"),
    "endless points": (edited(BINARY, f"POINTS {N}", "POINTS " + "9" * 400), "no number of POINTS"),
    "too many points": (edited(BINARY, f"POINTS {N}", "POINTS 99999999999"), "at most 2147483648"),
    "more points than there are": (edited(BINARY, f"POINTS {N}", "POINTS 999999999"), "truncated: .*copy the file"),
    "fewer lines": (edited(ASCII, f"POINTS {N}", "POINTS 999999999"), f"truncated: {N} points, the header says"),
    "half a file": (BINARY[: len(BINARY) // 2], "truncated"),
    "half a compressed file": (SQUEEZED[: len(SQUEEZED) // 2], "truncated"),
    "an unknown kind": (edited(BINARY, "DATA binary", "DATA zipped"), "11: DATA: expected ascii, binary"),
    "a word among numbers": (ASCII.rstrip() + b"x", rf"{11 + N}: expected numbers only"),
    "a short line": (ASCII.rstrip().rsplit(b" ", 1)[0], rf"{11 + N}: expected 8 numbers, got 7"),
    "no x": (edited(BINARY, "FIELDS x", "FIELDS q"), "no field x of one number, .*; it has q, y"),
    "x twice": (edited(BINARY, "FIELDS x y", "FIELDS x x"), "no field x of one number"),
    "no end of the header": (LITTLE[:60], "no end_header"),
    "no vertices": (edited(LITTLE, "element vertex", "element point"), "no element vertex"),
    "an unknown type": (edited(LITTLE, "property float x", "property half x"), "6: not of the format: 'property half"),
    "an unknown order": (edited(LITTLE, "binary_little_endian", "binary_middle"), "2: not of the format"),
    "no format": (edited(LITTLE, "format binary_little_endian 1.0\n", ""), "its header has no format"),
    "endless vertices": (edited(LITTLE, f"vertex {N}", "vertex " + "9" * 400), "5: not of the format"),
    "more vertices than there are": (edited(LITTLE, f"vertex {N}", "vertex 99999999999"), "truncated"),
    "vertices with lists": (edited(LITTLE, "property float x", "property list uchar int x"), "vertices with lists"),
    "half a text": (TEXT[: len(TEXT) // 2].rsplit(b"\n", 1)[0], "truncated"),
    ".npy of three": (npy(np.zeros((9, 3))), r"expected numbers \(N, 4\) .*\(9, 3\)"),
    ".npy of objects": (
        b"\x93NUMPY\x01\x00v\x00{'descr': '|O', 'fortran_order': False, 'shape': (9, 4), }\n",
        "cannot be read as an array",
    ),
    "half an array": (npy(np.zeros((900, 4)))[:-999], "cannot be read as an array"),
    "a header alone": (b"\x93NUMPY\x01\x00", "cannot be read as an array"),
}


@pytest.mark.parametrize("kind", DAMAGED)
def test_damage_is_named_in_one_line(kind: str) -> None:
    data, message = DAMAGED[kind]
    with pytest.raises(CadetError, match=rf"^a\.any:.*{message}") as caught:
        scan_from_data(data, "a.any")
    assert "\n" not in str(caught.value)


def test_damaged_compression_is_refused() -> None:
    start = SQUEEZED.index(b"compressed\n") + len(b"compressed\n")
    sizes = struct.unpack("<II", SQUEEZED[start : start + 8])
    for size in (sizes[1] - 1, sizes[1] + 1, 2**32 - 1):
        damaged = SQUEEZED[:start] + struct.pack("<II", sizes[0], size) + SQUEEZED[start + 8 :]
        with pytest.raises(CadetError, match=r"^a\.pcd: its compressed data are damaged: copy the file again$"):
            scan_from_data(damaged, "a.pcd")
    reference_before_the_start = SQUEEZED[: start + 8] + b"\xe0" + SQUEEZED[start + 9 :]
    with pytest.raises(CadetError, match="its compressed data are damaged"):
        scan_from_data(reference_before_the_start, "a.pcd")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"no\.pcd: no such file"):
        read_scan(tmp_path / "no.pcd")
