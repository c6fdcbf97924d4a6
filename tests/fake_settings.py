"""The fake core's configurations, with the numbers of the real one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, ClassVar

_INF = float("inf")
# Name, default, least and greatest value; counts have whole defaults.
_LABEL = {
    "min_height_px": (15.0, 0, _INF),
    "min_visible_fraction": (0.1, 0, 1),
    "max_depth_m": (80.0, 0, _INF),
    "min_depth_m": (0.5, 0, _INF),
    "max_truncation": (0.95, 0, 1),
    "min_contrast": (0.05, 0, 1),
    "min_points": (0, 0, 1e6),
    "dontcare_min_pixels": (8.0, 0, _INF),
    "occlusion_levels": ([0.8, 0.5], 0, 1),
    "corner_tolerance_m": (0.1, 0, _INF),
    "max_hidden_corners": (4, 1, 8),
}
_SUBURB = {
    "blocks": ([4, 4], 2, 12),
    "block_m": ([72.0, 112.0], 60, 350),
    "parking_share": (0.55, 0, 1),
    "angled_share": (0.3, 0, 1),
    "main_share": (0.0, 0, 1),
    "cycle_lane_share": (0.0, 0, 1),
    "sidewalk_m": ([1.5, 2.5], 1.2, 4.5),
    "signal_share": (0.0, 0, 1),
    "roundabout_share": (0.0, 0, 1),
    "tram_share": (0.0, 0, 1),
    "country_share": (0.0, 0, 1),
    "aisle_share": (0.0, 0, 1),
    "industrial_share": (0.0, 0, 1),
    "campus_share": (0.0, 0, 1),
    "motorway_share": (0.0, 0, 1),
    "hilly_share": (0.2, 0, 1),
    "max_slope": (0.065, 0, 0.1),
}
_PROPS = {
    "house_shares": ([0.35, 0.15, 0.15, 0.15, 0.08, 0.12], 0, 1e6),
    "greenery": (1.0, 0, 2),
    "belt_m": (40.0, 0, 120),
    "clutter": (1.0, 0, 3),
    "city_share": (0.0, 0, 1),
    "car_park_share": (0.0, 0, 1),
    "industrial_share": (0.0, 0, 1),
    "campus_share": (0.0, 0, 1),
}
_SCENE = {
    "num_cars": (14, 0, 500),
    "num_pedestrians": (24, 0, 500),
    "num_cyclists": (0, 0, 200),
    "num_trams": (0, 0, 20),
    "parking_occupancy": (0.6, 0, 1),
    "seat_occupancy": (0.1, 0, 1),
    "car_radius_m": (110.0, 1, 1000),
    "pedestrian_radius_m": (80.0, 1, 1000),
    "cyclist_radius_m": (70.0, 1, 1000),
    "parking_radius_m": (280.0, 1, 1000),
    "sun_elevation_deg": ([], 3, 90),
    "sun_azimuth_deg": ([], -360, 360),
}
_LIMITS = {
    "columns": (1.0, 65535.0),
    "divergence_mrad": (0.0, 20.0),
    "image_side_px": (16.0, 8192.0),
    "lateral_m": (-5.0, 5.0),
    "rolling_shutter_s": (0.0, 0.1),
    "speed_mps": (0.0, 70.0),
    "step_s": (0.0, 3600.0),
}


def limits() -> dict[str, tuple[float, float]]:
    return dict(_LIMITS)


class _Config(SimpleNamespace):
    numbers: ClassVar[dict[str, Any]]

    def __init__(self, **values: Any) -> None:
        assert set(self.numbers) <= set(values)
        super().__init__(**values)

    @classmethod
    def settings(cls) -> list[tuple[str, tuple[list[float], float, float, bool]]]:
        found = []
        for name, (default, least, most) in cls.numbers.items():
            defaults = default if isinstance(default, list) else [default]
            is_whole = bool(defaults) and isinstance(defaults[0], int)
            found.append((name, ([float(d) for d in defaults], float(least), float(most), is_whole)))
        return found


class LabelConfig(_Config):
    numbers = _LABEL


class SuburbConfig(_Config):
    numbers = _SUBURB


class PropConfig(_Config):
    numbers = _PROPS


class SceneConfig(_Config):
    numbers = _SCENE

    @staticmethod
    def vehicle_classes() -> list[str]:
        return ["Car", "Van", "Truck", "Misc"]
