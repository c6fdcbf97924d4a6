"""Camera images on their way to the network."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from avod.config import ImageConfig

_JITTER_DEVIATION: Final = 0.1


def prepare_image(image: NDArray[np.uint8], config: ImageConfig) -> NDArray[np.float32]:
    """Resize an image and take the mean off.

    Args:
        image: (H, W, 3) uint8 RGB.
        config: size and mean.

    Returns:
        (3, h, w) float32.
    """
    resized = resize_bilinear(image, config.size) - np.array(config.mean_rgb, np.float32)
    return np.ascontiguousarray(resized.transpose(2, 0, 1))


def resize_bilinear(image: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.float32]:
    """Resize an image by bilinear sampling at target * (source size / target size), the corner pixels' centers being 0.

    Args:
        image: (H, W, 3).
        size: target width and height.

    Returns:
        (h, w, 3) float32.

    Reference: tf.image.resize_bilinear of TensorFlow 1 with align_corners=False, that is without half-pixel centers.
    """
    top, bottom, row_share = _neighbors(image.shape[0], size[1])
    left, right, column_share = _neighbors(image.shape[1], size[0])
    pixels = image.astype(np.float32)
    rows = pixels[top] + (pixels[bottom] - pixels[top]) * row_share[:, None, None]
    before = rows[:, left]
    resized: NDArray[np.float32] = before + (rows[:, right] - before) * column_share[:, None]
    return resized


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
    colors = image.reshape(-1, 3).astype(np.float32)
    colors -= colors.mean(axis=0, dtype=np.float64).astype(np.float32)
    covariance = (colors.T @ colors).astype(np.float64) / (max(len(colors) - 1, 1) * 255.0**2)
    variances, axes = np.linalg.eigh(covariance)
    shift = axes @ (np.sqrt(np.maximum(variances, 0.0)) * draws)
    # One table a channel: what becomes of each of the 256 values.
    table = (np.clip(np.arange(256.0)[:, None] / 255.0 + shift, 0.0, 1.0) * 255.0).astype(np.uint8)
    return np.asarray(cv2.LUT(image, table[None]), np.uint8)


def _neighbors(num_source: int, num_target: int) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float32]]:
    position = np.arange(num_target, dtype=np.float32) * np.float32(num_source / num_target)
    low = np.minimum(np.floor(position).astype(np.intp), num_source - 1)
    return low, np.minimum(low + 1, num_source - 1), position - low.astype(np.float32)
