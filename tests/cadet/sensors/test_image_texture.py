"""Sunny pictures are as rough as KITTI's: measured on what the camera writes, not on its textures.

The ranges are those of the 13 of KITTI's training frames that were measured for this camera's look, and, of the median
gradient, of the 6 among them and 39 others that are at hand: 8-bit luma with weights 0.0722, 0.7152, 0.2126 of B, G, R.
Foliage and lawns are those of 9 and 4 patches of the same frames.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import cadet

ASPHALT_CONTRAST = (0.052, 0.083)
HIGH_FREQUENCY_POWER = (0.0027, 0.0056)
MEDIAN_GRADIENT = (1.45, 13.4)
FOLIAGE_CONTRAST = (0.365, 0.61)
# Real ones: 0.17 and more. Trees that stand close shade more of these lawns, and shade is smoother.
LAWN_CONTRAST = (0.15, 0.21)


class Look(NamedTuple):
    """What was measured on one picture."""

    asphalt_contrast: float
    high_frequency_power: float
    median_gradient: float
    foliage_contrast: float
    lawn_contrast: float


def measure(frame: cadet.Frame) -> Look:
    """Measure a picture."""
    assert frame.semantic is not None and frame.depth is not None
    luma = frame.image.astype(float) @ [0.2126, 0.7152, 0.0722]
    gradient = np.hypot(*(cv2.Sobel(luma, cv2.CV_64F, *d, scale=1 / 8) for d in ((1, 0), (0, 1))))
    # Standard deviation over mean of 9 x 9 pixels that show one class alone, neither black nor white.
    mean = cv2.blur(luma, (9, 9))
    contrast = np.sqrt(np.maximum(cv2.blur(luma * luma, (9, 9)) - mean * mean, 0.0)) / np.maximum(mean, 1.0)
    is_gray = (mean > 15.0) & (mean < 235.0)

    semantic = frame.semantic

    def contrast_of(kind: cadet.Semantic, where: NDArray[np.bool_]) -> float:
        shows = cv2.erode(np.equal(semantic, kind).astype(np.uint8), np.ones((15, 15), np.uint8)) > 0
        shows &= where & is_gray
        return float(np.median(contrast[shows])) if shows.sum() > 500 else np.nan

    everywhere = np.ones_like(is_gray)
    road = (frame.depth > 5.0) & (frame.depth < 12.0)
    height, width = (n // 8 * 8 for n in luma.shape)
    window = np.hanning(height)[:, None] * np.hanning(width)
    power = np.abs(np.fft.fft2((luma[:height, :width] - luma.mean()) * window)) ** 2
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width))

    def band(cycles_per_px: float) -> float:
        return float(power[np.abs(frequency / cycles_per_px - 1.0) < 0.07].mean())

    return Look(
        contrast_of(cadet.Semantic.ROAD, road),
        band(0.46) / band(0.1),
        float(np.median(gradient[1:-1, 1:-1])),
        contrast_of(cadet.Semantic.VEGETATION, everywhere),
        contrast_of(cadet.Semantic.TERRAIN, everywhere),
    )


@pytest.fixture(scope="module")
def looks() -> NDArray[np.float64]:
    """Measure a dozen sunny streets."""
    scenes = (cadet.Scene.random(seed=seed, weather="clear_noon") for seed in range(12))
    return np.array([measure(scene.capture()) for scene in scenes])


def share_within(values: NDArray[np.float64], limits: tuple[float, float]) -> float:
    """Count what lies within limits, among what was measured."""
    known = values[np.isfinite(values)]
    assert len(known) >= 6
    return float(((known >= limits[0]) & (known <= limits[1])).mean())


def test_asphalt_has_the_contrast_of_real_asphalt(looks: NDArray[np.float64]) -> None:
    contrast = looks[:, 0]
    assert ASPHALT_CONTRAST[0] < np.nanmedian(contrast) < ASPHALT_CONTRAST[1], contrast
    assert share_within(contrast, ASPHALT_CONTRAST) >= 0.7, contrast


def test_pictures_have_the_gradients_and_the_fine_structure_of_real_ones(looks: NDArray[np.float64]) -> None:
    power, gradient = looks[:, 1], looks[:, 2]
    assert HIGH_FREQUENCY_POWER[0] < np.median(power) < HIGH_FREQUENCY_POWER[1], power
    assert share_within(power, HIGH_FREQUENCY_POWER) >= 0.5, power
    # Still smoother than KITTI's, whose median is 2.9 to 5.6: shaded walls have too little on them.
    assert np.median(gradient) > 2.08 and share_within(gradient, MEDIAN_GRADIENT) >= 0.5, gradient


def test_foliage_and_lawns_have_the_contrast_of_real_ones(looks: NDArray[np.float64]) -> None:
    for contrast, limits in ((looks[:, 3], FOLIAGE_CONTRAST), (looks[:, 4], LAWN_CONTRAST)):
        assert limits[0] < np.nanmedian(contrast) < limits[1], contrast
