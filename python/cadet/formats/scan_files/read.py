"""One scan from a file of any of the formats: points, and the lasers' numbers and times where it has them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import array_from_npy
from cadet._util.user_files import read_file
from cadet.errors import FileFormatError
from cadet.formats.kitti.files.dialects import accept
from cadet.formats.kitti.files.scan_columns import layout_of, ring_column
from cadet.formats.kitti.files.velodyne import is_whole_point
from cadet.formats.scan_files.pcd import columns_from_pcd
from cadet.formats.scan_files.ply import columns_from_ply
from cadet.formats.scan_files.table import Columns

SUFFIXES: Final = (".bin", ".pcd", ".ply", ".npy")
_NAMES: Final[Mapping[str, tuple[str, ...]]] = {
    "intensity": ("intensity", "i", "reflectivity", "reflectance", "remission"),
    "ring": ("ring", "channel", "laser_id", "laserid", "laser_number", "line", "row"),
    "time": ("t", "time", "timestamp", "time_stamp", "offset_time", "ts"),
}
"""What drivers call the columns; the first that a file has is meant."""
_MOST_RING: Final = 1 << 16


class RecordedScan(NamedTuple):
    """A scan and what its file says beyond KITTI's columns."""

    points_velo: NDArray[np.float32]
    """(N, 4): x, y, z in meters, intensity as the file has it, 0 where it has none. All finite."""
    ring: NDArray[np.int64] | None
    """(N,): numbers of the lasers, in whatever order."""
    time: NDArray[np.float64] | None
    """(N,): times of the points, in whatever unit."""
    num_left_out: int
    """Points that are not finite, which stand for no return."""


def read_scan(path: str | Path) -> RecordedScan:
    """Read a scan: PCD, PLY, NumPy's .npy, or float32 without a header. The content tells which, not the suffix.

    Raises:
        MissingFileError: there is no such file.
        CadetError: a file that is damaged or of another format, in one line with its name.
    """
    path = Path(path)
    return scan_from_data(read_file(path), path.name)


def scan_from_data(data: bytes, file: str) -> RecordedScan:
    """Read a scan's bytes; `file` names it in messages: as `read_scan`."""
    # What is too large to be converted is not finite then, and left out.
    with np.errstate(all="ignore"):
        return _read(data, file)


def _read(data: bytes, file: str) -> RecordedScan:
    readers: Mapping[bytes, Callable[[bytes, str], Columns]] = {
        b"# .PCD": columns_from_pcd,
        b"VERSION": columns_from_pcd,
        b"ply\n": columns_from_ply,
        b"ply\r\n": columns_from_ply,
    }
    if data.startswith(b"\x93NUMPY"):
        rows = array_from_npy(data, file)
        if rows.dtype.names is not None:
            return _of_columns({name.lower(): rows[name].reshape(-1) for name in rows.dtype.names}, file)
        if rows.ndim != 2 or rows.shape[1] < 4 or rows.dtype.kind not in "fiu":
            raise FileFormatError(f"expected numbers (N, 4) of x y z intensity, got {rows.shape} {rows.dtype}", file)
        return _of_rows(rows, ring_column(rows))
    reader = next((reader for start, reader in readers.items() if data.startswith(start)), None)
    if reader is not None:
        return _of_columns(reader(data, file), file)
    layout = layout_of(data, file)
    return _of_rows(layout.rows(data), layout.ring)


def _of_rows(rows: NDArray[Any], ring: int | None) -> RecordedScan:
    return _whole_points(rows[:, :4], None if ring is None else rows[:, ring], None)


def _of_columns(columns: Columns, file: str) -> RecordedScan:
    missing = [name for name in "xyz" if name not in columns or columns[name].dtype.kind not in "fiu"]
    if missing:
        known = ", ".join(columns) or "none"
        raise FileFormatError(f"no field {missing[0]} of one number, expected x, y, z, intensity; it has {known}", file)
    found = {
        kind: next((columns[name] for name in names if name in columns and columns[name].dtype.kind in "fiu"), None)
        for kind, names in _NAMES.items()
    }
    intensity = found["intensity"]
    if intensity is None:
        accept("scan-no-intensity", "no intensity, read as 0", file)
    xyz = [columns[name].astype(np.float64) for name in "xyz"]
    if len({len(column) for column in xyz}) != 1:
        raise FileFormatError("its columns differ in length", file)
    rows = np.column_stack([*xyz, np.zeros(len(xyz[0])) if intensity is None else intensity.astype(np.float64)])
    return _whole_points(rows, found["ring"], found["time"])


def _whole_points(rows: NDArray[Any], ring: NDArray[Any] | None, time: NDArray[Any] | None) -> RecordedScan:
    """Leave out rows that stand for no return, and columns that tell nothing."""
    whole = is_whole_point(rows)
    points_velo = np.ascontiguousarray(rows[whole], np.float32)
    return RecordedScan(points_velo, _ring(ring, whole), _time(time, whole), int((~whole).sum()))


def _ring(column: NDArray[Any] | None, whole: NDArray[np.bool_]) -> NDArray[np.int64] | None:
    if column is None:
        return None
    values = column[whole].astype(np.float64)
    is_ring = np.isfinite(values).all() and bool((np.abs(values) < _MOST_RING).all())
    return values.astype(np.int64) if is_ring and len(np.unique(values)) > 1 else None


def _time(column: NDArray[Any] | None, whole: NDArray[np.bool_]) -> NDArray[np.float64] | None:
    if column is None:
        return None
    values = column[whole].astype(np.float64)
    return values if np.isfinite(values).all() and len(np.unique(values)) > 1 else None
