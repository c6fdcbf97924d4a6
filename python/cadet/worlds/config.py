"""What a scene contains and what gets a label: frozen, checked when made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, TypeVar

from cadet import _cadet
from cadet._util.checks import check_kind, check_number, is_one_of, make_plain, shown
from cadet._util.plain_tables import table_of_object
from cadet._util.summary import summary
from cadet._util.toml_file import TomlFile
from cadet.errors import CadetError

VEHICLE_CLASSES = tuple(_cadet.SceneConfig.vehicle_classes())
"""KITTI's classes of vehicles that drive and park."""
MAX_WEIGHT = 1e9
_SETTINGS = _cadet.settings()


class _Numbers:
    """A configuration's numbers as the core states them: how many there are, limits, and whether they count."""

    def __init__(self, owner: str) -> None:
        self._owner, self._settings = owner, dict(_SETTINGS[owner])

    def limits(self, name: str) -> tuple[float, float]:
        """Return a number's least and greatest value, as messages show them: 8 for 8.0."""
        _, least, most, _ = self._settings[name]
        return _shortest(least), _shortest(most)

    def check(self, config: Any) -> None:
        """Refuse numbers outside their limits."""
        for name, (default, _, _, is_whole) in self._settings.items():
            value = getattr(config, name)
            if not default and value is None:
                continue
            if len(default) > 1 and (not isinstance(value, tuple) or len(value) != len(default)):
                raise CadetError(f"{self._owner}.{name}: expected {len(default)} numbers, got {shown(value)}")
            for number in value if len(default) > 1 else (value,):
                check_number(self._owner, name, number, *self.limits(name), whole=is_whole)


def _shortest(limit: float) -> float:
    return int(limit) if limit.is_integer() else limit


_LABEL = _Numbers("LabelConfig")
_PROPS = _Numbers("PropConfig")
_SCENE = _Numbers("SceneConfig")
_SUBURB = _Numbers("SuburbConfig")
scene_limits = _SCENE.limits


_Config = TypeVar("_Config", bound="_Overrides")


class _Overrides(TomlFile):
    """A configuration that remembers which of its fields were given, so that the others can be drawn."""

    given: frozenset[str]

    def __new__(cls, **given: object) -> Any:
        self = super().__new__(cls)
        object.__setattr__(self, "given", frozenset(given))
        return self

    def _table(self) -> dict[str, Any]:
        return {name: value for name, value in table_of_object(self).items() if name in self.given}

    def over(self: _Config, drawn: _Config) -> _Config:
        """Return `drawn` with what was given here in its place; configurations in it are merged alike."""
        changes = {}
        for name in self.given:
            own, other = getattr(self, name), getattr(drawn, name)
            changes[name] = own.over(other) if isinstance(own, _Overrides) else own
        return replace(drawn, **changes)  # type: ignore[type-var]


@dataclass(frozen=True, kw_only=True)
class LabelConfig(_Overrides):
    """Every number of the labels' definitions; the core states their limits.

    Raises:
        CadetError: a number outside its range, or an unknown method.
    """

    method: Literal["pixels", "corners"] = "pixels"
    """How occlusion is measured: visible over silhouette pixels, or box corners against the depth map (the paper's)."""
    boxes: Literal["kitti", "exact"] = "kitti"
    """Which boxes labels hold: what KITTI's annotators would have drawn, or the extents of the body.

    Annotators' boxes are a little shorter than the vehicle, their bottoms a little over the ground, and their sizes
    are distributed as KITTI's; an actor keeps its box through an episode."""
    min_height_px: float = 15.0
    """A label's 2D box is at least this high, in the image before it is resized (`Camera.resized`, `--image-size`)."""
    min_visible_fraction: float = 0.1
    """A label's object shows at least this fraction of its silhouette."""
    max_depth_m: float = 80.0
    """A label's object is at most this deep."""
    min_depth_m: float = 0.5
    """A label's object is at least this deep."""
    max_truncation: float = 0.95
    """A label's object is truncated by at most this."""
    min_contrast: float = 0.05
    """An object without returns keeps at least this much of its contrast through fog, rain and snow to get a label."""
    min_points: int = 0
    """A label's object has at least this many returns."""
    dontcare_min_pixels: float = 8.0
    """An object without a label becomes DontCare if it shows at least this many pixels, in the image before it is
    resized."""
    occlusion_levels: tuple[float, float] = (0.8, 0.5)
    """Visible fractions from which `occluded` is 0 and 1; below the second it is 2."""
    corner_tolerance_m: float = 0.1
    """A corner is hidden by what is nearer than it by more than this."""
    max_hidden_corners: int = 4
    """With this many hidden corners an object is occluded (method "corners")."""

    def scaled(self, image_scale: tuple[float, float]) -> LabelConfig:
        """Return the limits for an image that was stretched: heights follow its rows, counts of pixels its area.

        Args:
            image_scale: factors along the rows and the columns, as in `Camera.image_scale`.
        """
        x, y = image_scale
        return replace(
            self, min_height_px=self.min_height_px * y, dontcare_min_pixels=self.dontcare_min_pixels * (x * y)
        )

    def __post_init__(self) -> None:
        if not is_one_of(self.method, ("pixels", "corners")):
            raise CadetError(f"LabelConfig.method: expected 'pixels' or 'corners', got {shown(self.method)}")
        if not is_one_of(self.boxes, ("kitti", "exact")):
            raise CadetError(f"LabelConfig.boxes: expected 'kitti' or 'exact', got {shown(self.boxes)}")
        _LABEL.check(self)
        levels = self.occlusion_levels
        if levels[0] < levels[1]:
            raise CadetError(f"LabelConfig.occlusion_levels: expected the first to be the larger, got {levels!r}")
        make_plain(self)


def as_vehicle_shares(owner: str, shares: object) -> dict[str, float] | None:
    """Return weights of vehicle classes in a dictionary of their own; None, for KITTI's mix, stays None.

    Raises:
        CadetError: an unknown class, a weight that is none, or neither cars nor vans, which alone fit everywhere.
    """
    if shares is None:
        return None
    names = ", ".join(VEHICLE_CLASSES)
    if not isinstance(shares, Mapping) or not all(is_one_of(name, VEHICLE_CLASSES) for name in shares):
        raise CadetError(
            f"{owner}.vehicle_shares: expected weights by class ({names}), such as {{'Car': 0.8, 'Van': 0.2}}, "
            f"got {shown(shares)}"
        )
    for name, weight in shares.items():
        check_number(f"{owner}.vehicle_shares", name, weight, 0, MAX_WEIGHT)
    if not any(shares.get(name, 0) for name in ("Car", "Van")):
        raise CadetError(
            f"{owner}.vehicle_shares: expected a weight above 0 of Car or Van, since the others do not fit everywhere, "
            f"got {shown(shares)}"
        )
    return {name: float(weight) for name, weight in shares.items()}


@dataclass(frozen=True, kw_only=True)
class SuburbConfig(_Overrides):
    """What kind of suburb is generated where there is no map.

    Raises:
        CadetError: a number outside its range.
    """

    blocks: tuple[int, int] = (4, 4)
    """Number of blocks from side to side, in two directions."""
    block_m: tuple[float, float] = (72.0, 112.0)
    """Shortest and longest block, meters."""
    parking_share: float = 0.55
    """Share of curbs with parking bays on streets wide enough for them."""
    angled_share: float = 0.3
    """Share of the streets with bays where cars stand at an angle in some of them."""
    main_share: float = 0.0
    """Share of the streets faster than 30 km/h that are main roads: two lanes a direction, a green median, or both."""
    cycle_lane_share: float = 0.0
    """Share of the streets faster than 30 km/h with a lane for bicycles on both sides of the carriageway."""
    sidewalk_m: tuple[float, float] = (1.5, 2.5)
    """Narrowest and widest sidewalk of streets other than main roads, meters."""
    signal_share: float = 0.0
    """Share of the junctions of streets faster than 30 km/h that have traffic lights."""
    roundabout_share: float = 0.0
    """Share of the junctions of streets with one lane a direction that are roundabouts, in town."""
    tram_share: float = 0.0
    """Share of the main roads across a suburb with the two tracks of a tram in the middle, instead of any median."""
    country_share: float = 0.0
    """Share of suburbs that are open country: winding roads between fields and woods, without curbs or sidewalks."""
    aisle_share: float = 0.0
    """Share of the streets of 30 km/h that are aisles of car parks: bays across on both sides, 20 km/h."""
    industrial_share: float = 0.0
    """Share of the streets that are those of commercial areas: carriageways of 6.5 to 7.5 m, 50 km/h."""
    campus_share: float = 0.0
    """Share of suburbs that are campuses: lanes of 4.5 to 5 m, paved with setts, without curbs, 10 or 20 km/h."""
    motorway_share: float = 0.0
    """Share of suburbs that are a motorway or a bypass instead: two carriageways that close on themselves."""
    hilly_share: float = 0.2
    """Share of suburbs with hill streets."""
    max_slope: float = 0.065
    """Steepest slope of a hilly suburb."""

    def __post_init__(self) -> None:
        _SUBURB.check(self)
        for name in ("block_m", "sidewalk_m"):
            least, most = getattr(self, name)
            if least > most:
                raise CadetError(f"SuburbConfig.{name}: expected the second to be the larger, got {(least, most)!r}")
        make_plain(self)


@dataclass(frozen=True, kw_only=True)
class PropConfig(_Overrides):
    """Houses, gardens, and trees along the streets, of generated suburbs and of maps.

    Raises:
        CadetError: a number outside its range, or house shares that are all 0.
    """

    house_shares: tuple[float, float, float, float, float, float] = (0.35, 0.15, 0.15, 0.15, 0.08, 0.12)
    """Weights of detached and semi-detached houses, terraces, old village houses, closed blocks, and apartments."""
    greenery: float = 1.0
    """1 is a common suburb, 0 has no trees."""
    belt_m: float = 40.0
    """Depth of the belt of trees behind the outermost plots, meters."""
    clutter: float = 1.0
    """What stands about: bins, containers, bicycles, benches, covered cars. 1 is a common suburb, 0 has none."""
    city_share: float = 0.0
    """Share of the streets lined by closed rows of tall houses at the sidewalk, with shops."""
    car_park_share: float = 0.0
    """Share of the streets beside which there are car parks, some with a market."""
    industrial_share: float = 0.0
    """Share of the other streets lined by works and offices with their yards."""
    campus_share: float = 0.0
    """Share of the other streets lined by institutes behind lawns."""

    def __post_init__(self) -> None:
        _PROPS.check(self)
        if sum(self.house_shares) <= 0:
            raise CadetError(f"PropConfig.house_shares: expected a weight above 0, got {shown(self.house_shares)}")
        make_plain(self)


@dataclass(frozen=True, kw_only=True)
class SceneConfig(_Overrides):
    """How full one scene is, what is placed in it, where its sun is, and what gets a label.

    Its fields are numbers, since a scene has one of each; the ranges that they are drawn from are a `District`'s. The
    core states the limits of all numbers. Where worlds are drawn (`Scene.random`, `Environment`,
    `stream`), only fields that were given count, those of `suburb`, `props`, and `label` one by one; all else is drawn.

    Raises:
        CadetError: a number outside its range.
    """

    num_cars: int = 14
    """Driving vehicles kept around the ego, of the classes of `vehicle_shares`: by KITTI's mix one in eleven is a van,
    and there are trucks where streets are wide.

    Where fewer find room than are asked for here, of these or of the next three, a `CadetWarning` says so."""
    num_pedestrians: int = 24
    """Pedestrians kept around the ego."""
    num_cyclists: int = 0
    """Cyclists kept around the ego: they ride on the right of driving lanes, and on a map's lanes for bicycles."""
    num_trams: int = 0
    """Trams near the ego where there are tracks (`SuburbConfig.tram_share`, or a map's), of one to three cars."""
    parking_occupancy: float = 0.6
    """Share of the parking places along the ego's way that are taken; each street varies around it.

    In side streets and drives it is this to the power of 0.35."""
    car_radius_m: float = 110.0
    """Driving vehicles start within this distance of the ego."""
    pedestrian_radius_m: float = 80.0
    """Pedestrians start within this distance of the ego."""
    cyclist_radius_m: float = 70.0
    """Cyclists start within this distance of the ego."""
    parking_radius_m: float = 280.0
    """Parking places and seats are filled within this distance of the ego."""
    seat_occupancy: float = 0.1
    """Share of the seats (benches, cafes' chairs, bus stops) on which somebody sits; there are few where
    `PropConfig.clutter` is small."""
    vehicle_shares: Mapping[str, float] | None = field(default=None, hash=False)
    """Weights of the classes of vehicles that drive and park, such as `{"Car": 0.8, "Van": 0.2}`; classes that are not
    named are left out. None mixes Car, Van, Truck, and Misc as KITTI's streets do.

    Trucks drive only where streets are wide enough, and "Misc", trailers and motorbikes, only park."""
    suburb: SuburbConfig = SuburbConfig()
    """What kind of suburb is generated where there is no map."""
    props: PropConfig = PropConfig()
    """Houses, gardens, and trees along the streets."""
    sun_elevation_deg: float | None = None
    """The sun's height over the horizon; the weather's, varied by the seed, if None."""
    sun_azimuth_deg: float | None = None
    """The sun's direction, counter-clockwise from east; drawn from the seed if None, south in `Scene.empty`."""
    label: LabelConfig = LabelConfig()
    """What gets a label."""

    def __repr__(self) -> str:
        parts = {f.name: getattr(self, f.name) for f in fields(self)}
        usual = {"suburb": SuburbConfig(), "props": PropConfig(), "label": LabelConfig()}
        return summary(self, **{name: value for name, value in parts.items() if value != usual.get(name)})

    def __post_init__(self) -> None:
        _SCENE.check(self)
        object.__setattr__(self, "vehicle_shares", as_vehicle_shares("SceneConfig", self.vehicle_shares))
        check_kind("SceneConfig", "suburb", self.suburb, SuburbConfig)
        check_kind("SceneConfig", "props", self.props, PropConfig)
        check_kind("SceneConfig", "label", self.label, LabelConfig)
        make_plain(self)

    def scaled(self, image_scale: tuple[float, float]) -> SceneConfig:
        """Return the configuration for an image that was stretched: see `LabelConfig.scaled`."""
        return replace(self, label=self.label.scaled(image_scale))

    def _to_native(self) -> _cadet.SceneConfig:
        """Return the configuration as the core takes it."""
        return _cadet.SceneConfig(self)
