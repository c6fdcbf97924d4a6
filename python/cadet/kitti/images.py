"""The PNG files of a KITTI folder: camera images, and depth, instances and classes in the encodings of this module.

depth: 16 bit, meters times 256 as in KITTI's depth benchmark, rounded; 0 is sky. Steps of 3.9 mm; what is farther than
255.996 m is written as that.
instance: 16 bit, id + 1, so 0 is sky (-1) and 1 the static world (0).
semantic: 8 bit, the values themselves.
"""

from __future__ import annotations

from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet.arrays import check_array
from cadet.errors import CadetError, KittiFormatError, ShapeError
from cadet.kitti.png_header import check_png

DEPTH_STEPS_PER_M: Final = 256.0
"""16-bit depth values a meter."""

_MAX_UINT16: Final = 65535
_NUM_COLORS: Final = 3


def encode_png(image: NDArray[Any]) -> bytes:
    """Encode an image as a PNG file.

    Args:
        image: (H, W, 3) uint8 RGB, (H, W) uint8 or (H, W) uint16.

    Raises:
        ShapeError: another shape or dtype, or no pixels.
    """
    is_color = isinstance(image, np.ndarray) and image.ndim == _NUM_COLORS
    if is_color:
        check_array(image, "image", ("H", "W", 3), np.uint8)
    else:
        check_array(image, "image", ("H", "W"), np.uint16 if getattr(image, "dtype", None) == np.uint16 else np.uint8)
    if image.size == 0:
        raise ShapeError(f"image: no pixels: {image.shape}")
    return _cadet.encode_png(np.ascontiguousarray(image))


def decode_image(data: bytes, file: str = "image") -> NDArray[np.uint8]:
    """Decode a camera image: (H, W, 3) uint8 RGB.

    Raises:
        KittiFormatError: no image, a damaged one, or not three channels of 8 bit.
    """
    image = _decode(data, file)
    if image.ndim != _NUM_COLORS or image.shape[2] != _NUM_COLORS or image.dtype != np.uint8:
        raise KittiFormatError(f"expected three channels of uint8, got {image.shape} {image.dtype.name}", file)
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)


def decode_map(data: bytes, file: str, dtype: type[np.generic]) -> NDArray[Any]:
    """Decode a one-channel PNG of exactly this dtype: (H, W).

    Raises:
        KittiFormatError: no image, more than one channel, or another bit depth.
    """
    image = _decode(data, file)
    if image.ndim != _NUM_COLORS - 1 or image.dtype != dtype:
        wanted = np.dtype(dtype).name
        raise KittiFormatError(f"expected one channel of {wanted}, got {image.shape} {image.dtype.name}", file)
    return image


def pixels_from_depth(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Encode depth in meters, inf for sky, as 16 bit.

    Raises:
        ShapeError: not (H, W) float32.
    """
    check_array(depth, "depth", ("H", "W"), np.float32)
    steps = np.rint(np.where(np.isfinite(depth), depth, 0.0) * DEPTH_STEPS_PER_M)
    is_hit = np.isfinite(depth)
    return np.where(is_hit, np.clip(steps, 1, _MAX_UINT16), 0).astype(np.uint16)


def depth_from_pixels(pixels: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Decode 16-bit depth to meters, inf for sky: (H, W) float32."""
    depth = pixels.astype(np.float32) / np.float32(DEPTH_STEPS_PER_M)
    depth[pixels == 0] = np.inf
    return depth


def pixels_from_instance(instance: NDArray[np.int32]) -> NDArray[np.uint16]:
    """Encode instance ids, -1 for sky, as 16 bit.

    Raises:
        ShapeError: not (H, W) int32.
        CadetError: an id outside -1..65534.
    """
    check_array(instance, "instance", ("H", "W"), np.int32)
    low, high = (int(instance.min()), int(instance.max())) if instance.size else (0, 0)
    if low < -1 or high >= _MAX_UINT16:
        raise CadetError(f"instance: expected ids -1..{_MAX_UINT16 - 1}, got {low}..{high}")
    return (instance + 1).astype(np.uint16)


def instance_from_pixels(pixels: NDArray[np.uint16]) -> NDArray[np.int32]:
    """Decode 16-bit instance ids: (H, W) int32, -1 for sky."""
    return pixels.astype(np.int32) - np.int32(1)


def _decode(data: bytes, file: str) -> NDArray[Any]:
    check_png(data, file)
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise KittiFormatError(f"damaged PNG image: {error.err}", file) from None
    if image is None:
        raise KittiFormatError(f"damaged PNG image ({len(data)} bytes)", file)
    return np.asarray(image)
