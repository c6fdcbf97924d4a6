"""Weather on recorded scans: the formulas of docs/weather.md, computed here anew with NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import cadet
from cadet.errors import CadetError, NonFiniteError, ShapeError
from cadet.formats.kitti.files.velodyne import points_from_bytes
from cadet.worlds.weather import Air, Fate, air_of, apply, weather_names
from real_kitti import files, needs_kitti

WEATHERS: list[dict[str, Any]] = [
    {"fog": 0.06},
    {"rain": 25.0},
    {"snow": 2.0},
    {"rain": 5.0, "wetness": 0.8},
    {"fog": 0.02, "rain": 10.0, "snow": 1.0, "wetness": 0.3},
]


def a_cloud(n: int = 4000, seed: int = 0) -> NDArray[np.float32]:
    """Return points all around from 2 m to 79 m, an eighth of them without intensity."""
    rng = np.random.default_rng(seed)
    range_m, azimuth, elevation = rng.uniform(2, 79, n), rng.uniform(0, 2 * np.pi, n), rng.uniform(-0.4, 0.03, n)
    x, y = range_m * np.cos(elevation) * np.cos(azimuth), range_m * np.cos(elevation) * np.sin(azimuth)
    intensity = np.where(rng.random(n) < 0.12, 0.0, rng.uniform(0.01, 0.6, n))
    return np.stack([x, y, range_m * np.sin(elevation), intensity], axis=1).astype(np.float32)


def ranges_m(points: NDArray[np.float32]) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(points[:, :3].astype(np.float64), axis=1))


def fog_by_hand(points: NDArray[np.float32], alpha: float) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """Return fates in fog and ranges, by the lidar equation for 18 sr and the brightest of four exponential clumps."""
    rng = np.random.default_rng(1)
    range_m, intensity = ranges_m(points), points[:, 3].astype(np.float64)
    threshold = 0.1 / 79.0**2
    grid = np.arange(0.9, 100.0, 0.01)
    mean = np.pi * alpha * 0.749481 / 18 * np.minimum((grid / 6) ** 3, 1) / grid**2 * np.exp(-2 * alpha * grid)
    total = np.cumsum(mean)
    end = total[np.searchsorted(grid, range_m) - 1]
    at_m = grid[np.searchsorted(total, rng.random(len(points)) * end)]
    brightness = rng.exponential(size=(4, len(points))).max(axis=0)
    echo = brightness * mean[np.searchsorted(grid, at_m)]
    left = np.exp(-2 * alpha * range_m)
    scattered = echo > np.maximum(np.maximum(intensity / range_m**2, threshold) * left, threshold)
    lost = np.maximum(intensity / range_m**2, threshold * rng.random(len(points)) ** (-1 / 3)) * left < threshold
    fate = np.where(scattered, Fate.SCATTERED, np.where(lost, Fate.LOST, Fate.KEPT)).astype(np.int8)
    return fate, np.where(scattered, at_m, range_m)


@pytest.mark.parametrize("alpha", [0.005, 0.06, 0.15])
def test_fog_shortens_a_scan_as_the_lidar_equation_says(alpha: float) -> None:
    points = a_cloud(20_000)
    left, fate = apply(points, fog=alpha, return_fate=True)
    by_hand, to_m = fog_by_hand(points, alpha)
    for low_m in range(0, 80, 8):
        here = (ranges_m(points) >= low_m) & (ranges_m(points) < low_m + 8)
        shares = [np.bincount(fates[here], minlength=3) / here.sum() for fates in (fate, by_hand)]
        np.testing.assert_allclose(shares[0], shares[1], atol=0.035)
    kept = fate[fate != Fate.LOST] == Fate.KEPT
    dimmed = points[fate == Fate.KEPT, 3] * np.exp(-2 * alpha * ranges_m(points[fate == Fate.KEPT]))
    np.testing.assert_allclose(left[kept, 3], dimmed, rtol=1e-4, atol=1e-7)
    moved = ranges_m(left)[~kept]
    if alpha < 0.01:
        assert len(moved) < 0.2 * len(points)
    else:
        assert len(moved) > 2000 and abs(moved.mean() - to_m[by_hand == Fate.SCATTERED].mean()) < 0.15


def test_rain_dims_by_marshall_and_palmers_drops() -> None:
    points = a_cloud()
    for rate in (2.0, 25.0):
        left, fate = apply(points, rain=rate, return_fate=True)
        per_mm = 4.1 * rate**-0.21
        # Twice the drops' cross-section: the mean square of an exponential diameter is 2 / slope^2.
        alpha = 2 * np.pi / 4 * 8000 * 2 / per_mm**3 * 1e-6
        kept = fate[fate != Fate.LOST] == Fate.KEPT
        before = points[fate == Fate.KEPT]
        np.testing.assert_allclose(left[kept, 3], before[:, 3] * np.exp(-2 * alpha * ranges_m(before)), rtol=1e-5)
        # What the receiver's noise of the weaker echo adds: at the threshold 1.5 times 7.8 mm at most.
        noise_m = ranges_m(left[kept]) - ranges_m(before)
        assert 0.0002 < noise_m.std() < 0.0078 * 1.5 and abs(noise_m.mean()) < 0.003
        # Points whose intensity says that they fall below the threshold, 10 % at 50 m, are the ones that may be lost.
        weak = points[:, 3] * np.exp(-2 * alpha * ranges_m(points)) / ranges_m(points) ** 2 < 0.1 / 50**2
        assert weak[fate == Fate.LOST].all() and (fate == Fate.LOST).any()


@settings(max_examples=30, deadline=None)
@given(
    fog=st.floats(0, 0.5),
    rain=st.floats(0, 300),
    snow=st.floats(0, 20),
    wetness=st.floats(0, 1),
    seed=st.integers(0, 2**64 - 1),
)
def test_points_stay_on_their_rays(fog: float, rain: float, snow: float, wetness: float, seed: int) -> None:
    points = a_cloud(500, seed % 1000)
    before = points.copy()
    left, fate = apply(points, fog=fog, rain=rain, snow=snow, wetness=wetness, seed=seed, return_fate=True)
    np.testing.assert_array_equal(points, before)
    assert left.dtype == np.float32 and left.shape == (np.count_nonzero(fate != Fate.LOST), 4)
    assert fate.dtype == np.int8 and np.isfinite(left).all() and not np.shares_memory(left, points)
    source = points[fate != Fate.LOST].astype(np.float64)
    cos = np.sum(source[:, :3] * left[:, :3], axis=1) / (ranges_m(points[fate != Fate.LOST]) * ranges_m(left))
    assert (cos > 1 - 1e-9).all()
    scattered = fate[fate != Fate.LOST] == Fate.SCATTERED
    shift_m = ranges_m(left) - ranges_m(points[fate != Fate.LOST])
    assert (shift_m[scattered] < 1e-5).all() and (np.abs(shift_m[~scattered]) < 0.26).all()
    assert (ranges_m(left)[scattered] > 0.89).all()
    assert (left[~scattered, 3] <= source[~scattered, 3]).all() and (left[:, 3] >= 0).all() and (left[:, 3] <= 1).all()
    again = apply(points, fog=fog, rain=rain, snow=snow, wetness=wetness, seed=seed)
    np.testing.assert_array_equal(again, left)


def test_no_weather_gives_the_same_bits_in_a_new_array() -> None:
    points = a_cloud()
    for left in (apply(points), apply(points, rain=0, fog=0.0, snow=0.0, seed=9)):
        assert left.tobytes() == points.tobytes() and left is not points and not np.shares_memory(left, points)
    empty = np.empty((0, 4), np.float32)
    assert apply(empty, fog=0.06).shape == (0, 4) and apply(empty, rain=5.0).dtype == np.float32


@pytest.mark.parametrize("weather", WEATHERS)
def test_a_scan_may_be_cut_shuffled_and_strided(weather: dict[str, Any]) -> None:
    points = a_cloud()
    whole, fate = apply(points, seed=3, return_fate=True, **weather)
    pieces = [apply(piece, seed=3, **weather) for piece in np.array_split(points, 7)]
    np.testing.assert_array_equal(np.concatenate(pieces), whole)
    order = np.random.default_rng(0).permutation(len(points))
    _, shuffled = apply(points[order], seed=3, return_fate=True, **weather)
    np.testing.assert_array_equal(shuffled, fate[order])
    np.testing.assert_array_equal(apply(np.asfortranarray(points), seed=3, **weather), whole)
    np.testing.assert_array_equal(
        apply(points[::2], seed=3, **weather)[:20], first_alone(points[::2], fate[::2], weather)
    )
    assert apply(points, seed=4, **weather).tobytes() != whole.tobytes()


def first_alone(points: NDArray[np.float32], fate: NDArray[np.int8], weather: dict[str, Any]) -> NDArray[np.float32]:
    """Return the first 20 points that are left, each computed alone."""
    alone = [apply(point[None], seed=3, **weather) for point in points[fate != Fate.LOST][:20]]
    return np.concatenate(alone)


@pytest.mark.parametrize(
    ("name", "rates"),
    [("rain", [0, 1e-6, 1, 10, 50, 200]), ("snow", [0, 1e-9, 0.5, 2, 10]), ("wetness", [0, 0.3, 1])],
)
def test_fewer_points_are_kept_in_heavier_weather(name: str, rates: list[float]) -> None:
    points = a_cloud(20_000)
    fates = [apply(points, return_fate=True, **weather_of(name, rate))[1] for rate in rates]
    kept = [np.count_nonzero(fate == Fate.KEPT) for fate in fates]
    rows = [np.count_nonzero(fate != Fate.LOST) for fate in fates]
    assert kept == sorted(kept, reverse=True) and rows == sorted(rows, reverse=True) and kept[-1] < 0.97 * kept[0]
    assert name == "wetness" or kept[1] > 0.999 * kept[0], "a breath of weather is no cliff"


def weather_of(name: str, rate: float) -> Any:
    return {name: rate}


def test_wet_ground_mirrors_and_walls_do_not() -> None:
    near = np.array([[8.0, 0.0, -1.7, 0.3], [8.0, 0.0, 1.0, 0.3]], np.float32)
    ground, wall = apply(near, wetness=1.0)[:, 3]
    assert ground < 0.15 and wall == np.float32(0.3)
    assert apply(near, wetness=1.0, sensor_height_m=3.0)[0, 3] == np.float32(0.3)


@pytest.mark.parametrize(
    ("points", "error", "text"),
    [
        ([[1.0, 2.0, 3.0, 0.5]], ShapeError, "points_velo: expected an array"),
        (np.zeros((3, 3), np.float32), ShapeError, r"\(3, 3\)"),
        (np.zeros(4, np.float32), ShapeError, r"\(4,\)"),
        (np.zeros((3, 4)), ShapeError, "astype"),
        (np.zeros((3, 5), np.float32), ShapeError, r"\(3, 5\) float32: give the first four, as points\[:, :4\]$"),
        (np.zeros((3, 6)), ShapeError, r"\(3, 6\) float64: give the first four, as points\[:, :4\]$"),
        (
            np.full((2, 4), np.nan, np.float32),
            NonFiniteError,
            r"not finite at \[0, 0\]: leave such points out, as in points\[np.isfinite\(points\).all\(axis=1\)\]$",
        ),
        (
            np.array([[1, 1, 1, 37]], np.float32),
            CadetError,
            r"intensity of points_velo is 37, expected 0 to 1: scale it, as in points\[:, 3\] /= 255$",
        ),
        (np.array([[1, 1, 1, -0.5]], np.float32), CadetError, "intensity of points_velo is -0.5"),
    ],
)
def test_bad_points_are_refused(points: Any, error: type[CadetError], text: str) -> None:
    with pytest.raises(error, match=text) as caught:
        apply(points, fog=0.01)
    assert isinstance(caught.value, CadetError) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("bad", "text"),
    [
        ({"fog": -0.1}, "fog is -0.1, expected 0 to 10"),
        ({"rain": -1}, "rain is -1, expected 0 to 1000"),
        ({"snow": float("nan")}, "snow: not finite"),
        ({"rain": float("inf")}, "rain: not finite"),
        ({"fog": "thick"}, "fog: expected a number"),
        ({"fog": True}, "fog: expected a number"),
        ({"wetness": 1.1}, "wetness is 1.1"),
        ({"seed": -1}, "seed: expected a whole number"),
        ({"seed": 0.5}, "seed: expected a whole number"),
        ({"seed": 2**64}, "seed: expected a whole number"),
        ({"sensor_height_m": float("nan")}, "sensor_height_m: not finite"),
    ],
)
def test_bad_weather_is_refused(bad: dict[str, Any], text: str) -> None:
    for points in (a_cloud(3), np.empty((0, 4), np.float32)):
        with pytest.raises(CadetError, match=text):
            apply(points, **bad)


def test_presets_have_air() -> None:
    assert air_of("clear_noon") == Air(0.0, 0.0, 0.0, 0.0)
    assert air_of("dense_fog").fog == pytest.approx(np.log(20) / 50) and air_of("hard_rain_sunset").rain == 25.0
    points = a_cloud()
    assert np.array_equal(apply(points, **air_of("snow")._asdict()), apply(points, snow=1.5))
    for name in weather_names():
        assert len(apply(points, **air_of(name)._asdict())) > 0.7 * len(points)
    with pytest.raises(CadetError, match="unknown weather 'hail'"):
        air_of("hail")


@needs_kitti
def test_a_real_scan_in_weather() -> None:
    paths = files("training/velodyne/*.bin")[:3]
    assert len(paths) == 3
    for path in paths:
        points = points_from_bytes(path.read_bytes(), path.name)
        assert apply(points).tobytes() == points.tobytes()
        fate = {str(k): apply(points, return_fate=True, **k)[1] for k in WEATHERS}
        for name, fates in fate.items():
            share = np.bincount(fates, minlength=3) / len(points)
            assert 0.5 < share[Fate.KEPT] < 0.99999, (name, share)
        left, fates = apply(points, fog=0.06, return_fate=True)
        by_hand, _ = fog_by_hand(points, 0.06)
        shares = [np.bincount(each, minlength=3) / len(points) for each in (fates, by_hand)]
        np.testing.assert_allclose(shares[0], shares[1], atol=0.01)
        assert (ranges_m(left) > 40).sum() == 0 < (ranges_m(points) > 40).sum()


def test_wind_takes_rain_along_and_nothing_else() -> None:
    def capture(wind_mps: float) -> cadet.Frame:
        rain = cadet.Weather(rain_mm_h=50.0, cloud_cover=1.0, wind_mps=wind_mps)
        return cadet.Scene.random(seed=3, weather=rain).capture()

    calm, windy = capture(0.0), capture(15.0)
    # Streaks lie elsewhere; all else is as bright to a few levels.
    apart = np.abs(calm.image.astype(int) - windy.image).max(axis=2)
    assert (apart > 10).sum() > 200 and (apart > 10).mean() < 0.1 and np.median(apart) <= 2
    np.testing.assert_array_equal(calm.points_velo, windy.points_velo)
    assert calm.labels == windy.labels
