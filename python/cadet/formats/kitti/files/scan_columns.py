"""How many numbers a point has in a scan without a header: told from the numbers themselves.

Of the right count, each column holds numbers of one kind; of a wrong one, every column holds all kinds. So the count is
the one whose columns tell most about the values (the mutual information of both).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.errors import KittiFormatError

_COUNTS: Final = {3: "three", 4: "four", 5: "five", 6: "six", 7: "seven", 8: "eight", 12: "twelve", 16: "sixteen"}
_HEADERS: Final = {
    b"# .PCD": "PCD",
    b"VERSION": "PCD",
    b"ply\n": "PLY",
    b"ply\r\n": "PLY",
    b"\x93NUMPY": ".npy",
    b"LASF": "LAS",
    b"PK\x03\x04": "ZIP or .npz",
    b"#ROSBAG": "ROS bag",
    b"\xd4\xc3\xb2\xa1": "pcap",
    b"\x0a\x0d\x0d\x0a": "pcapng",
}
_READABLE: Final = ("PCD", "PLY", ".npy")
_TEXT: Final = bytes(range(32, 127)) + b"\t\r\n"
_TEXT_SAMPLE: Final = 512
_NUMBERS_IN_TEXT: Final = re.compile(rb"\s*[+-]?\d[\d.eE+-]*(?:[\s,;]+[+-]?\d[\d.eE+-]*){2}")
_NUSCENES: Final = ".pcd.bin"
"""Files of five numbers a point, of which too few points do not tell."""
_BLOCK: Final = 1680
"""Numbers: a whole number of points for each count."""
_BLOCKS: Final = 10
_BINS: Final = 8
_AS_GOOD: Final = 0.95
_CLEAR: Final = 60.0
"""By so much the statistic of likelihoods exceeds what columns of one kind give."""
_LEAST: Final = 1e-6
_MOST: Final = 1e5
"""Sizes of numbers other than 0 that meters and intensities have."""
_SENSIBLE: Final = 0.9
_HALF: Final = 0.6
"""Times since 1970, in a column of their own, are no meters."""
_MOST_KNOWN: Final = 6
"""Numbers a point: with more, the fourth is often the filling of a program's own structure."""
_FEWEST: Final = 64
"""Numbers: fewer may look like double precision by chance."""
_ENOUGH: Final = 4000
_MOST_RINGS: Final = 512
_FEW_VALUES: Final = 64


@dataclass(frozen=True)
class Layout:
    """What the numbers of a scan's file are.

    Attributes:
        dtype: of each number, "<f4" or "<f8".
        count: numbers a point: x, y, z, intensity, and others.
        ring: the column of the lasers' numbers; None where none is known.
    """

    dtype: str
    count: int
    ring: int | None = None

    def rows(self, data: bytes) -> NDArray[Any]:
        """Return the numbers (N, count) of a file of this layout."""
        return np.frombuffer(data, self.dtype).reshape(-1, self.count)

    def __str__(self) -> str:
        kind = " of 8 bytes" if self.dtype == "<f8" else ""
        return f"{_COUNTS[self.count]} numbers{kind} a point"


def layout_of(data: bytes, file: str) -> Layout:
    """Tell the layout of a scan.

    Args:
        data: the file's bytes.
        file: its name for messages.

    Raises:
        KittiFormatError: the file is cut off inside a point, is of another format, or its points are not known to be
            x, y, z, intensity and what lasers' numbers and times are.
    """
    header = _header_of(data)
    if header is not None:
        remedy = "`cadet.formats.scan_files.read_scan` reads it" if header in _READABLE else "convert it"
        raise KittiFormatError(f"a {header} file, expected float32 x y z intensity without a header: {remedy}", file)
    single, double = _sample(data, "<f4"), _sample(data, "<f8")
    shares = _share(single), _share(double)
    is_double = shares[0] < min(_SENSIBLE, shares[1]) and shares[1] >= _HALF and len(double) >= _FEWEST
    dtype, values = ("<f8", double) if is_double else ("<f4", single)
    count = count_of(values)
    layout = Layout(dtype, count or (5 if file.endswith(_NUSCENES) else 4))
    size = layout.count * np.dtype(dtype).itemsize
    if len(data) % size:
        kind = "" if layout == Layout("<f4", 4) else f" of {str(layout).removesuffix(' a point')}"
        rest = f"{len(data)} bytes are {len(data) // size} points{kind} and {len(data) % size} bytes"
        raise KittiFormatError(f"truncated: {rest}: copy the file again", file)
    rows = layout.rows(data)
    reason = _objection(layout, rows) if count is not None or len(values) >= _ENOUGH else None
    if count is None and len(values) >= _ENOUGH and (np.isfinite(values) & (values != 0.0)).mean() > 0.5:
        reason = reason or "all columns are alike: is it written column by column? Expected x y z intensity, row by row"
    if reason is not None:
        raise KittiFormatError(reason, file)
    return Layout(dtype, layout.count, ring_column(rows))


def _objection(layout: Layout, rows: NDArray[Any]) -> str | None:
    """Return why rows are not x, y, z, intensity and what is known; None where they are."""
    if len(rows) == 0:
        return None
    if float(_is_sensible(rows[:, :3]).mean()) < _SENSIBLE:
        return "its numbers are not meters from the sensor: expected x y z intensity in float32"
    if layout.count == 3:
        return f"{layout}? expected x y z intensity: add an intensity of 0"
    intensity = np.abs(rows[:, 3])
    if 0.0 < float(intensity[np.isfinite(intensity)].max(initial=0.0)) < _LEAST:
        return "its intensities are not float32: expected x y z intensity in float32"
    if layout.count > _MOST_KNOWN or (layout.count > 4 and not _is_known(rows)):
        first = f'np.fromfile(file, "{layout.dtype}").reshape(-1, {layout.count})[:, :4]'
        return f"{layout}? expected x y z intensity in float32: keep these four, as in {first}"
    return None


def _header_of(data: bytes) -> str | None:
    """Return the name of the format whose header a file has; None for none."""
    known = next((name for start, name in _HEADERS.items() if data.startswith(start)), None)
    return "text" if known is None and _is_text(data[:_TEXT_SAMPLE]) else known


def _is_text(data: bytes) -> bool:
    """Tell whether bytes are lines of numbers: letters alone may be four bytes of a number, too."""
    if data.translate(None, _TEXT):
        return False
    return any(_NUMBERS_IN_TEXT.match(line) for line in data.splitlines())


def ring_column(rows: NDArray[Any]) -> int | None:
    """Return which column of x, y, z, intensity and others holds the lasers' numbers; None where none does."""
    return 4 if rows.shape[1] > 4 and _is_ring(rows[:, 4]) else None


def _sample(data: bytes, dtype: str) -> NDArray[Any]:
    """Return the file's numbers, or those of blocks of it, each from the start of a point on."""
    whole = len(data) // np.dtype(dtype).itemsize
    values = np.frombuffer(data, dtype, whole)
    blocks = whole // _BLOCK
    if blocks <= _BLOCKS:
        return values
    starts = np.linspace(0, blocks - 1, _BLOCKS).astype(np.intp) * _BLOCK
    return np.concatenate([values[start : start + _BLOCK] for start in starts])


def _is_sensible(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Tell which numbers may be meters or intensities; what is not finite is a missing one."""
    size = np.abs(values)
    sensible: NDArray[np.bool_] = (size == 0.0) | ((size >= _LEAST) & (size <= _MOST)) | ~np.isfinite(values)
    return sensible


def _share(values: NDArray[Any]) -> float:
    return float(_is_sensible(values).mean()) if len(values) else 0.0


def count_of(values: NDArray[Any]) -> int | None:
    """Return the count of numbers a point that shows best in a scan's numbers (N,); None where none shows."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return None
    edges = np.unique(np.quantile(finite, np.arange(1, _BINS) / _BINS))
    with np.errstate(invalid="ignore"):
        kinds = np.searchsorted(edges, values)
    excess = np.array([_excess(kinds, count, len(edges) + 1) for count in _COUNTS])
    if excess.max() < _CLEAR:
        return None
    return list(_COUNTS)[int(np.argmax(excess >= _AS_GOOD * excess.max()))]


def _excess(kinds: NDArray[np.intp], count: int, num_kinds: int) -> float:
    """Return by how much columns' kinds differ: the likelihoods' ratio, less what chance gives."""
    column = np.arange(len(kinds)) % count
    table = np.bincount(column * num_kinds + kinds, minlength=count * num_kinds).reshape(count, num_kinds)
    expected = table.sum(axis=1, keepdims=True) * table.sum(axis=0) / len(kinds)
    filled = table > 0
    ratio = 2.0 * float((table[filled] * np.log(table[filled] / expected[filled])).sum())
    return ratio - (count - 1) * (num_kinds - 1)


def _is_known(rows: NDArray[Any]) -> bool:
    """Tell whether columns after an intensity that is not negative hold rings, times or classes, not colors."""
    some = rows[np.isfinite(rows).all(axis=1)]
    if len(some) == 0 or some[:, 3].min() < 0.0:
        return False
    rest = some[:, 4:]
    if rest.shape[1] >= 2 and all(_is_color(some[:, column]) for column in (3, 4, 5)):
        return False
    return any(_is_ring(column) or _is_time(column) for column in rest.T)


def _is_ring(column: NDArray[Any]) -> bool:
    values = np.unique(column[np.isfinite(column)])
    return 1 < len(values) <= _MOST_RINGS and bool(
        (values == np.floor(values)).all() and values[0] >= 0.0 and values[-1] < _MOST_RINGS
    )


def _is_time(column: NDArray[Any]) -> bool:
    """Tell whether values only rise, or are few."""
    return bool((np.diff(column) >= 0.0).all()) or len(np.unique(column)) <= min(_FEW_VALUES, len(column) // 8)


def _is_color(column: NDArray[Any]) -> bool:
    return bool((column == np.floor(column)).all() and column.min() >= 0.0 and 127.0 < column.max() <= 255.0)
