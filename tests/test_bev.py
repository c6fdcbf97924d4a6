"""Bird's-eye-view maps: their configuration, and the reference that defines them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bev_reference
from cadet.bev import BevConfig
from cadet.errors import CadetError


def test_the_papers_configurations_have_its_channels() -> None:
    assert BevConfig.default().shape == (6, 700, 800)
    assert BevConfig.max3_density3().shape == (6, 700, 800)
    assert BevConfig.max_min_density().shape == (3, 700, 800)
    assert BevConfig.default() == BevConfig()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"slice_maps": ("mean",)}, "BevConfig.slice_maps: expected max_height, min_height, density, got 'mean'"),
        ({"slice_maps": (), "cloud_maps": ()}, "BevConfig: expected at least one slice map or cloud map, got none"),
        ({"num_slices": 0}, "BevConfig.num_slices: expected a whole number from 1 to 1000, got 0"),
        ({"height_hi_m": -0.2}, "BevConfig.height_hi_m: expected more than -0.2, got -0.2"),
        ({"z_m": (0.0, 70.05)}, "BevConfig.z_m: expected whole cells of 0.1 m, got (0.0, 70.05)"),
        ({"cell_m": float("nan")}, "BevConfig.cell_m: expected a number from 0.001 to 100, got nan"),
        ({"height": "mean"}, "BevConfig.height: expected 'max' or 'reference', got 'mean'"),
    ],
)
def test_nonsense_is_refused(values: dict[str, Any], message: str) -> None:
    with pytest.raises(CadetError) as error:
        BevConfig(**values)
    assert str(error.value) == message


FLAT = np.array([0.0, -1.0, 0.0, 1.65])


def place(*points: tuple[float, float, float]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Place points by x, height over the ground and z."""
    return np.array([[x, 1.65 - height, z] for x, height, z in points]).reshape(-1, 3)


def test_the_reference_puts_a_point_into_its_cell_and_slice() -> None:
    found = bev_reference.maps(place((-39.95, 0.4, 0.05), (12.34, 2.0, 69.99)), FLAT, BevConfig.default())
    expected = np.zeros((6, 700, 800))
    expected[1, 699, 0] = (0.4 - 0.3) / 0.5
    expected[4, 0, 523] = (2.0 - 1.8) / 0.5
    expected[5, 699, 0] = expected[5, 0, 523] = np.log(2.0) / np.log(16.0)
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_the_references_cloud_maps_take_the_whole_range() -> None:
    points = place((0.05, 0.1, 10.05), (0.05, 1.05, 10.05), (0.05, 2.25, 10.05), (0.05, 2.35, 10.05))
    found = bev_reference.maps(points, FLAT, BevConfig.max_min_density())
    np.testing.assert_allclose(found[:, 599, 400], [2.45 / 2.5, 0.3 / 2.5, np.log(4.0) / np.log(16.0)], atol=1e-6)
    crowd = bev_reference.maps(place(*[(0.05, 0.1, 10.05)] * 40), FLAT, BevConfig.max_min_density())
    assert crowd[2, 599, 400] == 1.0
    sliced = bev_reference.maps(points, FLAT, BevConfig.max3_density3())
    assert sliced.shape == (6, 700, 800)
    heights = [0.3 / 2.5 * 3, 1.25 / 2.5 * 3 - 1, 2.45 / 2.5 * 3 - 2]
    assert sliced[::2, 599, 400] == pytest.approx(heights, abs=1e-5)
    assert sliced[1::2, 599, 400] == pytest.approx([0.25] * 3, abs=1e-6)


def test_the_references_representative_is_the_first_of_the_topmost_bin() -> None:
    # In bins of y: -0.05 and -0.01 share the topmost, so the first of the two counts, though it is not the highest.
    points = np.array([[0.05, 0.15, 10.05], [0.05, -0.01, 10.05], [0.05, -0.05, 10.05]])
    config = BevConfig(height="reference")
    assert bev_reference.maps(points, FLAT, config)[3, 599, 400] == pytest.approx((1.66 - 1.3) / 0.5, abs=1e-6)
    assert bev_reference.maps(points, FLAT, BevConfig())[3, 599, 400] == pytest.approx((1.70 - 1.3) / 0.5, abs=1e-6)


def test_the_reference_of_nothing_is_zero() -> None:
    outside = place((40.0, 1.0, 10.0), (0.0, 1.0, 70.0), (0.0, 1.0, 0.0), (0.0, 2.3, 10.0), (0.0, -0.3, 10.0))
    for points in (outside, np.zeros((0, 3))):
        assert not bev_reference.maps(points, FLAT, BevConfig.default()).any()
    out = np.full(BevConfig().shape, 7.0, np.float32)
    assert bev_reference.maps(outside, FLAT, BevConfig(), out) is out and not out.any()
