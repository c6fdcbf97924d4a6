"""Camera images on their way to the network."""

from __future__ import annotations

import math
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

_JITTER_DEVIATION: Final = 0.1


def resize_bilinear(image: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.uint8]:
    """Resize an image by bilinear sampling at target * (source size / target size), the corner pixels' centers being 0.

    Rounded to whole gray levels: half a level at most, less than the camera's own noise, and a quarter of the memory.
    OpenCV 4 also rounds positions, to 1/32 of a pixel.

    Args:
        image: (H, W, 3).
        size: target width and height.

    Returns:
        (h, w, 3) uint8.

    Reference: tf.image.resize_bilinear of TensorFlow 1 with align_corners=False, that is without half-pixel centers,
    but for the rounding.
    """
    scale = np.array([[image.shape[1] / size[0], 0.0, 0.0], [0.0, image.shape[0] / size[1], 0.0]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(image, scale, size, flags=flags, borderMode=cv2.BORDER_REPLICATE), np.uint8)


def jitter_colors(image: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Shift all pixels along the principal axes of the image's own colors.

    The shift along each axis is its standard deviation times a normal number of deviation 0.1.

    Args:
        image: (H, W, 3) uint8 RGB.
        rng: gives three normal numbers.

    Returns:
        (H, W, 3) uint8.

    Reference: Krizhevsky et al., "ImageNet Classification with Deep Convolutional Neural Networks", 4.1, with the
    covariance of the image instead of the data set's.
    """
    draws = rng.normal(0.0, _JITTER_DEVIATION, 3)
    channels = [channel.astype(np.float32).ravel() for channel in cv2.split(image)]
    for channel, mean in zip(channels, cv2.mean(image), strict=False):
        channel -= np.float32(mean)
    # Six dot products: a product of matrices with three columns takes ten times as long.
    covariance = np.array([[np.dot(a, b) for b in channels] for a in channels], np.float64)
    covariance /= max(len(channels[0]) - 1, 1) * 255.0**2
    variances, axes = np.linalg.eigh(covariance)
    shift = axes @ (np.sqrt(np.maximum(variances, 0.0)) * draws)
    # One table a channel: what becomes of each of the 256 values.
    table = (np.clip(np.arange(256.0)[:, None] / 255.0 + shift, 0.0, 1.0) * 255.0).astype(np.uint8)
    return np.asarray(cv2.LUT(image, table[None]), np.uint8)


def shift_colors(image: NDArray[np.uint8], brightness: float, contrast: float, hue_deg: float) -> NDArray[np.uint8]:
    """Change brightness, contrast, and hue of an image in one pass over its pixels.

    Args:
        image: (H, W, 3) uint8 RGB.
        brightness: the share of white that is added to every channel.
        contrast: by which the distances from the image's mean gray are multiplied.
        hue_deg: by which colors are turned about the gray axis; 120 puts red in green's place.

    Returns:
        (H, W, 3) uint8, rounded once at the end.

    Reference: Haeberli, "Matrix Operations for Image Processing" (1993).
    """
    gray = sum(cv2.mean(image)[:3]) / 3.0
    angle = math.radians(hue_deg)
    share, turn = (1.0 - math.cos(angle)) / 3.0, math.sin(angle) / math.sqrt(3.0)
    # Rodrigues' formula about (1, 1, 1).
    hue = math.cos(angle) * np.eye(3) + share + turn * np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
    offset = (1.0 - contrast) * gray + 255.0 * brightness
    matrix = np.hstack([contrast * hue, np.full((3, 1), offset)])
    return np.asarray(cv2.transform(image, matrix), np.uint8)
