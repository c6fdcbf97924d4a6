"""The statistics of KITTI's images, frame by frame, of sunny generated ones: `pytest -s` prints them as a table.

Ranges are facts: the least and the greatest value of a set of KITTI's frames. OF_13 are the thirteen sunny frames of
its training set by which this camera was modeled; OF_45 are six of those and thirty-nine others. Values are of 8 bits,
luma has the weights 0.2126, 0.7152, 0.0722.
"""

from __future__ import annotations

import sys
from itertools import pairwise
from typing import Final

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import cadet

# A hundred frames take a minute and a half where other programs run, too.
pytestmark = pytest.mark.timeout(300)
Image = NDArray[np.float64]

NUM_FRAMES: Final = 100
LEAST_SHARE: Final = 0.7
"""Of generated frames that must lie in each range."""
LUMA: Final = (0.2126, 0.7152, 0.0722)

OF_13: Final = {
    "mean luma": (85.0, 104.0),
    "standard deviation of luma": (67.0, 89.0),
    "luma, 50 %": (41.0, 80.0),
    "luma, 75 %": (109.0, 189.0),
    "share with a clipped channel": (0.046, 0.233),
    "share with all channels clipped": (0.004, 0.146),
    "share with a clipped channel, no sky": (0.005, 0.158),
    "share of luma 10 or less": (0.003, 0.117),
    "spectral slope, 0.02 to 0.2 cycles/px": (-2.68, -2.19),
    "spectral slope, 0.2 to 0.5 cycles/px": (-5.0, -4.1),
    "power at 0.46 over 0.1 cycles/px": (0.0027, 0.0056),
    "share of sky": (0.01, 0.23),
}
OF_45: Final = {
    "mean of the logarithm of luma, as luma": (57.1, 86.6),
    "luma, 1 %": (4.0, 14.7),
    "luma, 5 %": (7.6, 27.2),
    "luma, 25 %": (25.0, 51.7),
    "luma, 95 %": (205.4, 255.0),
    "luma, 99 %": (240.2, 255.0),
    "mean green less red": (-5.5, 21.0),
    "mean blue less red": (-17.2, 23.4),
    "saturation, 25 %": (14.0, 58.9),
    "saturation, 50 %": (36.4, 93.7),
    "saturation, 75 %": (68.0, 131.4),
    "saturation, 95 %": (120.2, 181.4),
    "gradient, 50 %": (1.44, 13.3),
    "gradient, 75 %": (5.5, 28.5),
    "gradient, 90 %": (13.6, 46.0),
    "gradient, 99 %": (51.7, 81.8),
    "top twentieth of rows over the mean": (0.73, 1.92),
    "rows at the horizon over the mean": (0.39, 1.31),
    "bottom twentieth of rows over the mean": (0.26, 1.83),
}
MEDIANS_OF_PARTS: Final = {
    # By LIDAR points of 45 frames: carriageway ahead, upright planes, rough green, cars' boxes.
    "road": ((cadet.Semantic.ROAD,), (44.0, 186.0)),
    "buildings": ((cadet.Semantic.BUILDING,), (31.0, 146.0)),
    "vegetation": ((cadet.Semantic.VEGETATION,), (28.0, 93.0)),
    "cars": ((cadet.Semantic.CAR, cadet.Semantic.VAN), (30.0, 85.0)),
}
"""The median luma of a part of the image, from the 10th to the 90th percentile of KITTI's frames."""
ROAD_AHEAD: Final = np.s_[260:350, 420:760]
FINE_RED_AND_GREEN: Final = (0.41, 0.77)
FINE_RED_AND_BLUE: Final = (0.15, 0.43)
"""Correlations of what is finer than 5 pixels on the road ahead, from the 10th to the 90th percentile of 42 frames."""


def semantic_of(frame: cadet.Frame) -> NDArray[np.uint8]:
    assert frame.semantic is not None
    return frame.semantic


def luma_of(image: Image) -> Image:
    luma: Image = image @ LUMA
    return luma


def spectrum(luma: Image) -> dict[str, float]:
    """Measure the radially averaged power spectrum of the middle of an image."""
    part = luma[:360, :1200]
    window = np.outer(np.hanning(360), np.hanning(1200))
    power = np.abs(np.fft.fft2((part - part.mean()) * window)) ** 2
    frequency = np.hypot(np.fft.fftfreq(360)[:, None], np.fft.fftfreq(1200)[None])

    def band(least: float, most: float) -> float:
        return float(power[(frequency >= least) & (frequency < most)].mean())

    def slope(least: float, most: float) -> float:
        edges = np.geomspace(least, most, 13)
        middles = np.log(np.sqrt(edges[1:] * edges[:-1]))
        return float(np.polyfit(middles, np.log([band(a, b) for a, b in pairwise(edges)]), 1)[0])

    return {
        "spectral slope, 0.02 to 0.2 cycles/px": slope(0.02, 0.2),
        "spectral slope, 0.2 to 0.5 cycles/px": slope(0.2, 0.5),
        "power at 0.46 over 0.1 cycles/px": band(0.45, 0.47) / band(0.095, 0.105),
    }


def measure(frame: cadet.Frame) -> dict[str, float]:
    """Measure a frame by every row of the table."""
    image = frame.image.astype(float)
    luma = luma_of(image)
    is_sky = np.equal(semantic_of(frame), cadet.Semantic.SKY)
    is_clipped = image >= 255.0
    most, least = image.max(-1), image.min(-1)
    saturation = 255.0 * (most - least) / np.maximum(most, 1.0)
    gradient = np.hypot(*(cv2.Sobel(luma, cv2.CV_64F, *d, scale=1 / 8) for d in ((1, 0), (0, 1))))
    rows = np.array([rows.mean() for rows in np.array_split(luma, 20)]) / luma.mean()
    red, green, blue = image.mean((0, 1))
    percentiles = {
        "luma": (luma, (1, 5, 25, 50, 75, 95, 99)),
        "saturation": (saturation, (25, 50, 75, 95)),
        "gradient": (gradient, (50, 75, 90, 99)),
    }
    return {
        "mean luma": luma.mean(),
        "standard deviation of luma": luma.std(),
        "mean of the logarithm of luma, as luma": np.exp(np.log(np.maximum(luma, 1.0)).mean()),
        "share with a clipped channel": is_clipped.any(-1).mean(),
        "share with all channels clipped": is_clipped.all(-1).mean(),
        "share with a clipped channel, no sky": (is_clipped.any(-1) & ~is_sky).mean(),
        "share of luma 10 or less": (luma <= 10.0).mean(),
        "share of sky": is_sky.mean(),
        "mean green less red": green - red,
        "mean blue less red": blue - red,
        "top twentieth of rows over the mean": rows[0],
        "rows at the horizon over the mean": rows[8],
        "bottom twentieth of rows over the mean": rows[19],
        **{f"{name}, {p} %": np.percentile(of, p) for name, (of, ps) in percentiles.items() for p in ps},
        **spectrum(luma),
    }


@pytest.fixture(scope="module")
def frames() -> list[cadet.Frame]:
    """Take two pictures in each of some sunny suburbs, the ego driving on between them."""
    taken = []
    for seed in range(NUM_FRAMES // 2):
        scene = cadet.Scene.random(seed=seed, weather="clear_noon")
        taken.append(scene.capture())
        scene.step(4.0)
        taken.append(scene.capture())
    return taken


def test_sunny_frames_have_the_statistics_of_real_ones(frames: list[cadet.Frame]) -> None:
    measured = [measure(frame) for frame in frames]
    shares = {}
    lines = [f"{'':40} {'KITTI':>19} {'10 %':>9} {'median':>9} {'90 %':>9}  within"]
    for row, (least, most) in {**OF_13, **OF_45}.items():
        values = np.array([of[row] for of in measured])
        shares[row] = float(((values >= least) & (values <= most)).mean())
        quantiles = " ".join(f"{q:9.4g}" for q in np.percentile(values, (10, 50, 90)))
        lines.append(f"{row:40} {least:9.4g} {most:9.4g} {quantiles} {shares[row]:7.2f}")
    sys.stdout.write("\n" + "\n".join(lines) + "\n")
    missed = {row: share for row, share in shares.items() if share < LEAST_SHARE}
    assert not missed, missed


@pytest.mark.parametrize("part", MEDIANS_OF_PARTS)
def test_streets_facades_plants_and_cars_are_as_bright_as_real_ones(frames: list[cadet.Frame], part: str) -> None:
    kinds, (least, most) = MEDIANS_OF_PARTS[part]
    shows = [np.isin(semantic_of(frame), kinds) for frame in frames]
    seen = [(frame, where) for frame, where in zip(frames, shows, strict=True) if where.sum() > 1000]
    assert len(seen) >= NUM_FRAMES // 2
    medians = [float(np.median(luma_of(frame.image[where].astype(float)))) for frame, where in seen]
    sys.stdout.write(f"\n{part}: {np.percentile(medians, (10, 50, 90)).round(1)}\n")
    assert least < np.median(medians) < most
    assert np.mean([least <= median <= most for median in medians]) > 0.5


def test_colors_of_fine_detail_are_as_independent_as_behind_real_color_filters(frames: list[cadet.Frame]) -> None:
    found = []
    for frame in frames:
        image = frame.image.astype(float)
        mean = cv2.blur(image, (9, 9))
        where = (mean.max(-1) < 200.0) & (mean.min(-1) > 60.0)
        if where[ROAD_AHEAD].sum() > 3000:
            of = np.corrcoef((image - cv2.blur(image, (5, 5)))[ROAD_AHEAD][where[ROAD_AHEAD]].T)
            found.append((of[0, 1], of[0, 2]))
    assert len(found) >= NUM_FRAMES // 2
    red_and_green, red_and_blue = np.median(found, axis=0)
    assert FINE_RED_AND_GREEN[0] < red_and_green < FINE_RED_AND_GREEN[1], red_and_green
    assert FINE_RED_AND_BLUE[0] < red_and_blue < FINE_RED_AND_BLUE[1], red_and_blue
