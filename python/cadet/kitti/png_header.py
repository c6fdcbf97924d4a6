"""The header of a PNG file, checked before a decoder allocates memory for the image."""

from __future__ import annotations

import struct
from typing import Final

from cadet.errors import KittiFormatError

MAX_PIXELS: Final = 1 << 25
"""The most pixels of an image that is read: 8192 x 4096."""

_PNG_START: Final = b"\x89PNG\r\n\x1a\n"
_FRAME: Final = 12
"""Bytes of a chunk besides its data: length, name and checksum."""


def check_png(data: bytes, file: str) -> None:
    """Refuse what is no PNG file, is cut off, or has more than `MAX_PIXELS`.

    Every chunk must lie in the file with the length that it states: decoders allocate what is stated.

    Raises:
        KittiFormatError: naming the file and the reason.
    """
    if not data.startswith(_PNG_START):
        raise KittiFormatError(f"no PNG image ({len(data)} bytes)", file)
    at, name = len(_PNG_START), b""
    while name != b"IEND":
        if at + _FRAME > len(data):
            raise KittiFormatError(f"truncated PNG image ({len(data)} bytes)", file)
        length, name = struct.unpack_from(">I4s", data, at)
        if at + _FRAME + length > len(data):
            raise KittiFormatError(f"truncated PNG image ({len(data)} bytes)", file)
        # Frames of an animation have sizes of their own, at the fifth byte.
        offset = {b"IHDR": 0, b"fcTL": 4}.get(name)
        if offset is not None and length >= offset + 8:
            width, height = struct.unpack_from(">II", data, at + 8 + offset)
            if width * height > MAX_PIXELS:
                raise KittiFormatError(f"{width} x {height} pixels, at most {MAX_PIXELS} are read", file)
        at += _FRAME + length
