from __future__ import annotations

from dataclasses import asdict, fields
from types import SimpleNamespace
from typing import Any

import pytest

from cadet import CadetError, LabelConfig, PropConfig, SceneConfig, SuburbConfig

NAN = float("nan")


@pytest.mark.parametrize(
    ("cls", "values", "message"),
    [
        (SceneConfig, {"num_cars": -1}, "SceneConfig.num_cars: expected a whole number from 0 to 500, got -1"),
        (SceneConfig, {"num_cars": 1.5}, "SceneConfig.num_cars: expected a whole number from 0 to 500, got 1.5"),
        (SceneConfig, {"num_cars": None}, "SceneConfig.num_cars: expected a whole number from 0 to 500, got None"),
        (SceneConfig, {"num_cars": True}, "SceneConfig.num_cars: expected a whole number from 0 to 500, got True"),
        (
            SceneConfig,
            {"parking_occupancy": NAN},
            "SceneConfig.parking_occupancy: expected a number from 0 to 1, got nan",
        ),
        (SceneConfig, {"suburb": {}}, "SceneConfig.suburb: expected a SuburbConfig, got {}"),
        (
            SceneConfig,
            {"sun_elevation_deg": -5},
            "SceneConfig.sun_elevation_deg: expected a number from 3 to 90, got -5",
        ),
        (SuburbConfig, {"blocks": (1, 4)}, "SuburbConfig.blocks: expected a whole number from 2 to 12, got 1"),
        (SuburbConfig, {"blocks": 4}, "SuburbConfig.blocks: expected 2 numbers, got 4"),
        (
            SuburbConfig,
            {"block_m": (90.0, 80.0)},
            "SuburbConfig.block_m: expected the second to be the larger, got (90.0, 80.0)",
        ),
        (PropConfig, {"greenery": 3}, "PropConfig.greenery: expected a number from 0 to 2, got 3"),
        (
            PropConfig,
            {"house_shares": (0.0,) * 6},
            "PropConfig.house_shares: expected a weight above 0, got (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)",
        ),
        (SceneConfig, {"label": None}, "SceneConfig.label: expected a LabelConfig, got None"),
        (LabelConfig, {"method": "area"}, "LabelConfig.method: expected 'pixels' or 'corners', got 'area'"),
        (LabelConfig, {"boxes": "true"}, "LabelConfig.boxes: expected 'kitti' or 'exact', got 'true'"),
        (LabelConfig, {"boxes": None}, "LabelConfig.boxes: expected 'kitti' or 'exact', got None"),
        (
            LabelConfig,
            {"min_height_px": float("inf")},
            "LabelConfig.min_height_px: expected a number of at least 0, got inf",
        ),
        (LabelConfig, {"max_depth_m": "80"}, "LabelConfig.max_depth_m: expected a number of at least 0, got '80'"),
        (LabelConfig, {"min_depth_m": -0.5}, "LabelConfig.min_depth_m: expected a number of at least 0, got -0.5"),
        (LabelConfig, {"max_truncation": 1.5}, "LabelConfig.max_truncation: expected a number from 0 to 1, got 1.5"),
        (LabelConfig, {"min_contrast": NAN}, "LabelConfig.min_contrast: expected a number from 0 to 1, got nan"),
        (
            LabelConfig,
            {"min_points": 2.5},
            "LabelConfig.min_points: expected a whole number from 0 to 1000000, got 2.5",
        ),
        (
            LabelConfig,
            {"min_points": -1},
            "LabelConfig.min_points: expected a whole number from 0 to 1000000, got -1",
        ),
        (
            LabelConfig,
            {"occlusion_levels": (0.5, 0.8)},
            "LabelConfig.occlusion_levels: expected the first to be the larger, got (0.5, 0.8)",
        ),
        (
            LabelConfig,
            {"occlusion_levels": [0.8]},
            "LabelConfig.occlusion_levels: expected 2 numbers, got [0.8]",
        ),
        (
            LabelConfig,
            {"max_hidden_corners": 9},
            "LabelConfig.max_hidden_corners: expected a whole number from 1 to 8, got 9",
        ),
    ],
)
def test_nonsense_is_refused_by_name(cls: type[Any], values: dict[str, Any], message: str) -> None:
    with pytest.raises(CadetError) as caught:
        cls(**values)
    assert str(caught.value) == message


def test_the_normative_thresholds_are_the_defaults() -> None:
    assert asdict(LabelConfig()) == {
        "method": "pixels",
        "boxes": "kitti",
        "min_height_px": 15.0,
        "min_visible_fraction": 0.1,
        "max_depth_m": 80.0,
        "min_depth_m": 0.5,
        "max_truncation": 0.95,
        "min_contrast": 0.05,
        "min_points": 0,
        "dontcare_min_pixels": 8.0,
        "occlusion_levels": (0.8, 0.5),
        "corner_tolerance_m": 0.1,
        "max_hidden_corners": 4,
    }


PARTS: dict[type[Any], str | None] = {
    LabelConfig: "label",
    PropConfig: "props",
    SceneConfig: None,
    SuburbConfig: "suburb",
}


def unchecked(config: Any, **changes: Any) -> SimpleNamespace:
    """Return an object with a configuration's fields, and with others that it would refuse."""
    return SimpleNamespace(**{f.name: getattr(config, f.name) for f in fields(config)} | changes)


@pytest.mark.parametrize("cls", PARTS)
def test_every_number_of_the_core_is_a_field_and_reaches_it(core: Any, cls: type[Any]) -> None:
    numbers = dict(core.settings()[cls.__name__])
    others = {"method", "boxes", "vehicle_shares", "label", "props", "suburb"}
    assert set(numbers) == {f.name for f in fields(cls)} - others

    def to_core(**changes: Any) -> None:
        own, part = unchecked(cls(), **changes), PARTS[cls]
        core.SceneConfig(own if part is None else unchecked(SceneConfig(), **{part: own}))

    for name, (default, least, most, is_whole) in numbers.items():
        kind: Any = int if is_whole else float

        def filled(value: float, count: int = len(default), kind: Any = kind) -> Any:
            return tuple([kind(value)] * count) if count > 1 else kind(value)

        for limit in {least, most} - {float("inf")}:
            if name != "house_shares" or limit > 0.0:
                cls(**{name: filled(limit)})
                to_core(**{name: filled(limit)})
        with pytest.raises(CadetError, match=f"{cls.__name__}.{name}"):
            cls(**{name: filled(least - 1)})
        # The core refuses it by itself.
        for bad in [filled(least - 1), *([filled(most + 1)] if most < float("inf") else [])]:
            with pytest.raises(CadetError, match=name):
                to_core(**{name: bad})
        if default:
            with pytest.raises(CadetError, match=name):
                to_core(**{name: (*default, *default)})


@pytest.mark.parametrize("cls", PARTS)
def test_the_defaults_are_the_cores(core: Any, cls: type[Any]) -> None:
    literal = {f.name: f.default for f in fields(cls)}
    for name, (default, _, _, is_whole) in core.settings()[cls.__name__]:
        value = literal[name]
        values = [] if value is None else [value] if not isinstance(value, tuple) else list(value)
        assert values == default, name
        assert all(isinstance(number, int if is_whole else float) for number in values), name
