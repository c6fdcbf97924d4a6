"""Pictures that color a mesh: decoded, and averaged over the part that a triangle shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import shown
from cadet._util.image_file import decode_file
from cadet.errors import FileFormatError

_BYTES: Final = np.arange(256) / 255.0
# IEC 61966-2-1.
LINEAR_FROM_BYTE: Final = np.where(_BYTES <= 0.04045, _BYTES / 12.92, ((_BYTES + 0.055) / 1.055) ** 2.4)
"""(256,) the linear value of each byte of an sRGB picture."""
_OTHER_KINDS: Final = {b"\xabKTX": "KTX", b"DDS ": "DDS", b"8BPS": "PSD", b"gimp": "XCF"}
REPEAT, CLAMP, MIRROR = "repeat", "clamp", "mirror"
# The middles of the 16 small triangles that a triangle falls into, as weights of its corners.
_UP: Final = [(i + 1 / 3, j + 1 / 3) for i in range(4) for j in range(4 - i)]
_DOWN: Final = [(i + 2 / 3, j + 2 / 3) for i in range(3) for j in range(3 - i)]
_SAMPLES: Final = np.array([(1 - (i + j) / 4, i / 4, j / 4) for i, j in _UP + _DOWN])
# Triangles that are sampled at once.
_CHUNK: Final = 1 << 16


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture that is wrapped around a mesh."""

    texels: NDArray[np.uint8]
    """(height, width, 4) red, green, blue as sRGB has them, and alpha; the first row is the top."""

    def mean(self) -> NDArray[np.float64]:
        """Return the mean of all of it, (4,) linear red, green, blue, and alpha; what is transparent counts less."""
        flat = self.texels.reshape(-1, 4)
        weights = flat[:, 3].astype(np.float64) + 1e-6
        of_bytes = [np.bincount(flat[:, channel], weights, 256) for channel in range(3)]
        alpha = (weights.sum() - 1e-6 * len(weights)) / len(weights) / 255.0
        return np.array([*((counts * LINEAR_FROM_BYTE).sum() / weights.sum() for counts in of_bytes), alpha])

    def over(self, uv: NDArray[np.float64], wraps: tuple[str, str]) -> NDArray[np.float64]:
        """Average the picture over triangles, each at 16 places; what is transparent counts less.

        Args:
            uv: (n, 3, 2) the corners' places in the picture, from (0, 0) at its upper left to (1, 1).
            wraps: what lies to the left and right of it, and above and below.

        Returns:
            (n, 4) linear red, green, blue, and alpha.
        """
        height, width = self.texels.shape[:2]
        means = np.empty((len(uv), 4))
        for first in range(0, len(uv), _CHUNK):
            part = uv[first : first + _CHUNK]
            places = [
                sum(_SAMPLES[None, :, corner] * part[:, corner, None, axis] for corner in range(3)) for axis in (0, 1)
            ]
            column, row = (
                _wrapped(np.asarray(place), wrap, size)
                for place, wrap, size in zip(places, wraps, (width, height), strict=True)
            )
            texels = self.texels[row, column]
            weights = texels[..., 3:].astype(np.float64) + 1e-6
            means[first : first + _CHUNK, :3] = (LINEAR_FROM_BYTE[texels[..., :3]] * weights).sum(1) / weights.sum(1)
            means[first : first + _CHUNK, 3] = texels[..., 3].mean(1) / 255.0
        return means


def _wrapped(place: NDArray[np.float64], wrap: str, size: int) -> NDArray[np.int64]:
    with np.errstate(invalid="ignore"):
        if wrap == REPEAT:
            place = place - np.floor(place)
        elif wrap == MIRROR:
            place = 1.0 - np.abs(1.0 - (place - 2.0 * np.floor(place / 2.0)))
        inside = np.clip(np.nan_to_num(place), 0.0, 1.0)
    return np.minimum((inside * size).astype(np.int64), size - 1)


def picture_from_bytes(data: bytes | None) -> Picture | str:
    """Decode a picture; where it can't be, say why in a few words. None is a file that is not there."""
    if data is None:
        return "not there"
    if data[:4] in _OTHER_KINDS:
        return _OTHER_KINDS[data[:4]]
    try:
        pixels = decode_file(data, "").pixels
    except FileFormatError as error:
        return error.reason
    if pixels.dtype == np.uint16:
        pixels = (pixels // 256).astype(np.uint8)
    texels = np.full((*pixels.shape[:2], 4), 255, np.uint8)
    num_colors = 3 if pixels.shape[2] >= 3 else 1
    texels[..., :3] = pixels[..., :num_colors]
    if pixels.shape[2] > num_colors:
        texels[..., 3] = pixels[..., num_colors]
    return Picture(texels)


def note_of_unread(file: str, unread: Mapping[str, str], instead: str) -> list[str]:
    """Say in one line which pictures of a mesh are not read, and what its materials have instead."""
    if not unread:
        return []
    shown_ones = [f"{shown(name)} ({why})" for name, why in list(unread.items())[:4]]
    more = f", and {len(unread) - 4} more" if len(unread) > 4 else ""
    remedy = "put them beside the mesh as PNG or JPEG"
    return [f"{file}: pictures that are not read: {', '.join(shown_ones)}{more}: {instead}; {remedy}"]
