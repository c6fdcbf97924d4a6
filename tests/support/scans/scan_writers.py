"""Scans as PCD, PLY and .npy, written from the formats' definitions."""

from __future__ import annotations

import io
import struct
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Columns = dict[str, NDArray[np.generic]]
PCD = {"f": "F", "i": "I", "u": "U"}
PLY = {"f4": "float", "f8": "double", "u1": "uchar", "u2": "ushort", "u4": "uint", "i4": "int"}


def packed(data: bytes) -> bytes:
    """Compress by LZF: a reference where the next three bytes were seen before, else runs of single bytes."""
    seen: dict[bytes, int] = {}
    out, at, run = bytearray(), 0, bytearray()

    def flush() -> None:
        for start in range(0, len(run), 32):
            part = run[start : start + 32]
            out.extend(bytes([len(part) - 1]) + part)
        run.clear()

    while at < len(data):
        key = data[at : at + 3]
        before, seen[key] = seen.get(key, -1), at
        offset = at - before - 1
        if before < 0 or offset >= 8192 or len(key) < 3:
            run.append(data[at])
            at += 1
            continue
        length = 3
        while length < 264 and at + length < len(data) and data[before + length] == data[at + length]:
            length += 1
        flush()
        short = min(length - 2, 7)
        out.append(short << 5 | offset >> 8)
        out.extend([length - 9] if short == 7 else [])
        out.append(offset & 255)
        at += length
    flush()
    return bytes(out)


def text_of(given: Columns) -> bytes:
    rows = zip(*(column.tolist() for column in given.values()), strict=True)
    return "\n".join(" ".join(map(repr, row)) for row in rows).encode()


def pcd(given: Columns, kind: str, *, padding: bool = False, version: str = "# .PCD v0.7 - Point Cloud\n") -> bytes:
    names, sizes, kinds, counts = [], [], [], []
    parts = dict(given)
    for name, column in parts.items():
        names.append(name)
        sizes.append(str(column.dtype.itemsize))
        kinds.append(PCD[column.dtype.kind])
        counts.append("1")
        if padding and name in ("z", "range"):
            names.append("_")
            sizes.append("1")
            kinds.append("U")
            counts.append("4" if name == "z" else "0")
    number = len(next(iter(given.values())))
    head = f"{version}VERSION 0.7\nFIELDS {' '.join(names)}\nSIZE {' '.join(sizes)}\nTYPE {' '.join(kinds)}\n"
    head += (
        f"COUNT {' '.join(counts)}\nWIDTH {number}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {number}\nDATA {kind}\n"
    )
    if kind == "ascii":
        body = text_of(given) + b"\n"
    elif kind == "binary":
        record = [(f"{i}", c.dtype, (1,)) for i, c in enumerate(given.values())]
        if padding:
            record.insert(3, ("_", np.dtype("u1"), (4,)))
        rows = np.zeros(number, record)
        for i, column in enumerate(given.values()):
            rows[f"{i}"] = column[:, None]
        body = rows.tobytes()
    else:
        plain = b"".join(column.tobytes() for column in given.values())
        squeezed = packed(plain) if kind == "binary_compressed" else plain
        body = struct.pack("<II", len(squeezed), len(plain)) + squeezed
    return head.encode() + body


def ply(given: Columns, kind: str, *, newline: str = "\n", prefix: str = "", before: bool = False) -> bytes:
    orders: dict[str, Literal["<", ">"]] = {"binary_little_endian": "<", "binary_big_endian": ">"}
    order = orders.get(kind)
    lines = ["ply", f"format {kind} 1.0", "comment by hand", "obj_info none"]
    lines += ["element camera 2", "property int view"] if before else []
    number = len(next(iter(given.values())))
    lines.append(f"element vertex {number}")
    lines += [f"property {PLY[c.dtype.str[1:]]} {prefix if n not in 'xyz' else ''}{n}" for n, c in given.items()]
    lines += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    head = "".join(line + newline for line in lines).encode()
    if order is None:
        return head + (b"7\n8\n" if before else b"") + text_of(given) + b"\n3 0 1 2\n"
    record = np.zeros(number, [(n, c.dtype.newbyteorder(order)) for n, c in given.items()])
    for name, column in given.items():
        record[name] = column
    return head + (bytes(8) if before else b"") + record.tobytes() + b"\3" + bytes(12)


def npy(array: NDArray[np.generic]) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()
