"""LAS 1.4 (ASPRS, "LAS Specification 1.4 - R15"): point format 6, and the laser's number as an extra dimension."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

_HEADER: Final = struct.Struct("<4sHH16sBB32s32sHHHIIBHI5I3d3d6dQQIQ15Q")
_VLR: Final = struct.Struct("<H16sHH32s")
_EXTRA: Final = struct.Struct("<2sBB32s4s24s24s24s24s24s32s")
_POINT: Final = np.dtype(
    [
        *((axis, "<i4") for axis in ("x", "y", "z")),
        *(("intensity", "<u2"), ("returns", "u1"), ("flags", "u1"), ("classification", "u1"), ("user_data", "u1")),
        *(("scan_angle", "<i2"), ("source", "<u2"), ("gps_time", "<f8")),
    ]
)
_STEPS_PER_M: Final = 1000
"""Coordinates of scans are whole millimeters."""
_ONE_OF_ONE: Final = 0x11
_UNCLASSIFIED: Final = 1
_WKT: Final = 1 << 4
"""Point formats from 6 on ask for it, though no coordinate system is named."""
_FULL_SCALE: Final = 65535
_UINT16: Final = 3
"""The number of the extra dimension's type."""


def bytes_of_las(columns: Mapping[str, NDArray[Any]]) -> bytes:
    """Return a LAS file.

    Args:
        columns: x, y, z, and intensity from 0 to 1 (others are kept as they are, cut at 65535), each (N,); where there
            are any, `ring`, which becomes an extra dimension of this name, and `time`, which becomes `gps_time`.
    """
    with_ring = "ring" in columns
    rows = np.zeros(len(columns["x"]), np.dtype([*_POINT.descr, *([("ring", "<u2")] if with_ring else [])]))
    for axis in "xyz":
        rows[axis] = np.rint(columns[axis].astype(np.float64) * _STEPS_PER_M)
    brightest = float(columns["intensity"].max(initial=0.0))
    intensity = columns["intensity"].astype(np.float64) * (_FULL_SCALE if brightest <= 1.0 else 1.0)
    rows["intensity"] = np.rint(np.clip(intensity, 0.0, _FULL_SCALE))
    rows["returns"] = _ONE_OF_ONE
    rows["classification"] = _UNCLASSIFIED
    if "time" in columns:
        rows["gps_time"] = columns["time"]
    if with_ring:
        rows["ring"] = columns["ring"]
    records = _extra_dimension(b"ring", b"number of the laser") if with_ring else b""
    return _header(rows, num_records=int(with_ring), offset=_HEADER.size + len(records)) + records + rows.tobytes()


def _header(rows: NDArray[Any], *, num_records: int, offset: int) -> bytes:
    number = len(rows)
    limits = [float(f(rows[axis])) / _STEPS_PER_M if number else 0.0 for axis in "xyz" for f in (np.max, np.min)]
    return _HEADER.pack(
        *(b"LASF", 0, _WKT, b"", 1, 4, b"simulated", b"cadet"),
        # No day: the same scan has the same bytes.
        *(0, 0, _HEADER.size, offset, num_records, 6, rows.dtype.itemsize),
        # Numbers of points where older versions had them.
        *(0, 0, 0, 0, 0, 0),
        *(1.0 / _STEPS_PER_M,) * 3,
        *(0.0,) * 3,
        *limits,
        *(0, 0, 0),
        *(number, number, *(0,) * 14),
    )


def _extra_dimension(name: bytes, description: bytes) -> bytes:
    """Return the record that describes a dimension of uint16."""
    empty = b""
    field = _EXTRA.pack(empty, _UINT16, 0, name, *(empty,) * 6, description)
    return _VLR.pack(0, b"LASF_Spec", 4, len(field), b"extra dimensions") + field
