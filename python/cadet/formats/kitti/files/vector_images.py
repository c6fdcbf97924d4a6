"""Maps of vectors in a KITTI folder, as PNG files of 16-bit RGB.

optical_flow: as in KITTI's flow benchmark: 64 u + 32768, 64 v + 32768, and 1 where the flow is known, else three zeros.
Steps of 1/64 pixel; a flow beyond -512..511.98 pixels counts as unknown.
normals: 32767 times each component, plus 32768; the sky's is the null vector.
scene_flow: 256 times each component in m/s, plus 32768: steps of 4 mm/s, up to 127.99 m/s.
radiance: 4096 times red, green, and blue in shares of the image's white, up to 15.99.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import check_array
from cadet._util.image_file import decode_file
from cadet.errors import FileFormatError, KittiFormatError
from cadet.formats.kitti.files.images import encode_png

_MIDDLE: Final = 32768
_LARGEST: Final = 65535
_FLOW_STEPS_PER_PX: Final = 64.0
_VALUES: Final = {"normals": (32767.0, _MIDDLE), "scene_flow": (256.0, _MIDDLE), "radiance": (4096.0, 0)}
"""Values a unit of the maps of three components, and the value of 0."""
_NUM_CHANNELS: Final = 3


def bytes_from_flow(optical_flow: NDArray[np.float32]) -> bytes:
    """Encode optical flow in pixels, NaN where it is unknown, as KITTI does.

    Raises:
        ShapeError: not (H, W, 2) float32.
    """
    check_array(optical_flow, "optical_flow", ("H", "W", 2), np.float32)
    is_known: NDArray[np.bool_] = np.all(np.isfinite(optical_flow), axis=2)
    steps = np.rint(np.where(is_known[..., None], optical_flow, 0.0) * _FLOW_STEPS_PER_PX) + _MIDDLE
    is_known &= np.all((steps >= 0.0) & (steps <= _LARGEST), axis=2)
    pixels = np.zeros((*is_known.shape, _NUM_CHANNELS), np.uint16)
    pixels[is_known, :2] = steps[is_known]
    pixels[is_known, 2] = 1
    return encode_png(pixels)


def flow_from_bytes(data: bytes, file: str) -> NDArray[np.float32]:
    """Decode optical flow: (H, W, 2) float32 in pixels, NaN where it is unknown.

    Raises:
        KittiFormatError: no image, or not 16-bit RGB.
    """
    pixels = _decode(data, file)
    flow = (pixels[..., :2].astype(np.float32) - np.float32(_MIDDLE)) / np.float32(_FLOW_STEPS_PER_PX)
    flow[pixels[..., 2] == 0] = np.nan
    return flow


def bytes_from_vectors(vectors: NDArray[np.float32], kind: str) -> bytes:
    """Encode a map of three components, such as normals; what is beyond the largest value is written as that.

    Raises:
        ShapeError: not (H, W, 3) float32.
        NonFiniteError: NaN or infinity.
    """
    check_array(vectors, kind, ("H", "W", 3), np.float32, finite=True)
    steps, zero = _VALUES[kind]
    return encode_png(np.clip(np.rint(vectors * np.float32(steps)) + zero, 0, _LARGEST).astype(np.uint16))


def vectors_from_bytes(data: bytes, file: str, kind: str) -> NDArray[np.float32]:
    """Decode a map of three components, such as normals: (H, W, 3) float32.

    Raises:
        KittiFormatError: no image, or not 16-bit RGB.
    """
    steps, zero = _VALUES[kind]
    return (_decode(data, file).astype(np.float32) - np.float32(zero)) / np.float32(steps)


def _decode(data: bytes, file: str) -> NDArray[Any]:
    try:
        pixels = decode_file(data, file).pixels
    except FileFormatError as error:
        raise KittiFormatError(error.reason, file) from None
    if pixels.dtype != np.uint16 or pixels.shape[2] != _NUM_CHANNELS:
        raise KittiFormatError(f"expected RGB of uint16, got {pixels.shape} {pixels.dtype.name}", file)
    return pixels
