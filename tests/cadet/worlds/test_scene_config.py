"""What a user asks of suburb, props, and sun is what the scene shows."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import cadet
from cadet import Camera, Lidar, PropConfig, Rig, Scene, SceneConfig, Semantic, SuburbConfig

SMALL = Rig(camera=Camera.kitti().resized(414, 125), lidar=Lidar.vlp16())


def beside_the_van(azimuth_deg: float) -> tuple[float, float]:
    """Return the mean brightness of the road to the left and to the right of a van ahead."""
    config = SceneConfig(sun_elevation_deg=30.0, sun_azimuth_deg=azimuth_deg)
    scene = Scene.empty(weather="clear_noon", rig=SMALL, config=config)
    scene.add("van", x_m=14.0, y_m=0.0, yaw_rad=0.0)
    frame = scene.capture()
    assert frame.instance is not None and frame.semantic is not None
    rows, columns = np.nonzero(frame.instance == 1)
    low = slice(rows.max() - 3, rows.max() + 2)
    width = 12
    image = frame.image.astype(float).mean(axis=2)
    left, right = columns.min() - width - 2, columns.max() + 2
    return float(image[low, left : left + width].mean()), float(image[low, right : right + width].mean())


def test_shadows_fall_away_from_the_sun() -> None:
    left, right = beside_the_van(90.0)
    assert right < 0.8 * left, "the sun in the north, on the left"
    left, right = beside_the_van(-90.0)
    assert left < 0.8 * right, "the sun in the south, on the right"


@pytest.mark.parametrize("elevation_deg", [3.0, 90.0])
def test_the_sun_stands_where_it_is_put(elevation_deg: float) -> None:
    config = SceneConfig(num_cars=8, sun_elevation_deg=elevation_deg, sun_azimuth_deg=180.0)
    frame = Scene.random(seed=1, weather="clear_noon", rig=SMALL, config=config).capture()
    assert frame.meta is not None
    assert frame.meta["sun"]["elevation_rad"] == pytest.approx(math.radians(elevation_deg))
    assert frame.meta["sun"]["azimuth_rad"] == pytest.approx(math.pi)
    assert frame.image.std() > 10.0


def test_suburbs_have_as_many_blocks_as_asked_for() -> None:
    def extent_m(blocks: tuple[int, int]) -> float:
        suburb = SuburbConfig(blocks=blocks, block_m=(80.0, 80.0))
        scene = Scene.random(seed=2, weather="clear_noon", rig=SMALL, config=SceneConfig(num_cars=8, suburb=suburb))
        vertices, _, _ = scene.triangles()
        return float(np.ptp(vertices[:, :2], axis=0).max())

    small, large = extent_m((2, 2)), extent_m((6, 6))
    assert large - small > 2.5 * 80.0


def test_towns_without_greenery_have_no_trees() -> None:
    def num_high(greenery: float) -> int:
        props = PropConfig(greenery=greenery, belt_m=40.0 * greenery)
        scene = Scene.random(seed=3, weather="clear_noon", rig=SMALL, config=SceneConfig(num_cars=8, props=props))
        scan = scene.scan(Lidar.vlp16(), ideal=True)
        # Hedges and lawns are lower.
        return int(((scan.semantic == Semantic.VEGETATION) & (scan.points_velo[:, 2] > 1.5)).sum())

    bare, green = num_high(0.0), num_high(1.0)
    assert green > 100 and bare < 0.1 * green, f"{bare} {green}"


def test_clutter_fills_the_streets() -> None:
    def num_triangles(clutter: float) -> int:
        # Without plants, which give way to it.
        props = PropConfig(clutter=clutter, greenery=0.0)
        config = SceneConfig(num_cars=0, num_pedestrians=0, props=props)
        scene = Scene.random(seed=3, weather="clear_noon", rig=SMALL, config=config)
        return len(scene.triangles()[1])

    assert num_triangles(0.0) < num_triangles(1.0) < 1.5 * num_triangles(0.0)


def test_a_policys_districts_and_sun_reach_the_scene() -> None:
    suburb, props = SuburbConfig(blocks=(2, 3)), PropConfig(greenery=0.5)
    district = cadet.District(
        name="mine", parking_occupancy=(0.5, 0.5), num_cars=(9, 9), num_pedestrians=(3, 3), suburb=suburb, props=props
    )
    policy = cadet.ResetPolicy(
        weathers=((cadet.Weather(), 1.0),), districts=((district, 1.0),), sun_elevation_deg=(50.0, 60.0)
    )
    drawn = [policy.draw(0, episode).config for episode in range(50)]
    assert all((config.suburb, config.props) == (suburb, props) for config in drawn)
    suns = [config.sun_elevation_deg for config in drawn]
    assert all(sun is not None and 50.0 <= sun <= 60.0 for sun in suns) and len(set(suns)) > 40
    assert policy.to_dict()["districts"][0]["suburb"]["blocks"] == (2, 3)
    # What is as usual is not listed, so that older datasets are resumed.
    usual = cadet.ResetPolicy.kitti().to_dict()
    plain = replace(district, suburb=SuburbConfig(), props=PropConfig()).to_dict()
    assert "sun_elevation_deg" not in usual and not {"suburb", "props"} & set(plain)


def test_the_motorway_district_has_fast_vehicles_and_nobody_on_foot() -> None:
    policy = cadet.ResetPolicy.kitti().with_districts("motorway").with_weathers("clear_noon")
    for seed in range(3):
        scene = Scene.random(seed=seed, policy=policy, rig=SMALL)
        frame = scene.capture()
        assert frame.semantic is not None
        shown = {Semantic(value) for value in np.unique(frame.semantic)}
        wanted = {Semantic.ROAD, Semantic.ROAD_MARKING, Semantic.TERRAIN, Semantic.VEGETATION, Semantic.FENCE}
        assert wanted <= shown and Semantic.SIDEWALK not in shown, shown
        assert {label.type for label in frame.labels} <= {"Car", "Van", "Truck", "DontCare"}
        speeds = [float(np.linalg.norm(agent.velocity_world)) for agent in scene.agents]
        assert len(speeds) > 20 and min(speeds) > 15.0 and max(speeds) < 50.0, speeds


def test_the_country_road_district_has_vegetation_and_fields_and_no_sidewalk() -> None:
    policy = cadet.ResetPolicy.kitti().with_districts("country_road").with_weathers("clear_noon")
    wanted = {Semantic.ROAD, Semantic.ROAD_MARKING, Semantic.TERRAIN, Semantic.VEGETATION}
    for seed in range(3):
        frame = Scene.random(seed=seed, policy=policy, rig=SMALL).capture()
        assert frame.semantic is not None
        shown = {Semantic(value) for value in np.unique(frame.semantic)}
        assert wanted <= shown and Semantic.SIDEWALK not in shown, shown
        assert not any(label.type == "Pedestrian" for label in frame.labels)
        # Woods or hills close the land: below the horizon no sky is left.
        below = frame.semantic[int(frame.calib.P2[1, 2]) + 6 :]
        assert (below != Semantic.SKY).all()
