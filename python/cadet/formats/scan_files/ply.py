"""Polygon files (Stanford): the vertices, in ascii or in binary of either order of bytes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from cadet.errors import FileFormatError
from cadet.formats.scan_files.table import Columns, check_size, columns_of_records, columns_of_text

_LONGEST_HEADER: Final = 1 << 16
_TYPES: Final = {
    name: kind
    for kind, names in {
        "i1": ("char", "int8"),
        "u1": ("uchar", "uint8"),
        "i2": ("short", "int16"),
        "u2": ("ushort", "uint16"),
        "i4": ("int", "int32"),
        "u4": ("uint", "uint32"),
        "f4": ("float", "float32"),
        "f8": ("double", "float64"),
    }.items()
    for name in names
}
_ORDERS: Final = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass
class _Element:
    name: str
    number: int
    fields: list[tuple[str, str, int]] = field(default_factory=list)
    has_list: bool = False

    def size(self) -> int:
        """Return the bytes that all of them take in binary."""
        return self.number * sum(np.dtype(kind).itemsize for _, kind, _ in self.fields)


def columns_from_ply(data: bytes, file: str) -> Columns:
    """Read the properties of a PLY file's vertices.

    Raises:
        FileFormatError: a header or data that are not of the format, with the line where it is known.
    """
    order, elements, body, line = _header(data, file)
    names = [element.name for element in elements]
    if names.count("vertex") != 1:
        raise FileFormatError("its header has no element vertex", file)
    before, vertex = elements[: names.index("vertex")], elements[names.index("vertex")]
    if vertex.has_list or any(element.has_list and order for element in before):
        raise FileFormatError("vertices with lists, or lists before them: write x, y, z and intensity alone", file)
    if order:
        start = sum(element.size() for element in before)
        check_size(len(body), start, 0, file)
        return columns_of_records(body[start:], vertex.fields, vertex.number, file)
    skipped = sum(element.number for element in before)
    lines = body.split(b"\n", skipped) if skipped <= len(body) else []
    check_size(len(lines), skipped + 1, skipped, file)
    return columns_of_text(lines[-1], vertex.fields, vertex.number, file, line + skipped)


def _header(data: bytes, file: str) -> tuple[str, list[_Element], bytes, int]:
    """Return the order of bytes (empty for ascii), the elements, the data, and the number of their first line."""
    order: str | None = None
    elements: list[_Element] = []
    start, line = 0, 0
    while True:
        end = data.find(b"\n", start, _LONGEST_HEADER)
        if end < 0:
            raise FileFormatError("no end_header in it: is this a PLY file with lines that end in a line feed?", file)
        words = data[start:end].decode("latin-1").split()
        start, line = end + 1, line + 1
        match words:
            case ["end_header"]:
                break
            case ["format", kind, *_] if kind in _ORDERS:
                order = _ORDERS[kind]
            case ["element", name, number] if number.isdecimal() and len(number) < 12:
                elements.append(_Element(name, int(number)))
            case ["property", "list", _, _, _] if elements:
                elements[-1].has_list = True
            case ["property", kind, name] if elements and kind in _TYPES:
                elements[-1].fields.append((name, kind, 1))
            case ["format" | "element" | "property", *_]:
                raise FileFormatError(f"not of the format: {' '.join(words)[:60]!r}", file, line)
    if order is None:
        raise FileFormatError("its header has no format", file)
    for element in elements:
        element.fields = [(name, (order or "<") + _TYPES[kind], count) for name, kind, count in element.fields]
    return order, elements, data[start:], line + 1
