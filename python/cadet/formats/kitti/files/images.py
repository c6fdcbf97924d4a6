"""The image files of a KITTI folder: camera images, and depth, instances and classes in the encodings of this module.

depth: 16 bit, meters times 256 as in KITTI's depth benchmark, rounded; 0 is sky. Steps of 3.9 mm; what is farther than
255.996 m is written as that.
instance: 16 bit, id + 1, so 0 is sky (-1) and 1 the static world (0).
semantic: 8 bit, the values themselves.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.arrays import check_array
from cadet._util.image_file import MAX_PIXELS, DecodedImage, decode_file
from cadet.errors import CadetError, FileFormatError, KittiFormatError, ShapeError
from cadet.formats.kitti.files.dialects import accept

DEPTH_STEPS_PER_M: Final = 256.0
"""16-bit depth values a meter."""

_MAX_UINT16: Final = 65535
_NUM_COLORS: Final = 3
_NUM_RGBA: Final = 4
_OPAQUE: Final = 255
_FORMATS: Final = {"png": "PNG", "jpg": "JPEG", "jpeg": "JPEG", "webp": "WebP"}


def encode_png(image: NDArray[Any]) -> bytes:
    """Encode an image as a PNG file.

    Args:
        image: (H, W, 3) uint8 or uint16 RGB, (H, W, 4) uint8 RGB and opacity, (H, W) uint8 or (H, W) uint16.

    Raises:
        ShapeError: another shape or dtype, no pixels, or more than are read.
    """
    is_color = isinstance(image, np.ndarray) and image.ndim == _NUM_COLORS
    dtype = np.uint16 if getattr(image, "dtype", None) == np.uint16 else np.uint8
    if is_color:
        channels = 4 if image.shape[2] == _NUM_RGBA and dtype == np.uint8 else 3
        check_array(image, "image", ("H", "W", channels), dtype)
    else:
        check_array(image, "image", ("H", "W"), dtype)
    if image.size == 0:
        raise ShapeError(f"image: no pixels: {image.shape}")
    if image.shape[0] * image.shape[1] > MAX_PIXELS:
        raise ShapeError(f"image: {image.shape[1]} x {image.shape[0]} pixels, at most {MAX_PIXELS} are read again")
    return _cadet.encode_png(np.ascontiguousarray(image))


def decode_image(data: bytes, file: str = "image") -> NDArray[np.uint8]:
    """Decode a camera image: (H, W, 3) uint8 RGB.

    Read as dialects: gray, palettes, an opacity that is full everywhere, animations (the image that a program shows
    that knows none), and a format that the file's name does not say.

    Raises:
        KittiFormatError: no image, a damaged one, one that is transparent anywhere, or one of 16 bit.
    """
    picture = _decode(data, file)
    pixels = picture.pixels
    if pixels.dtype != np.uint8:
        raise KittiFormatError("16 bit a channel, expected 8: save it as RGB of 8 bit", file)
    if pixels.shape[2] in (2, _NUM_RGBA):
        if (pixels[..., -1] != _OPAQUE).any():
            raise KittiFormatError("some pixels are transparent: save it as RGB without opacity", file)
        accept("image-opacity", "RGBA whose opacity is 255 everywhere is read as RGB", file)
        pixels = pixels[..., :-1]
    if pixels.shape[2] == 1:
        accept("image-gray", "a gray image is read as RGB of three equal channels", file)
        pixels = pixels.repeat(_NUM_COLORS, axis=2)
    if picture.is_palette:
        accept("image-palette", "the colors of a palette are read as RGB", file)
    if picture.is_animation:
        accept("image-animation", f"of an animated {picture.format}, the first image is read", file)
    if picture.format != _FORMATS.get(file.rpartition(".")[2].lower(), picture.format):
        accept("image-format", f"is {picture.format}, whatever its name says", file)
    return np.ascontiguousarray(pixels)


def decode_map(data: bytes, file: str, dtype: type[np.generic]) -> NDArray[Any]:
    """Decode a one-channel PNG of exactly this dtype: (H, W). Channels that are all equal are read as one.

    Raises:
        KittiFormatError: no image, channels that differ, or another bit depth.
    """
    pixels = _decode(data, file).pixels
    first = np.ascontiguousarray(pixels[..., 0])
    if pixels.dtype != dtype or not (pixels == first[..., None]).all():
        shape = pixels.shape if pixels.shape[2] > 1 else first.shape
        wanted = np.dtype(dtype).name
        raise KittiFormatError(f"expected one channel of {wanted}, got {shape} {pixels.dtype.name}", file)
    if pixels.shape[2] > 1:
        accept("map-channels", "a map of equal channels is read as one of them", file)
    return first


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


def _decode(data: bytes, file: str) -> DecodedImage:
    try:
        return decode_file(data, file)
    except FileFormatError as error:
        raise KittiFormatError(error.reason, file) from None
