"""Image files of others pass one gate, by their headers, before they are decoded.

PNG, JPEG and WebP are the core's to decode; BMP and PNM, which color meshes, OpenCV's.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet.errors import FileFormatError

MAX_PIXELS: Final = 1 << 26
"""The most pixels of an image that is read: 8192 x 8192."""

_PNM: Final = re.compile(rb"P[2356]\s(?:\s|#[^\n]{0,200}\n){0,20}(\d{1,9})\s(?:\s|#[^\n]{0,200}\n){0,20}(\d{1,9})\s")
_BMP_HEADER: Final = 26


@dataclass(frozen=True, eq=False)
class DecodedImage:
    """What an image file holds, as stored: no orientation, gamma or color profile is applied.

    Attributes:
        pixels: (H, W, C) uint8 or uint16; C is 1 for gray, 2 for gray and opacity, 3 for RGB, 4 for RGB and opacity.
        format: "PNG", "JPEG", "WebP", "BMP" or "PNM".
        is_palette: the file holds numbers of colors, which have become RGB.
        is_animation: of its images, this is the one that programs show that know no animations.
    """

    pixels: NDArray[Any]
    format: str
    is_palette: bool
    is_animation: bool


def decode_file(data: bytes, file: str) -> DecodedImage:
    """Decode an image file.

    Args:
        data: of the file.
        file: its name, for messages.

    Raises:
        FileFormatError: another format, a damaged or cut file, or more than `MAX_PIXELS`.
    """
    if (size := _simple_size(data)) is not None:
        return _decode_simple(data, size, file)
    try:
        return DecodedImage(*_cadet.decode_image(data, MAX_PIXELS))
    except FileFormatError as error:
        raise FileFormatError(error.reason, file) from None


def _simple_size(data: bytes) -> tuple[int, int] | None:
    """Return width and height of a BMP or PNM file by its header; None of another format."""
    if data.startswith(b"BM") and len(data) >= _BMP_HEADER:
        width, height = struct.unpack_from("<ii", data, 18)
        return abs(width), abs(height)
    found = _PNM.match(data)
    return None if found is None else (int(found[1]), int(found[2]))


def _decode_simple(data: bytes, size: tuple[int, int], file: str) -> DecodedImage:
    width, height = size
    if width * height > MAX_PIXELS:
        raise FileFormatError(f"{width} x {height} pixels, at most {MAX_PIXELS} are read; scale it down", file)
    # A sixth of the time of `import cadet`, for formats that few files have.
    import cv2

    name = "BMP" if data.startswith(b"BM") else "PNM"
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise FileFormatError(f"damaged {name} image: {error.err}; save it as PNG", file) from None
    if pixels is None:
        raise FileFormatError(f"damaged {name} image; save it as PNG", file)
    return DecodedImage(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), name, is_palette=False, is_animation=False)
