"""Kinds of neighborhood: what a policy draws a scene's numbers from."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Final

from cadet.checks import check_kind, check_range, check_text, is_one_of, make_plain, shown
from cadet.config import PropConfig, SuburbConfig, scene_limits
from cadet.errors import CadetError


@dataclass(frozen=True, kw_only=True)
class District:
    """A kind of neighborhood: ranges that a scene's numbers are drawn from, both ends included.

    Raises:
        CadetError: a range that is none.
    """

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
        check_kind("District", "suburb", self.suburb, SuburbConfig)
        check_kind("District", "props", self.props, PropConfig)
        make_plain(self)

    @classmethod
    def named(cls, name: str) -> District:
        """Return the district of that name, one of `DISTRICTS`.

        Raises:
            CadetError: there is none.
        """
        if not is_one_of(name, _BY_NAME):
            raise CadetError(f"unknown district {shown(name)}; known: {', '.join(DISTRICTS)}")
        return _BY_NAME[name]

    def to_dict(self) -> dict[str, Any]:
        """Return the district in plain values, for a manifest: `suburb` and `props` where they are not the default."""
        values = asdict(self)
        for name, default in (("suburb", SuburbConfig()), ("props", PropConfig())):
            if getattr(self, name) == default:
                del values[name]
        return values


# Kinds of street by how often KITTI's object frames show them; streets vary around the town's occupancy. Three frames
# in four of KITTI show no pedestrian, a few show nine: so most districts have few, and some have many.
KITTI_DISTRICTS = (
    (
        District(
            name="parked_rows",
            parking_occupancy=(0.45, 0.95),
            num_cars=(13, 21),
            num_pedestrians=(8, 14),
            num_cyclists=(0, 6),
            seat_occupancy=(0.0, 0.2),
        ),
        0.38,
    ),
    (
        District(
            name="quiet", parking_occupancy=(0.3, 0.5), num_cars=(12, 19), num_pedestrians=(3, 8), num_cyclists=(0, 3)
        ),
        0.20,
    ),
    (
        District(
            name="main_road",
            parking_occupancy=(0.3, 0.75),
            num_cars=(32, 50),
            num_pedestrians=(8, 14),
            num_cyclists=(0, 8),
            num_trams=(2, 4),
            seat_occupancy=(0.0, 0.3),
            suburb=SuburbConfig(main_share=1.0, signal_share=0.7, tram_share=1.0, blocks=(3, 2), block_m=(85.0, 160.0)),
            props=PropConfig(city_share=0.2),
        ),
        0.30,
    ),
    (
        District(
            name="school_way",
            parking_occupancy=(0.3, 0.6),
            num_cars=(8, 16),
            num_pedestrians=(24, 40),
            num_cyclists=(3, 9),
            seat_occupancy=(0.1, 0.4),
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
            suburb=SuburbConfig(sidewalk_m=(2.2, 3.8), signal_share=0.6),
            props=PropConfig(clutter=1.5, city_share=0.95),
        ),
        0.07,
    ),
)

# Beyond the towns; KITTI's policy draws neither. One lane a direction between fields and woods:
_COUNTRY_ROAD = District(
    name="country_road",
    parking_occupancy=(0.0, 0.5),
    num_cars=(8, 15),
    num_pedestrians=(0, 0),
    num_cyclists=(0, 1),
    suburb=SuburbConfig(country_share=1.0, blocks=(2, 2), block_m=(240.0, 350.0)),
    props=PropConfig(greenery=1.1),
)
# Two carriageways with two or three lanes each, and nobody on foot:
_MOTORWAY = District(
    name="motorway",
    parking_occupancy=(0.0, 0.0),
    num_cars=(24, 44),
    num_pedestrians=(0, 0),
    suburb=SuburbConfig(motorway_share=1.0),
    props=PropConfig(greenery=1.1),
)
_OTHERS = (_COUNTRY_ROAD, _MOTORWAY)

_BY_NAME: Final = {district.name: district for district in (*(one for one, _ in KITTI_DISTRICTS), *_OTHERS)}
DISTRICTS: Final = tuple(_BY_NAME)
"""The names that `District.named` knows."""
