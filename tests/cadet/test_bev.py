"""The configuration of bird's-eye-view maps."""

from __future__ import annotations

from typing import Any

import pytest

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
        (
            {"slice_maps": ("mean",)},
            "BevConfig.slice_maps: expected max_height, min_height, density, density_log64, got 'mean'",
        ),
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
