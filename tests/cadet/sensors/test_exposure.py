"""One exposure for a rig, steady in time: measured on what stands, before it clips."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet

BLOCK = (25, 27)


def blocks(image: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum up blocks of pixels."""
    (rows, columns), (height, width) = image.shape, BLOCK
    whole = image[: rows // height * height, : columns // width * width]
    return np.asarray(whole.reshape(rows // height, height, columns // width, width).sum((1, 3)))


def relative_gain(before: cadet.Frame, after: cadet.Frame) -> float:
    """Measure how much brighter a frame is: the median of blocks in which nothing moves and nothing is white."""
    images = [frame.image.astype(float) for frame in (before, after)]
    stands = np.all([np.asarray(frame.instance) <= 0 for frame in (before, after)], axis=0)
    stands &= np.all([image.max(-1) < 235.0 for image in images], axis=0)
    one, other, counts = (blocks(of) for of in (*(image.sum(-1) * stands for image in images), stands.astype(float)))
    is_counted = counts > 0.6 * counts.max()
    return float(np.median(other[is_counted] / one[is_counted]))


@pytest.mark.parametrize(
    ("seed", "weather", "has_traffic"),
    [
        (7, "clear_noon", True),
        (1, "cloudy_noon", True),
        (2, "cloudy_noon", False),
        (5, "clear_sunset", False),
        (13, "cloudy_noon", True),
    ],
)
def test_frames_of_a_parked_car_do_not_flicker(seed: int, weather: str, has_traffic: bool) -> None:
    scene = cadet.Scene.random(seed=seed, weather=weather)
    scene.command_ego(speed_mps=0.0)
    scene.step(4.0)
    frames = []
    for _ in range(24 if has_traffic else 6):
        scene.step(0.1)
        frames.append(scene.capture())
    shares = [np.mean(np.asarray(frame.instance) > 0) for frame in frames]
    assert (max(shares) - min(shares) > 0.09) == has_traffic, shares
    changes = [abs(relative_gain(a, b) - 1.0) for a, b in pairwise(frames)]
    assert max(changes) < 0.005, changes


def test_a_camera_that_has_not_looked_for_a_second_meters_anew() -> None:
    frames = []
    for before_s in (None, 0.2, 1.5):
        scene = cadet.Scene.random(seed=1, weather="clear_noon")
        scene.step(3.0 - (before_s or 0.0))
        if before_s is not None:
            scene.capture()
            scene.step(before_s)
        frames.append(scene.capture())
    assert abs(relative_gain(frames[0], frames[1]) - 1.0) > 0.003
    assert abs(relative_gain(frames[0], frames[2]) - 1.0) < 0.0003
    assert abs(relative_gain(frames[2], scene.capture()) - 1.0) < 0.0003


def relative_gain_of_right_camera(frame: cadet.Frame) -> float:
    """Compare what both cameras of a stereo pair show of the same places."""
    left, right = (frame.images[name].astype(float) for name in ("image_2", "image_3"))
    assert frame.depth is not None
    baseline_px_m = frame.calib.P2[0, 3] - frame.calib.P3[0, 3]
    rows, columns = np.nonzero((frame.depth > 15.0) & (frame.depth < 80.0))
    beside = np.round(columns - baseline_px_m / frame.depth[rows, columns]).astype(int)
    seen = beside >= 0
    one, other = left[rows[seen], columns[seen]], right[rows[seen], beside[seen]]
    is_same = (np.maximum(one, other).max(-1) < 235.0) & (np.abs(one - other).max(-1) < 40.0)
    assert is_same.sum() > 10_000
    return float(other[is_same].sum() / one[is_same].sum())


def test_both_cameras_of_a_stereo_pair_show_a_place_equally_bright() -> None:
    scene = cadet.Scene.random(seed=4, weather="clear_noon")
    for _ in range(4):
        assert abs(relative_gain_of_right_camera(scene.capture(sensors=["image_3"])) - 1.0) < 0.006
        scene.step(1.0)


def test_episodes_are_exposed_with_errors_of_their_own() -> None:
    lumas = []
    for seed in range(6):
        image = cadet.Scene.random(seed=seed, weather="clear_noon").capture().image
        lumas.append(float((image.astype(float) @ [0.2126, 0.7152, 0.0722]).mean()))
    assert 1.0 < np.std(lumas) < 9.0, lumas
