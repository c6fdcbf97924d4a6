"""The Point Cloud Library's files: ascii, binary and binary_compressed (its page "The PCD file format")."""

from __future__ import annotations

from typing import Final

import numpy as np

from cadet.errors import FileFormatError
from cadet.formats.scan_files.table import Columns, check_size, columns_of_arrays, columns_of_records, columns_of_text

_LONGEST_HEADER: Final = 1 << 16
_MOST_FIELDS: Final = 1024
_MOST_COUNT: Final = 1 << 16
_MOST_POINTS: Final = 1 << 31
_KINDS: Final = {"F": "f", "I": "i", "U": "u"}
_SIZES: Final = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
_FILLING: Final = "_"
_SIZES_BYTES: Final = 8
_BEST_RATIO: Final = 100
"""LZF makes at most 264 bytes of three."""

Field = tuple[str, str, int]


def columns_from_pcd(data: bytes, file: str) -> Columns:
    """Read the fields of a PCD file.

    Raises:
        FileFormatError: a header or data that are not of the format, with the line where it is known.
    """
    header, body, line = _header(data, file)
    fields = _fields(header, file)
    num_points = _num_points(header, file)
    kind = header["DATA"][0].lower() if header["DATA"] else ""
    if kind == "ascii":
        return columns_of_text(body, fields, num_points, file, line)
    if kind == "binary":
        return columns_of_records(body, _aligned(fields), num_points, file)
    if kind == "binary_compressed":
        return columns_of_arrays(_unpacked(body, file), fields, num_points, file)
    raise FileFormatError(f"DATA: expected ascii, binary or binary_compressed, got {kind[:40]!r}", file, line - 1)


def _header(data: bytes, file: str) -> tuple[dict[str, list[str]], bytes, int]:
    """Return the header's words by key, the data behind it, and the number of their first line."""
    header: dict[str, list[str]] = {}
    start, line = 0, 1
    while "DATA" not in header:
        end = data.find(b"\n", start, _LONGEST_HEADER)
        if end < 0:
            raise FileFormatError("no DATA line in its header: is this a PCD file?", file)
        words = data[start:end].decode("latin-1").split()
        if words and not words[0].startswith("#"):
            header[words[0].upper()] = words[1:]
        start, line = end + 1, line + 1
    return header, data[start:], line


def _fields(header: dict[str, list[str]], file: str) -> list[Field]:
    names = header.get("FIELDS", header.get("COLUMNS", []))
    sizes, kinds = header.get("SIZE", []), header.get("TYPE", [])
    counts = header.get("COUNT") or ["1"] * len(names)
    if not 0 < len(names) == len(sizes) == len(kinds) == len(counts) <= _MOST_FIELDS:
        raise FileFormatError("its header's FIELDS, SIZE, TYPE and COUNT do not name as many fields each", file)
    fields = []
    for name, size, kind, count in zip(names, sizes, kinds, counts, strict=True):
        kind = kind.upper()
        if kind not in _KINDS or not size.isdecimal() or int(size[:4]) not in _SIZES[kind]:
            known = "F of 4 or 8 bytes, I or U of 1 to 8"
            raise FileFormatError(f"field {name[:40]!r}: expected {known}, got {kind[:10]} of {size[:10]}", file)
        # Padding may count 0.
        if not count.isdecimal() or int(count[:9]) > _MOST_COUNT:
            reason = f"expected a COUNT of at most {_MOST_COUNT}, got {count[:10]!r}"
            raise FileFormatError(f"field {name[:40]!r}: {reason}", file)
        fields.append((name, f"<{_KINDS[kind]}{int(size)}", int(count)))
    return fields


def _aligned(fields: list[Field]) -> list[Field]:
    """Return the fields where they are: a filling that counts 0 stands for a gap of which the header is wrong.

    So drivers of Hesai and Ouster write them by way of ROS: gaps behind it are where C aligns fields, and as long
    together as the header says.
    """
    first = next((index for index, (name, _, count) in enumerate(fields) if name == _FILLING and count == 0), None)
    if first is None:
        return fields
    sizes = [np.dtype(kind).itemsize for _, kind, _ in fields]
    whole = sum(size * count for size, (_, _, count) in zip(sizes, fields, strict=True))
    start = sum(size * count for size, (_, _, count) in zip(sizes[:first], fields[:first], strict=True))
    found = fields[:first]
    for size, (name, kind, count) in zip(sizes[first:], fields[first:], strict=True):
        if name != _FILLING:
            found += [(_FILLING, "<u1", -start % size), (name, kind, count)]
            start += -start % size + size * count
    return [*found, (_FILLING, "<u1", whole - start)] if start <= whole else fields


def _num_points(header: dict[str, list[str]], file: str) -> int:
    texts = header.get("POINTS") or [*header.get("WIDTH", []), *header.get("HEIGHT", ["1"])]
    if not texts or not all(text.isdecimal() and len(text) < 12 for text in texts):
        raise FileFormatError("its header has no number of POINTS", file)
    number = 1
    for text in texts:
        number *= int(text)
    if number > _MOST_POINTS:
        raise FileFormatError(f"its header says {number} points, at most {_MOST_POINTS} are read", file)
    return number


def _unpacked(data: bytes, file: str) -> bytes:
    """Decompress LZF: runs of bytes, and references to what was written before."""
    packed_size, size = (int.from_bytes(data[at : at + 4], "little") for at in (0, 4))
    check_size(len(data), _SIZES_BYTES + packed_size, 0, file)
    if size > _BEST_RATIO * packed_size:
        raise FileFormatError("its compressed data are damaged: copy the file again", file)
    if packed_size == size:
        # Writers whose compression would gain nothing.
        return data[_SIZES_BYTES : _SIZES_BYTES + size]
    packed, out, at = data[_SIZES_BYTES : _SIZES_BYTES + packed_size], bytearray(), 0
    try:
        while at < packed_size:
            control = packed[at]
            at += 1
            if control < 32:
                out += packed[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += packed[at]
                at += 1
            start = len(out) - ((control & 31) << 8) - packed[at] - 1
            at += 1
            length += 2
            if start < 0 or len(out) > size:
                raise IndexError
            piece = out[start : start + length]
            # A reference may reach into what it writes.
            out += (piece * (length // len(piece) + 1))[:length]
    except IndexError:
        raise FileFormatError("its compressed data are damaged: copy the file again", file) from None
    if len(out) != size:
        raise FileFormatError("its compressed data are damaged: copy the file again", file)
    return bytes(out)
