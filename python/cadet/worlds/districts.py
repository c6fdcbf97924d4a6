"""Kinds of neighborhood: what a policy draws a scene's numbers from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any, Final

from cadet._util.checks import check_kind, check_range, check_text, make_plain
from cadet._util.toml_file import NamedFile
from cadet.worlds.config import PropConfig, SuburbConfig, as_vehicle_shares, scene_limits


@dataclass(frozen=True, kw_only=True)
class District(NamedFile):
    """A kind of neighborhood: ranges (low, high) that a scene's numbers are drawn from, both ends included.

    `num_cars=(5, 5)` draws nothing: every scene has five. `SceneConfig` has one scene's own numbers, by the same names.

    Raises:
        CadetError: an invalid range.
    """

    _KIND = "district"

    name: str
    """For the metadata."""
    parking_occupancy: tuple[float, float]
    """Share of the parking places along the ego's way that are taken; side streets are fuller."""
    num_cars: tuple[int, int]
    """Driving vehicles kept around the ego."""
    num_pedestrians: tuple[int, int]
    """Pedestrians kept around the ego."""
    num_cyclists: tuple[int, int] = (0, 0)
    """Cyclists kept around the ego."""
    num_trams: tuple[int, int] = (0, 0)
    """Trams kept around the ego where there are tracks."""
    seat_occupancy: tuple[float, float] = (0.0, 0.0)
    """Share of the seats (benches, cafes' chairs, bus stops) on which somebody sits."""
    vehicle_shares: Mapping[str, float] | None = field(default=None, hash=False)
    """Weights of the classes of vehicles: as `SceneConfig.vehicle_shares`."""
    suburb: SuburbConfig = SuburbConfig()
    """What kind of suburb is generated where there is no map."""
    props: PropConfig = PropConfig()
    """Houses, gardens, and trees along the streets."""

    def __post_init__(self) -> None:
        check_text("District", "name", self.name)
        for name in ("parking_occupancy", "seat_occupancy"):
            check_range("District", name, getattr(self, name), *scene_limits(name))
        for name in ("num_cars", "num_pedestrians", "num_cyclists", "num_trams"):
            check_range("District", name, getattr(self, name), *scene_limits(name), whole=True)
        object.__setattr__(self, "vehicle_shares", as_vehicle_shares("District", self.vehicle_shares))
        check_kind("District", "suburb", self.suburb, SuburbConfig)
        check_kind("District", "props", self.props, PropConfig)
        make_plain(self)

    @classmethod
    def _presets(cls) -> Mapping[str, Callable[[], District]]:
        return {name: partial(_BY_NAME.__getitem__, name) for name in DISTRICTS}

    def to_dict(self) -> dict[str, Any]:
        """Return the district in plain values, for a manifest: what is not the default of the last three."""
        values = asdict(self)
        for name, default in (("vehicle_shares", None), ("suburb", SuburbConfig()), ("props", PropConfig())):
            if getattr(self, name) == default:
                del values[name]
        return values


# Kinds of street by how often KITTI's object frames show them; streets vary around the town's occupancy. Three frames
# in four of KITTI show no pedestrian, a few show nine: so most districts have few, and some have many.
KITTI_DISTRICTS = (
    (
        District(
            name="parked_rows",
            parking_occupancy=(0.5, 1.0),
            num_cars=(13, 21),
            num_pedestrians=(8, 14),
            num_cyclists=(0, 6),
            seat_occupancy=(0.0, 0.2),
            suburb=SuburbConfig(cycle_lane_share=0.25, roundabout_share=0.06),
        ),
        0.41,
    ),
    (
        District(
            name="quiet",
            parking_occupancy=(0.3, 0.5),
            num_cars=(12, 19),
            num_pedestrians=(3, 8),
            num_cyclists=(0, 3),
            suburb=SuburbConfig(cycle_lane_share=0.2, roundabout_share=0.06),
        ),
        0.13,
    ),
    (
        District(
            name="main_road",
            parking_occupancy=(0.3, 0.75),
            num_cars=(32, 50),
            num_pedestrians=(8, 14),
            num_cyclists=(0, 8),
            num_trams=(2, 4),
            seat_occupancy=(0.0, 0.2),
            suburb=SuburbConfig(
                main_share=1.0,
                cycle_lane_share=0.35,
                signal_share=0.7,
                tram_share=1.0,
                blocks=(3, 2),
                block_m=(85.0, 160.0),
            ),
            props=PropConfig(city_share=0.2),
        ),
        0.28,
    ),
    (
        District(
            name="school_way",
            parking_occupancy=(0.3, 0.6),
            num_cars=(8, 16),
            num_pedestrians=(24, 40),
            num_cyclists=(3, 9),
            seat_occupancy=(0.1, 0.4),
            suburb=SuburbConfig(cycle_lane_share=0.3, roundabout_share=0.06),
        ),
        0.05,
    ),
    (
        District(
            name="inner_city",
            parking_occupancy=(0.4, 0.7),
            num_cars=(12, 24),
            num_pedestrians=(60, 120),
            num_cyclists=(4, 12),
            seat_occupancy=(0.3, 0.7),
            suburb=SuburbConfig(sidewalk_m=(2.2, 3.8), cycle_lane_share=0.3, signal_share=0.6),
            props=PropConfig(clutter=1.5, city_share=0.95),
        ),
        0.06,
    ),
    # The edge of town and beyond: one lane a direction between fields and woods.
    (
        District(
            name="country_road",
            parking_occupancy=(0.0, 0.5),
            num_cars=(16, 28),
            num_pedestrians=(0, 0),
            num_cyclists=(0, 2),
            suburb=SuburbConfig(country_share=1.0, blocks=(2, 2), block_m=(240.0, 350.0)),
            props=PropConfig(greenery=1.1),
        ),
        0.07,
    ),
)

# Rows of bays along aisles, seen from within, and beside the streets that lead there.
_CAR_PARK = District(
    name="car_park",
    parking_occupancy=(0.3, 0.85),
    num_cars=(8, 16),
    num_pedestrians=(14, 30),
    num_cyclists=(0, 3),
    suburb=SuburbConfig(aisle_share=0.75, blocks=(3, 2), block_m=(95.0, 135.0), hilly_share=0.0),
    props=PropConfig(car_park_share=0.9, greenery=0.9, clutter=0.8),
)

# Works, offices, and their yards.
_INDUSTRIAL = District(
    name="industrial",
    parking_occupancy=(0.3, 0.7),
    num_cars=(14, 24),
    num_pedestrians=(2, 7),
    num_cyclists=(0, 3),
    suburb=SuburbConfig(
        industrial_share=1.0,
        blocks=(2, 2),
        block_m=(110.0, 160.0),
        parking_share=0.3,
        hilly_share=0.0,
        signal_share=0.3,
    ),
    props=PropConfig(industrial_share=0.95, greenery=0.8),
)

# Paved lanes without curbs between institutes.
_CAMPUS = District(
    name="campus",
    parking_occupancy=(0.3, 0.6),
    num_cars=(3, 7),
    num_pedestrians=(60, 110),
    num_cyclists=(6, 14),
    seat_occupancy=(0.3, 0.7),
    suburb=SuburbConfig(campus_share=1.0, blocks=(3, 3), block_m=(80.0, 130.0), hilly_share=0.0),
    props=PropConfig(campus_share=0.95, greenery=1.2),
)

# Two carriageways in open country.
_MOTORWAY = District(
    name="motorway",
    parking_occupancy=(0.0, 0.0),
    num_cars=(24, 44),
    num_pedestrians=(0, 0),
    suburb=SuburbConfig(motorway_share=1.0),
    props=PropConfig(greenery=1.1),
)

# Known by name alone: KITTI's policy draws none of them.
NAMED_DISTRICTS: Final = (_CAR_PARK, _INDUSTRIAL, _CAMPUS, _MOTORWAY)

_BY_NAME: Final = {district.name: district for district in (*(one for one, _ in KITTI_DISTRICTS), *NAMED_DISTRICTS)}
DISTRICTS: Final = tuple(_BY_NAME)
"""The names that `District.named` knows."""
