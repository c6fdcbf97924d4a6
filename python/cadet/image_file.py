"""Image files of others: PNG, JPEG and WebP pass one gate, by their headers, before they are decoded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from numpy.typing import NDArray

from cadet import _cadet
from cadet.errors import FileFormatError

MAX_PIXELS: Final = 1 << 26
"""The most pixels of an image that is read: 8192 x 8192."""


@dataclass(frozen=True, eq=False)
class Picture:
    """What an image file holds, as stored: no orientation, gamma or color profile is applied.

    Attributes:
        pixels: (H, W, C) uint8 or uint16; C is 1 for gray, 2 for gray and opacity, 3 for RGB, 4 for RGB and opacity.
        format: "PNG", "JPEG" or "WebP".
        is_palette: the file holds numbers of colors, which have become RGB.
        is_animation: of its images, this is the one that programs show that know no animations.
    """

    pixels: NDArray[Any]
    format: str
    is_palette: bool
    is_animation: bool


def decode_file(data: bytes, file: str) -> Picture:
    """Decode an image file.

    Args:
        data: of the file.
        file: its name, for messages.

    Raises:
        FileFormatError: another format, a damaged or cut file, or more than `MAX_PIXELS`.
    """
    try:
        return Picture(*_cadet.decode_image(data, MAX_PIXELS))
    except FileFormatError as error:
        raise FileFormatError(error.reason, file) from None
