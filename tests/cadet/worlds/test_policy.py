from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import CadetError, District, ResetPolicy, Rig, RoadMap, SceneConfig, weather_names
from cadet.worlds.districts import DISTRICTS
from cadet.worlds.policy_choice import draw_with

DRY = {"clear_noon", "cloudy_noon", "clear_sunset", "cloudy_sunset"}
STREET = District(name="street", parking_occupancy=(0.1, 0.2), num_cars=(2, 3), num_pedestrians=(0, 1))


def test_a_draw_is_a_pure_function_of_its_numbers() -> None:
    policy = ResetPolicy.kitti()
    assert policy.draw(5, 9, 1) == policy.draw(5, 9, 1)
    draws = {policy.draw(seed, episode, attempt).config for seed, episode, attempt in [(5, 9, 1), (6, 9, 1), (5, 8, 1)]}
    assert len(draws) == 3
    assert policy.draw(5, 9, 0).config != policy.draw(5, 9, 1).config


def test_large_seeds_are_used_in_full_and_episodes_that_would_share_their_streams_are_refused() -> None:
    seeds = [3, *(3 + 2**bit for bit in (32, 40, 52, 53, 62)), 3 * 2**40, 2**63 - 1]
    policy = ResetPolicy.kitti()
    assert len({policy.draw(seed, 0).config for seed in seeds}) == len(seeds)
    # Both are the 32-bit words 1, 3, 7, 0.
    assert policy.draw(1 + 3 * 2**32, 7).config.num_cars > 0
    for episode, attempt, name in [(3 + 7 * 2**32, 0, "episode"), (-1, 0, "episode"), (0, 10**9 + 1, "attempt")]:
        with pytest.raises(CadetError, match=f"^{name}: expected a whole number from 0 to 1000000000, got "):
            policy.draw(1, episode, attempt)


def test_kittis_weather_is_bad_in_a_tenth_of_the_episodes() -> None:
    num = 4000
    drawn = Counter(ResetPolicy.kitti().draw(0, episode).weather.name for episode in range(num))
    bad = sum(count for name, count in drawn.items() if name not in DRY) / num
    assert abs(bad - 0.1) < 4 * (0.1 * 0.9 / num) ** 0.5
    assert drawn["clear_noon"] > num / 2


def test_the_papers_weather_is_uniform_over_all_presets_of_the_day() -> None:
    num = 3600
    drawn = Counter(ResetPolicy.paper().draw(0, episode).weather.name for episode in range(num))
    assert set(drawn) == {name for name in weather_names() if not name.endswith("_night")}
    assert max(abs(count - num / 18) for count in drawn.values()) < 4 * (num / 18) ** 0.5


def test_kittis_calibrations_are_drawn_as_often_as_in_kitti() -> None:
    num = 4000
    policy = ResetPolicy.kitti()
    drawn = Counter(policy.draw(0, episode).rig.name for episode in range(num))
    for name, share in (("kitti", 6057), ("kitti_2011_09_28", 770), ("kitti_2011_09_29", 358)):
        expected = num * share / 7481
        assert abs(drawn[name] - expected) < 4 * expected**0.5
    assert sum(drawn.values()) == num and len(drawn) == 4


def test_rig_and_load_have_streams_of_their_own_and_stay_through_an_episode() -> None:
    policy = ResetPolicy.kitti()
    for episode in range(30):
        first, redrawn = policy.draw(3, episode, 0), policy.draw(3, episode, 1)
        assert (first.rig, first.car_pitch_deg) == (redrawn.rig, redrawn.car_pitch_deg)
        assert first.config != redrawn.config
        alone = policy.with_rig(Rig.paper()).draw(3, episode, 0)
        assert replace(alone, rig=first.rig) == first
    pitches = [policy.draw(3, episode).car_pitch_deg for episode in range(2000)]
    assert abs(sum(pitches)) / 2000 < 0.01
    assert abs((sum(p * p for p in pitches) / 2000) ** 0.5 - policy.car_pitch_sd_deg) < 0.006


def test_the_papers_policy_brings_its_rig_and_no_vans() -> None:
    spec = ResetPolicy.named("paper").draw(0, 0)
    assert (spec.rig, spec.car_pitch_deg, spec.config.vehicle_shares) == (Rig.paper(), 0.0, {"Car": 1.0})


def test_counts_stay_in_the_district_and_maps_are_all_drawn() -> None:
    maps = (RoadMap("a.xodr", "A"), RoadMap("b.xodr", "B"))
    policy = replace(ResetPolicy.kitti(), districts=((STREET, 1.0),), maps=maps)
    specs = [policy.draw(1, episode) for episode in range(200)]
    assert {spec.road_map for spec in specs} == set(maps)
    assert {spec.config.num_cars for spec in specs} == {2, 3}
    assert all(0.1 <= spec.config.parking_occupancy <= 0.2 for spec in specs)


def test_a_manifest_names_maps_by_hash() -> None:
    policy = replace(ResetPolicy.kitti(), maps=(RoadMap("a.xodr", "A"),))
    assert policy.to_dict()["maps"] == [
        {"name": "a.xodr", "sha256": "559aead08264d5795d3909718cdd05abd49572e84fe55590eef31a88a08fdffd"}
    ]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"samples_per_episode": 0},
            "ResetPolicy.samples_per_episode: expected a whole number from 1 to 100000, got 0",
        ),
        ({"distance_m": -1.0}, "ResetPolicy.distance_m: expected a number from 0 to 1000, got -1.0"),
        ({"blocked_s": None}, "ResetPolicy.blocked_s: expected a number from 0.1 to 600, got None"),
        ({"car_pitch_sd_deg": -1.0}, "ResetPolicy.car_pitch_sd_deg: expected a number from 0 to 5, got -1.0"),
        ({"rigs": ()}, "ResetPolicy.rigs: expected at least one, got none"),
        (
            {"rigs": ((Rig.kitti(), 1.0), (Rig.kitti(), 1.0))},
            "ResetPolicy.rigs: expected different names, got kitti, kitti",
        ),
        ({"weathers": ()}, "ResetPolicy.weathers: expected at least one, got none"),
        ({"weathers": (("clear_noon", 0.0),)}, "ResetPolicy.weathers: expected a weight above 0, got none"),
        ({"districts": ((STREET, -1.0),)}, "ResetPolicy.districts weight: expected a number from 0 to 1e+09, got -1.0"),
    ],
)
def test_nonsense_is_refused_by_name(values: dict[str, Any], message: str) -> None:
    with pytest.raises(CadetError) as caught:
        replace(ResetPolicy.kitti(), **values)
    assert str(caught.value) == message


def test_an_unknown_weather_lists_the_known_ones() -> None:
    with pytest.raises(CadetError, match=r"^unknown weather 'hail'; known: clear_noon, .*, rain_night$"):
        ResetPolicy.kitti().with_weathers("hail")


def test_a_district_refuses_a_range_the_wrong_way_round() -> None:
    with pytest.raises(CadetError) as caught:
        District(name="x", parking_occupancy=(0.5, 0.4), num_cars=(0, 1), num_pedestrians=(0, 1))
    assert str(caught.value) == "District.parking_occupancy: expected (low, high), got (0.5, 0.4)"


@pytest.mark.parametrize(
    ("shares", "message"),
    [
        (("Car",), r": expected weights by class \(Car, Van, Truck, Misc\), such as {'Car': .*, got \('Car',\)"),
        ({"Tram": 1}, r": expected weights by class \(Car, Van, Truck, Misc\), such as .*, got {'Tram': 1}"),
        ({"Car": -1}, r"\.Car: expected a number from 0 to 1e\+09, got -1"),
        ({"Car": "all"}, r"\.Car: expected a number from 0 to 1e\+09, got 'all'"),
        ({}, ": expected a weight above 0 of Car or Van, since the others do not fit everywhere, got {}"),
        ({"Car": 0, "Truck": 1}, ": expected a weight above 0 of Car or Van, since .*, got {'Car': 0, 'Truck': 1}"),
    ],
)
def test_what_are_no_shares_of_vehicle_classes_is_refused(shares: Any, message: str) -> None:
    for owner, make in (("District", partial(replace, STREET)), ("SceneConfig", SceneConfig)):
        with pytest.raises(CadetError, match=rf"^{owner}\.vehicle_shares{message}$"):
            make(vehicle_shares=shares)


def test_shares_of_vehicle_classes_are_the_districts_and_reach_the_scene() -> None:
    given: dict[str, Any] = {"Car": 3, "Van": np.float32(0.5)}
    policy = ResetPolicy.kitti().with_each_district(lambda district: replace(district, vehicle_shares=given))
    assert all(district.vehicle_shares == {"Car": 3.0, "Van": 0.5} for district, _ in policy.districts)
    spec = policy.draw(0, 0)
    assert spec.config.vehicle_shares == {"Car": 3.0, "Van": 0.5}
    assert replace(spec.config, vehicle_shares=None) == ResetPolicy.kitti().draw(0, 0).config
    # A manifest tells of them; that of districts without says what it has always said.
    assert json.loads(json.dumps(policy.to_dict()))["districts"][0]["vehicle_shares"] == {"Car": 3.0, "Van": 0.5}
    assert "vehicle_shares" not in ResetPolicy.kitti().to_dict()["districts"][0]
    hash(policy), hash(spec.config)
    config = SceneConfig(vehicle_shares={"Van": 1})
    assert draw_with(policy, config)(0, 0, 0).config.vehicle_shares == {"Van": 1.0}


def test_districts_are_known_by_name_and_take_the_place_of_the_policys() -> None:
    drawn = {district.name for district, _ in ResetPolicy.kitti().districts}
    assert set(DISTRICTS) == drawn | {"car_park", "industrial", "campus", "motorway"}
    assert len(DISTRICTS) == len(set(DISTRICTS))
    assert all(District.named(name).name == name for name in DISTRICTS)
    country = District.named("country_road")
    # One of two: each as often as the other.
    policy = ResetPolicy.kitti().with_districts(country, STREET)
    found = Counter(policy.draw(0, episode).district for episode in range(400))
    assert set(found) == {"country_road", "street"} and abs(found["street"] - 200) < 40
    assert policy.draw(1, 0).config.suburb.country_share in (0.0, 1.0)
    assert country.suburb.country_share == 1.0 and country.num_pedestrians == (0, 0)
    motorway = District.named("motorway")
    assert motorway.suburb.motorway_share == 1.0 and motorway.num_pedestrians == motorway.num_cyclists == (0, 0)
    # Nothing else of the policy changes.
    assert replace(policy, districts=ResetPolicy.kitti().districts) == ResetPolicy.kitti()


@pytest.mark.parametrize("name", ["country", "", 3, None])
def test_an_unknown_district_is_refused_by_its_name(name: Any) -> None:
    with pytest.raises(CadetError, match=r"unknown district .*; known: parked_rows, .*country_road"):
        District.named(name)
    with pytest.raises(CadetError, match=r"ResetPolicy\.districts: expected at least one"):
        ResetPolicy.kitti().with_districts()


def test_names_stand_for_districts_and_a_misspelt_one_for_what_was_meant() -> None:
    kitti = ResetPolicy.kitti()
    assert kitti.with_districts("quiet", STREET) == kitti.with_districts(District.named("quiet"), STREET)
    with pytest.raises(CadetError, match=r"^unknown district 'county_road'; .*; did you mean 'country_road'\?$"):
        kitti.with_districts("county_road")
    with pytest.raises(CadetError, match=r"^unknown weather 'clear_moon'; .*; did you mean 'clear_noon'\?$"):
        kitti.with_weathers("clear_moon")


class RushHour(ResetPolicy):
    """The policy of docs/reference/settings.md."""

    def draw(self, seed: int, episode: int, attempt: int = 0) -> cadet.EpisodeSpec:
        spec = super().draw(seed, episode, attempt)
        if cadet.Draws(seed, episode, attempt, "rush hour").unit() < 0.5:
            return spec
        return replace(spec, config=replace(spec.config, num_cars=2 * spec.config.num_cars))


def test_a_policys_own_draw_is_the_one_that_is_used() -> None:
    policy, usual = replace(RushHour.kitti(), name="rush_hour"), ResetPolicy.kitti()
    assert type(policy.with_weathers("snow").as_sequence()) is RushHour
    ratios = [policy.draw(1, e).config.num_cars / usual.draw(1, e).config.num_cars for e in range(20)]
    assert set(ratios) == {1.0, 2.0}
    assert policy.draw(1, 3) == policy.draw(1, 3)
    from_file = RushHour.from_toml('policy = "kitti"\nweathers = ["snow"]')
    assert type(from_file) is RushHour and from_file.weathers == ((cadet.Weather.preset("snow"), 1.0),)


@pytest.mark.parametrize("name", ["clear_noon", "dense_fog", "clear_sunset", "rain_night", "snow"])
def test_a_preset_is_its_numbers(name: str) -> None:
    by_name, by_numbers = (
        cadet.Scene.random(seed=3, weather=weather)
        for weather in (name, replace(cadet.Weather.preset(name), name="mine"))
    )
    np.testing.assert_array_equal(by_name.capture().points_velo, by_numbers.capture().points_velo)
    np.testing.assert_array_equal(by_name.capture().image, by_numbers.capture().image)


def test_weathers_of_numbers_are_drawn_from_their_ranges_and_kept_in_tables() -> None:
    mist = cadet.Weather(name="mist", fog_visibility_m=(60.0, 200.0), cloud_cover=0.8, sun_elevation_deg=(30.0, 50.0))
    policy = ResetPolicy.kitti().with_weathers("snow", mist)
    drawn = [policy.draw(5, episode) for episode in range(40)]
    own = [spec for spec in drawn if spec.weather.name == "mist"]
    visibilities = {spec.weather.fog_visibility_m for spec in own}
    assert 10 < len(own) < 30 and len(visibilities) == len(own)
    assert all(60.0 <= (v or 0.0) < 200.0 for v in visibilities if not isinstance(v, tuple))
    assert all(30.0 <= (spec.config.sun_elevation_deg or 0.0) < 50.0 for spec in own)
    assert drawn == [policy.draw(5, episode) for episode in range(40)]
    # A file of the policy makes the same.
    assert ResetPolicy.from_toml(policy.to_toml()).weathers == policy.weathers
    weathers = policy.to_dict()["weathers"]
    assert weathers["snow"] == 1.0 and weathers["mist"]["fog_visibility_m"] == [60.0, 200.0]


@pytest.mark.parametrize(
    ("numbers", "reason"),
    [
        ({"fog_visibility_m": 0.0}, "Weather.fog_visibility_m: expected a number from 1 to 100000, got 0.0"),
        ({"rain_mm_h": (5.0, 2.0)}, "Weather.rain_mm_h: expected a number, or two that rise"),
        ({"wetness": None}, "Weather.wetness: expected a number from 0 to 1, got None"),
        ({"cloud_cover": "some"}, "Weather.cloud_cover: expected a number"),
        ({"snow_mm_h": (1.0, 2.0, 3.0)}, "Weather.snow_mm_h: expected a number, or two that rise"),
    ],
)
def test_bad_numbers_of_a_weather_are_refused(numbers: dict[str, Any], reason: str) -> None:
    with pytest.raises(CadetError, match=re.escape(reason)):
        cadet.Weather(**numbers)


def test_a_range_is_no_weather_of_a_scene_without_draws() -> None:
    with pytest.raises(CadetError, match=r"Weather.rain_mm_h: a range is for policies"):
        cadet.Scene.empty(weather=cadet.Weather(rain_mm_h=(1.0, 2.0)))
    text = "weathers: expected weathers of different names"
    with pytest.raises(CadetError, match=text):
        ResetPolicy.kitti().with_weathers(cadet.Weather(), cadet.Weather(wetness=1.0))
