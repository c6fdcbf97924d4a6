"""Nights: as dark as stated in every district, the same scans and labels as by day, and the same bytes each time."""

from __future__ import annotations

import numpy as np
import pytest

import cadet
from cadet.worlds.districts import DISTRICTS

LUMA = np.array([0.2126, 0.7152, 0.0722])


def frame(seed: int, weather: str, district: str | None = None) -> cadet.Frame:
    policy = cadet.ResetPolicy.kitti()
    if district is not None:
        policy = policy.with_districts(district)
    policy = policy.with_weathers(weather)
    return cadet.Scene.random(seed=seed, policy=policy).capture(sensors=())


@pytest.mark.parametrize("district", DISTRICTS)
def test_nights_are_dark_and_not_black_in_every_district(district: str) -> None:
    for seed, weather in ((3, "clear_night"), (4, "clear_night"), (5, "wet_night")):
        luma = frame(seed, weather, district).image @ LUMA
        assert 15 < luma.mean() < 45, (seed, weather, luma.mean())
        # Black sky and yards, and lamps that clip.
        assert 0.1 < (luma < 16).mean() < 0.85, (seed, weather)
        assert 0.0002 < (luma > 250).mean() < 0.1, (seed, weather)


def test_the_lidar_sees_the_same_by_night_as_by_day() -> None:
    for seed in (7, 8):
        noon, dark = frame(seed, "clear_noon"), frame(seed, "clear_night")
        np.testing.assert_array_equal(noon.points_velo, dark.points_velo)
        assert noon.labels == dark.labels
        assert not np.array_equal(noon.image, dark.image)


def test_a_night_has_the_same_bytes_each_time() -> None:
    first, second = frame(2, "wet_night"), frame(2, "wet_night")
    np.testing.assert_array_equal(first.image, second.image)
    np.testing.assert_array_equal(first.points_velo, second.points_velo)
