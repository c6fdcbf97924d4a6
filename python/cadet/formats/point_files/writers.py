"""Named columns of points to a file's bytes: a function of the columns alone."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import npy_from_array
from cadet.formats.point_files.las import bytes_of_las

Columns = Mapping[str, NDArray[Any]]
"""Arrays (N,) by the fields' names."""

_PLY_TYPES: Final = {"f4": "float", "i4": "int"}
_PCD_TYPES: Final = {"f4": "F", "u2": "U"}


def columns_of_points(
    points_velo: NDArray[np.float32], ring: NDArray[Any] | None = None, time_s: NDArray[Any] | None = None
) -> Columns:
    """Return a scan's columns by the names that PCL, Open3D, and ROS's drivers of Velodyne's LIDARs know.

    Args:
        points_velo: (N, 4) [x, y, z, intensity], meters in the velo frame.
        ring: (N,) numbers of the lasers; None leaves the column out.
        time_s: (N,) seconds from the scan's instant; None leaves the column out.

    Returns:
        x, y, z, intensity, time float32, and ring uint16, each (N,).
    """
    columns = {name: points_velo[:, index].astype("<f4") for index, name in enumerate(("x", "y", "z", "intensity"))}
    if ring is not None:
        columns["ring"] = ring.astype("<u2")
    if time_s is not None:
        columns["time"] = time_s.astype("<f4")
    return columns


def _bytes_of_ply(columns: Columns) -> bytes:
    """Return a binary polygon file of vertices alone (Stanford's PLY)."""
    number = len(columns["x"])
    # Open3D passes over whole numbers of 16 bits.
    columns = {name: column if column.dtype == "<f4" else column.astype("<i4") for name, column in columns.items()}
    properties = [f"property {_PLY_TYPES[column.dtype.str[1:]]} {name}" for name, column in columns.items()]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {number}", *properties, "end_header"]
    return _lines(lines) + _records(columns)


def _bytes_of_pcd(columns: Columns) -> bytes:
    """Return a binary file of the Point Cloud Library (its page "The PCD file format", version 0.7)."""
    number = len(columns["x"])
    lines = [
        "# .PCD v0.7 - Point Cloud Data file format",
        "VERSION 0.7",
        f"FIELDS {' '.join(columns)}",
        f"SIZE {' '.join(str(column.dtype.itemsize) for column in columns.values())}",
        f"TYPE {' '.join(_PCD_TYPES[column.dtype.str[1:]] for column in columns.values())}",
        f"COUNT {' '.join('1' for _ in columns)}",
        f"WIDTH {number}",
        "HEIGHT 1",
        "VIEWPOINT 0 0 0 1 0 0 0",
        f"POINTS {number}",
        "DATA binary",
    ]
    return _lines(lines) + _records(columns)


def _bytes_of_npz(columns: Columns) -> bytes:
    """Return a file of NumPy's with an array for each column."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, column in columns.items():
            # Not NumPy's savez: an information of its own bears no time.
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), npy_from_array(column))
    return file.getvalue()


def _lines(lines: list[str]) -> bytes:
    return "".join(f"{line}\n" for line in lines).encode("ascii")


def _records(columns: Columns) -> bytes:
    rows = np.empty(len(columns["x"]), [(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        rows[name] = column
    return rows.tobytes()


POINT_FILES: Final[Mapping[str, Callable[[Columns], bytes]]] = {
    "ply": _bytes_of_ply,
    "pcd": _bytes_of_pcd,
    "las": bytes_of_las,
    "npz": _bytes_of_npz,
}
"""What encodes `columns_of_points`, by the files' suffix."""
