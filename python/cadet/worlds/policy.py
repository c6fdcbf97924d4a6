"""Draws of each reset: map, weather, how full the streets are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from cadet._util.checks import (
    MAX_EPISODE,
    Limits,
    as_pairs,
    as_seed,
    as_tuple,
    check_fields,
    check_kind,
    check_number,
    check_range,
    check_text,
    make_plain,
    shown,
)
from cadet._util.plain_tables import check_keys
from cadet._util.summary import summary
from cadet._util.toml_file import NamedFile
from cadet.errors import CadetError
from cadet.sensors.rig import Rig
from cadet.worlds.assets import Assets
from cadet.worlds.config import (
    LabelConfig,
    PropConfig,
    SceneConfig,
    scene_limits,
)
from cadet.worlds.districts import KITTI_DISTRICTS, District
from cadet.worlds.draws import Draws
from cadet.worlds.policy_table import changed, keys_of_policy, table_of_policy
from cadet.worlds.props import Props
from cadet.worlds.road_map import RoadMap
from cadet.worlds.weather import Weather, as_weather, table_of_weathers, weather_names

STEPS_PER_S = 60
"""Steps of physics a second."""
POLICIES = ("kitti", "paper")
"""The names that `ResetPolicy.named` knows."""


@dataclass(frozen=True)
class EpisodeSpec:
    """One draw of a policy: all that a scene is made from."""

    seed: int
    """The dataset's seed."""
    episode: int
    """The episode: one reset and its samples."""
    attempt: int
    """How often the world was redrawn inside the episode."""
    district: str
    """The district's name."""
    road_map: RoadMap | None
    """The map; None for a generated suburb."""
    weather: Weather
    """In numbers."""
    config: SceneConfig
    """How full the scene is, and what gets a label."""
    rig: Rig
    """The sensors, as they sit on a car that stands level."""
    car_pitch_deg: float = 0.0
    """How much deeper the ego stands in front than behind, by its load."""
    assets: Assets | None = None
    """The user's own meshes and props."""
    given: frozenset[str] = frozenset()
    """The fields of `config` that were given, not drawn: what of them can't be met is said."""

    @property
    def mounted_rig(self) -> Rig:
        """The sensors as they stand on the car with its load."""
        return self.rig.pitched(self.car_pitch_deg)


@dataclass(frozen=True, kw_only=True)
class ResetPolicy(NamedFile):
    """How the world is drawn at each reset, and how samples follow each other.

    Raises:
        CadetError: a number outside its range, no district, or an unknown weather.
    """

    _KIND = "policy"

    name: str = "custom"
    """For the metadata."""
    samples_per_episode: Annotated[int, Limits(1, 100_000)] = 20
    """Samples between two resets."""
    distance_m: Annotated[float, Limits(0, 1000)] = 10.0
    """How far the ego drives along its lane between two views."""
    time_step_s: float | None = None
    """Samples of an episode follow each other after this time, whatever they show, in place of a distance."""
    blocked_s: Annotated[float, Limits(0.1, 600)] = 2.0
    """A view is taken all the same once the ego has stood this long."""
    empty_views_limit: Annotated[int, Limits(1, 100_000)] = 10
    """After so many views in a row without a labeled object, or without motion since the view before, the world is
    redrawn inside the episode."""
    attempts_limit: Annotated[int, Limits(1, 100_000)] = 50
    """After so many redrawn worlds an episode is given up with an error."""
    maps: tuple[RoadMap, ...] = ()
    """One is drawn, all equally likely; none means suburbs generated from the seed."""
    weathers: tuple[tuple[Weather, float], ...]
    """Weathers of different names, or presets by name, with their weights."""
    districts: tuple[tuple[District, float], ...]
    """Districts with their weights."""
    rigs: tuple[tuple[Rig, float], ...] = ((Rig.kitti(), 1.0),)
    """Rigs of different names with their weights, the most usual one first; one is drawn for each episode."""
    car_pitch_sd_deg: Annotated[float, Limits(0, 5)] = 0.0
    """How much the ego's pitch differs between episodes, by its load: a standard deviation."""
    sun_elevation_deg: tuple[float, float] | None = None
    """Range that the sun's height over the horizon is drawn from; the weather's own if None."""
    label: LabelConfig = LabelConfig()
    """What gets a label."""
    assets: Assets | None = None
    """The user's own meshes, whose vehicles are mixed into the traffic, and props, placed among the others."""

    def __repr__(self) -> str:
        return summary(
            self,
            f"{len(self.maps)} maps",
            f"{len(self.weathers)} weathers",
            name=self.name,
            samples_per_episode=self.samples_per_episode,
            distance_m=self.distance_m,
            districts=[district.name for district, _ in self.districts],
            rigs=[rig.name for rig, _ in self.rigs],
        )

    def __post_init__(self) -> None:
        check_text("ResetPolicy", "name", self.name)
        check_kind("ResetPolicy", "label", self.label, LabelConfig)
        if self.assets is not None and not isinstance(self.assets, Assets):
            raise CadetError(f"ResetPolicy.assets: expected cadet.Assets, got {shown(self.assets)}")
        check_fields(self)
        _check_time_step(self.time_step_s)
        _check_sun(self.sun_elevation_deg)
        for name in ("weathers", "districts", "rigs"):
            pairs = as_pairs("ResetPolicy", name, getattr(self, name), "of one of them and its weight")
            object.__setattr__(self, name, pairs)
            if not pairs:
                raise CadetError(f"ResetPolicy.{name}: expected at least one, got none")
            for _, weight in pairs:
                check_number("ResetPolicy", f"{name} weight", weight, 0, 1e9)
            if sum(weight for _, weight in pairs) <= 0:
                raise CadetError(f"ResetPolicy.{name}: expected a weight above 0, got none")
        weathers = tuple((as_weather(weather), weight) for weather, weight in self.weathers)
        object.__setattr__(self, "weathers", weathers)
        if len({weather.name for weather, _ in weathers}) < len(weathers):
            raise CadetError("ResetPolicy.weathers: expected weathers of different names")
        for district, _ in self.districts:
            check_kind("ResetPolicy", "districts", district, District)
        for rig, _ in self.rigs:
            check_kind("ResetPolicy", "rigs", rig, Rig)
        object.__setattr__(self, "maps", as_tuple("ResetPolicy", "maps", self.maps, "RoadMap"))
        for road_map in self.maps:
            check_kind("ResetPolicy", "maps", road_map, RoadMap)
        make_plain(self)
        names = [rig.name for rig, _ in self.rigs]
        if len(set(names)) < len(names):
            raise CadetError(f"ResetPolicy.rigs: expected different names, got {', '.join(names)}")

    @classmethod
    def kitti(cls) -> ResetPolicy:
        """KITTI's streets, cars and light: sunny to overcast, a tenth of the episodes in bad weather.

        Each episode has one of KITTI's four calibrations, as often as KITTI's frames have.
        """
        return cls(
            name="kitti",
            # So long that red lights do not fill the set with one view.
            blocked_s=6.0,
            weathers=tuple((Weather.preset(name), weight) for name, weight in _KITTI_WEATHERS),
            districts=KITTI_DISTRICTS,
            rigs=Rig.every_kitti(),
            car_pitch_sd_deg=_KITTI_CAR_PITCH_SD_DEG,
        )

    @classmethod
    def paper(cls) -> ResetPolicy:
        """The 2019 paper's resets and rig: cars and pedestrians alone, exact boxes, all weathers of the day alike.

        As in the paper's 10,000 frames, 1.4 cars and 0.49 pedestrians are labeled in a frame.
        """
        return cls(
            name="paper",
            label=LabelConfig(boxes="exact"),
            weathers=tuple((Weather.preset(name), 1.0) for name in weather_names() if not name.endswith("_night")),
            # In CARLA's towns of that time every car drove, and little stood about.
            districts=(
                (
                    District(
                        name="town",
                        parking_occupancy=(0.0, 0.0),
                        num_cars=(4, 19),
                        num_pedestrians=(0, 7),
                        vehicle_shares={"Car": 1.0},
                        props=PropConfig(clutter=0.0),
                    ),
                    1.0,
                ),
            ),
            rigs=((Rig.paper(), 1.0),),
        )

    @classmethod
    def _presets(cls) -> Mapping[str, Callable[[], ResetPolicy]]:
        return {"kitti": cls.kitti, "paper": cls.paper}

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> ResetPolicy:
        check_keys(table, cls._keys())
        changes = {key: value for key, value in table.items() if key != "policy"}
        try:
            policy = cls.named(table.get("policy", "kitti"), folder=folder)
        except CadetError as error:
            raise CadetError(f"policy: {error}") from None
        return changed(policy, changes, folder)

    @classmethod
    def _keys(cls) -> tuple[str, ...]:
        """Return the keys of a file, that of the policy that it changes first."""
        return ("policy", *keys_of_policy(cls))

    def _table(self) -> dict[str, Any]:
        return table_of_policy(self)

    def as_sequence(self, *, hz: float = 2.0, length_s: float = 20.0) -> ResetPolicy:
        """Return the policy with episodes of `length_s` seconds, in which `hz` samples a second are taken.

        The first sample shows a labeled object; the others show what is there.

        Raises:
            CadetError: a rate that does not divide the 60 steps of a second, or a length without a sample.
        """
        check_number("", "hz", hz, 1 / 600, STEPS_PER_S)
        check_number("", "length_s", length_s, 0, 36_000)
        steps = STEPS_PER_S / hz
        if abs(steps - round(steps)) > 1e-6:
            raise CadetError(f"hz: expected a rate that divides the {STEPS_PER_S} steps of a second, got {hz:g}")
        count = int(length_s * hz + 1e-6)
        if count < 1:
            raise CadetError(f"length_s: expected at least {1 / hz:g} s for a sample, got {length_s:g}")
        return replace(self, time_step_s=round(steps) / STEPS_PER_S, samples_per_episode=count)

    def with_rig(self, rig: Rig) -> ResetPolicy:
        """Return the policy with this rig in every episode.

        Raises:
            CadetError: it is no rig.
        """
        check_kind("", "rig", rig, Rig)
        return replace(self, rigs=((rig, 1.0),))

    def with_districts(self, *districts: District | str | Path) -> ResetPolicy:
        """Return the policy with these districts, as objects, names, or files, all equally likely.

        Raises:
            CadetError: none, or what is no district.
        """
        given = (District.named(each) if isinstance(each, str | Path) else each for each in districts)
        return replace(self, districts=tuple((district, 1.0) for district in given))

    def with_each_district(self, change: Callable[[District], District]) -> ResetPolicy:
        """Return the policy with each of its districts changed."""
        return replace(self, districts=tuple((change(district), weight) for district, weight in self.districts))

    def with_weathers(self, *weathers: Weather | str) -> ResetPolicy:
        """Return the policy with these weathers, presets by name, all equally likely.

        Raises:
            CadetError: none, or what is no weather.
        """
        return replace(self, weathers=tuple((as_weather(weather), 1.0) for weather in weathers))

    def with_each_rig(self, change: Callable[[Rig], Rig]) -> ResetPolicy:
        """Return the policy with each of its rigs changed."""
        return replace(self, rigs=tuple((change(rig), weight) for rig, weight in self.rigs))

    def draw(self, seed: int, episode: int, attempt: int = 0) -> EpisodeSpec:
        """Draw the world of an episode: a pure function of the policy and the three numbers.

        Raises:
            CadetError: an invalid seed, or an episode or attempt that is not a whole number from 0 to `MAX_EPISODE`.
        """
        seed = as_seed(seed)
        # Larger ones would share streams with other seeds: `Draws` puts all numbers into one row of 32-bit words.
        check_number("", "episode", episode, 0, MAX_EPISODE, whole=True)
        check_number("", "attempt", attempt, 0, MAX_EPISODE, whole=True)
        episode, attempt = int(episode), int(attempt)
        weather = Draws(seed, episode, attempt, "weather").weighted(self.weathers)
        weather = weather._drawn(Draws(seed, episode, attempt, "weather numbers"))
        district = Draws(seed, episode, attempt, "district").weighted(self.districts)
        map_index = Draws(seed, episode, attempt, "map").count(0, len(self.maps) - 1) if self.maps else None
        counts = Draws(seed, episode, attempt, "counts")
        # Car and rig stay the same however often the world is redrawn.
        rig = Draws(seed, episode, 0, "calibration").weighted(self.rigs)
        load = Draws(seed, episode, 0, "load")
        sun = None
        if self.sun_elevation_deg is not None:
            sun = Draws(seed, episode, attempt, "sun").between(*self.sun_elevation_deg)
        config = SceneConfig(
            parking_occupancy=counts.between(*district.parking_occupancy),
            num_cars=counts.count(*district.num_cars),
            num_pedestrians=counts.count(*district.num_pedestrians),
            num_cyclists=Draws(seed, episode, attempt, "cyclists").count(*district.num_cyclists),
            num_trams=Draws(seed, episode, attempt, "trams").count(*district.num_trams),
            seat_occupancy=Draws(seed, episode, attempt, "seats").between(*district.seat_occupancy),
            vehicle_shares=district.vehicle_shares,
            suburb=district.suburb,
            props=district.props,
            sun_elevation_deg=sun,
            label=self.label,
        )
        return EpisodeSpec(
            seed=seed,
            episode=episode,
            attempt=attempt,
            district=district.name,
            road_map=None if map_index is None else self.maps[map_index],
            weather=weather,
            config=weather._sun_of(config),
            rig=rig,
            car_pitch_deg=round(self.car_pitch_sd_deg * load.bell(), 6),
            assets=self.assets,
        )

    def with_props(self, props: Props) -> ResetPolicy:
        """Return the policy with a user's own props beside its meshes."""
        return replace(self, assets=replace(self.assets or Assets(props=props), props=props))

    def to_dict(self) -> dict[str, Any]:
        """Return the policy in plain values, maps and assets by name and hash, for a manifest."""
        values = asdict(replace(self, assets=None))
        values["rigs"] = {rig.name: weight for rig, weight in self.rigs}
        for name in ("time_step_s", "sun_elevation_deg"):
            if values[name] is None:
                del values[name]
        if self.assets is None:
            del values["assets"]
        else:
            values["assets"] = self.assets.to_dict()
        values["maps"] = [{"name": m.name, "sha256": m.sha256} for m in self.maps]
        values["districts"] = [{**district.to_dict(), "weight": weight} for district, weight in self.districts]
        values["weathers"] = table_of_weathers(self.weathers)
        return values


def _check_time_step(time_step_s: float | None) -> None:
    if time_step_s is None:
        return
    check_number("ResetPolicy", "time_step_s", time_step_s, 1 / STEPS_PER_S, 600)
    steps = float(time_step_s) * STEPS_PER_S
    if abs(steps - round(steps)) > 1e-6:
        raise CadetError(f"ResetPolicy.time_step_s: expected whole steps of 1/60 s, got {time_step_s:g}")


def _check_sun(elevation_deg: tuple[float, float] | None) -> None:
    if elevation_deg is not None:
        check_range("ResetPolicy", "sun_elevation_deg", elevation_deg, *scene_limits("sun_elevation_deg"))


# The mean pitch of KITTI's camera, by the bottoms of the labeled boxes, differs by this much between the drives of
# 2011_09_26, the error of each mean taken off.
_KITTI_CAR_PITCH_SD_DEG = 0.12

# Nine tenths dry, a third of them overcast; the rest is what KITTI lacks.
_KITTI_WEATHERS = (
    ("clear_noon", 0.56),
    ("cloudy_noon", 0.20),
    ("clear_sunset", 0.07),
    ("cloudy_sunset", 0.07),
    ("wet_noon", 0.02),
    ("wet_cloudy_noon", 0.02),
    ("soft_rain_noon", 0.02),
    ("mid_rain_noon", 0.01),
    ("hard_rain_noon", 0.005),
    ("light_fog", 0.01),
    ("dense_fog", 0.005),
    ("snow", 0.005),
    ("dusk", 0.005),
)
