"""A file's points as named columns, from its bytes or its text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet.errors import FileFormatError

Columns = Mapping[str, NDArray[Any]]
"""Arrays (N,) by name; a name that occurs again, or has several numbers a point, is not there."""


def columns_of_records(data: bytes, fields: Sequence[tuple[str, str, int]], num_points: int, file: str) -> Columns:
    """Read points that stand one after the other in binary.

    Args:
        data: the bytes, from the first point on; what follows the last one is not read.
        fields: name, NumPy's type and count of numbers of each field.
        num_points: how many there should be.
        file: its name for messages.

    Raises:
        FileFormatError: there are fewer bytes.
    """
    # The names may be equal or empty, as those of padding are.
    record = np.dtype([(f"f{index}", kind, (count,)) for index, (_, kind, count) in enumerate(fields)])
    needed = num_points * record.itemsize
    check_size(len(data), needed, num_points, file)
    # Some writers fill a header up with blanks.
    excess = len(data) - needed
    start = excess if data[:excess].isspace() else 0
    rows = np.frombuffer(data, record, num_points, start)
    return _named({index: rows[f"f{index}"] for index in range(len(fields))}, fields)


def columns_of_arrays(data: bytes, fields: Sequence[tuple[str, str, int]], num_points: int, file: str) -> Columns:
    """Read fields that stand one after the other, each of all points: as `columns_of_records`."""
    arrays, start = {}, 0
    check_size(len(data), num_points * sum(np.dtype(k).itemsize * n for _, k, n in fields), num_points, file)
    for index, (_, kind, count) in enumerate(fields):
        arrays[index] = np.frombuffer(data, kind, num_points * count, start).reshape(num_points, count)
        start += arrays[index].nbytes
    return _named(arrays, fields)


def columns_of_text(
    data: bytes, fields: Sequence[tuple[str, str, int]], num_points: int, file: str, line: int
) -> Columns:
    """Read points of one line each.

    Args:
        data: the text, from the first point on.
        fields: as of `columns_of_records`.
        num_points: how many there should be.
        file: its name for messages.
        line: number of the first point's line.

    Raises:
        FileFormatError: a line with other than numbers, or with more or fewer; or too few lines.
    """
    width = sum(count for _, _, count in fields)
    rows = np.empty((min(num_points, len(data)), width))
    found = 0
    for number, content in enumerate(data.split(b"\n"), start=line):
        if found == num_points:
            break
        texts = content.split()
        if not texts:
            continue
        if len(texts) != width:
            raise FileFormatError(f"expected {width} numbers, got {len(texts)}", file, number)
        try:
            # Old C libraries on Windows write 1.#QNAN and 1.#INF.
            rows[found] = [np.nan if b"#" in text else float(text) for text in texts]
        except ValueError:
            raise FileFormatError("expected numbers only", file, number) from None
        found += 1
    if found < num_points:
        raise FileFormatError(f"truncated: {found} points, the header says {num_points}: copy the file again", file)
    ends = np.cumsum([count for _, _, count in fields])
    return _named({i: rows[:, end - fields[i][2] : end] for i, end in enumerate(ends)}, fields)


def check_size(num_bytes: int, needed: int, num_points: int, file: str) -> None:
    """Refuse data that ends early.

    Raises:
        FileFormatError: naming both sizes.
    """
    if num_bytes < needed:
        reason = f"truncated: {num_bytes} bytes, its header's {num_points} points take {needed}: copy the file again"
        raise FileFormatError(reason, file)


def _named(arrays: Mapping[int, NDArray[Any]], fields: Sequence[tuple[str, str, int]]) -> Columns:
    names = [name.lower().removeprefix("scalar_") for name, _, _ in fields]
    return {
        name: arrays[index][:, 0]
        for index, name in enumerate(names)
        if fields[index][2] == 1 and names.count(name) == 1
    }
