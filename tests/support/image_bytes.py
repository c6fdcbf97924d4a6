"""Image files made byte by byte, with no library that this project decodes by."""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

PNG_START = b"\x89PNG\r\n\x1a\n"
GRAY, RGB, PALETTE, GRAY_ALPHA, RGBA = 0, 2, 3, 4, 6
"""PNG's kinds of color."""

CMYK_JPEG = base64.b64decode(
    "/9j/7gAOQWRvYmUAZAAAAAAA/9sAQwAQCwwODAoQDg0OEhEQExgoGhgWFhgxIyUdKDozPTw5Mzg3QEhcTkBEV0U3OFBtUVdfYmdoZz5NcXlwZHhc"
    "ZWdj/8AAFAgACAAIBEMRAE0RAFkRAEsRAP/EABYAAQEBAAAAAAAAAAAAAAAAAAYFB//EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAOBEMATQBZAEsA"
    "AD8ASCaY0B//2Q=="
)
"""8 x 8 of (200, 40, 90) as Adobe writes CMYK, by Pillow."""
RGB_JPEG = base64.b64decode(
    "/9j/7gAOQWRvYmUAZAAAAAAA/9sAQwAQCwwODAoQDg0OEhEQExgoGhgWFhgxIyUdKDozPTw5Mzg3QEhcTkBEV0U3OFBtUVdfYmdoZz5NcXlwZHhc"
    "ZWdj/8AAEQgACAAIA1IRAEcRAEIRAP/EABUAAQEAAAAAAAAAAAAAAAAAAAYF/8QAFBABAAAAAAAAAAAAAAAAAAAAAP/aAAwDUgBHAEIAAD8ASCaY"
    "/9k="
)
"""The same, its channels stored as RGB, by Pillow."""
ANIMATED_WEBP = base64.b64decode(
    "UklGRogAAABXRUJQVlA4WAoAAAACAAAABwAABwAAQU5JTQYAAAAAAAAAAABBTk1GKgAAAAAAAAAAAAcAAAcAAAAAAAJWUDhMEQAAAC8HwAEAB1CU"
    "Iler/4GI6H8AAEFOTUYqAAAAAAAAAAAABwAABwAAAAAAAFZQOEwRAAAALwfAAQAHUPhSVKv/gYjofwAA"
)
"""8 x 8, of (200, 40, 90) and then another color, by Pillow."""
COLOR_OF_PILLOW = (200, 40, 90)


def chunk(name: bytes, data: bytes, length: int | None = None) -> bytes:
    """Return a chunk of a PNG file, of a stated length that may be wrong."""
    stated = len(data) if length is None else length
    return struct.pack(">I", stated) + name + data + struct.pack(">I", zlib.crc32(name + data))


def header(width: int, height: int, depth: int = 8, color: int = RGB) -> bytes:
    """Return a PNG's first chunk."""
    return chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, color, 0, 0, 0))


def packed(pixels: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """Compress rows of samples, each without a filter."""
    rows = pixels.astype(pixels.dtype.newbyteorder(">")).reshape(len(pixels), -1)
    return zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows))


def png(
    pixels: NDArray[np.uint8] | NDArray[np.uint16], color: int, *, before: Iterable[bytes] = (), after: bytes = b""
) -> bytes:
    """Return a PNG file of (H, W, C) samples, with more chunks before and after its pixels."""
    first = header(pixels.shape[1], pixels.shape[0], 8 * pixels.itemsize, color)
    return b"".join([PNG_START, first, *before, chunk(b"IDAT", packed(pixels)), after, chunk(b"IEND", b"")])


def interlaced(pixels: NDArray[np.uint8]) -> bytes:
    """Return a PNG file of (H, W, 3) RGB samples in Adam7's seven passes."""
    steps = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
    passes = [pixels[top::down, left::right] for left, top, right, down in steps]
    rows = b"".join(b"\0" + row.tobytes() for part in passes if part.size for row in part)
    first = chunk(b"IHDR", struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, RGB, 0, 0, 1))
    return PNG_START + first + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def frame_control(number: int, width: int, height: int) -> bytes:
    """Return the chunk that leads a frame of an animated PNG."""
    return chunk(b"fcTL", struct.pack(">IIIIIHHBB", number, width, height, 0, 0, 1, 10, 0, 0))


def animation(first: NDArray[np.uint8], second: NDArray[np.uint8]) -> bytes:
    """Return an animated PNG of two RGB images of one size."""
    height, width = first.shape[:2]
    control = chunk(b"acTL", struct.pack(">II", 2, 0))
    later = frame_control(1, width, height) + chunk(b"fdAT", struct.pack(">I", 2) + packed(second))
    return png(first, RGB, before=(control, frame_control(0, width, height)), after=later)


def png_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield names and contents of a PNG file's chunks, as far as they can be told."""
    at = len(PNG_START)
    while at + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        yield data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        at += 12 + length
