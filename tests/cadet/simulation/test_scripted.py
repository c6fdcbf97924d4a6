"""Actors that follow a script, as labels, scans and images see them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import cadet

SMALL = replace(cadet.Rig.kitti(), camera=cadet.Camera.kitti().resized(414, 125))


@pytest.fixture
def scene(core: Any) -> cadet.Scene:
    del core
    scene = cadet.Scene.empty(rig=SMALL, config=cadet.SceneConfig(label=cadet.LabelConfig(boxes="exact")))
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    return scene


def objects(scene: cadet.Scene) -> dict[int, dict[str, Any]]:
    meta = scene.capture().meta
    assert meta is not None
    return {o["actor_id"]: o for o in meta["objects"]}


def test_labels_follow_the_path(scene: cadet.Scene) -> None:
    straight = scene.add("car", x_m=14.0, y_m=3.5, yaw_rad=0.0, speed_mps=5.0)
    turning = scene.add("van", path=[(0.5, 12.0, -4.0), (2.5, 22.0, -4.0), (4.5, 30.0, 2.0)])
    walker = scene.add("pedestrian", path=np.array([[0.0, 11.0, 0.0], [10.0, 24.0, 0.0]]))
    first = objects(scene)
    assert first[straight]["velocity_world"] == pytest.approx([5.0, 0.0, 0.0], abs=1e-3)
    assert first[turning]["velocity_world"] == [0.0, 0.0, 0.0]
    assert first[walker]["velocity_world"] == pytest.approx([1.3, 0.0, 0.0], abs=1e-3)
    scene.step(2.0)
    then = objects(scene)
    # Camera 0 looks along x: what goes 10 m along x is 10 m deeper.
    for actor, way_m in ((straight, 10.0), (turning, 7.5), (walker, 2.6)):
        before, after = (np.array(o[actor]["location_cam"]) for o in (first, then))
        assert after[2] - before[2] == pytest.approx(way_m, abs=0.02)
        assert abs(after[0] - before[0]) < 0.3
    scene.step(2.2)
    assert objects(scene)[turning]["velocity_world"] == pytest.approx([4.0, 3.0, 0.0], abs=1e-3)
    later = objects(scene)[turning]["rotation_y"]
    assert math.remainder(later - then[turning]["rotation_y"] + math.atan2(6.0, 8.0), math.tau) == pytest.approx(
        0, abs=0.02
    )


def test_agents_are_known_without_a_sensor(scene: cadet.Scene) -> None:
    car = scene.add("car", x_m=14.0, y_m=3.5, yaw_rad=0.0, speed_mps=5.0)
    scene.add("pedestrian", x_m=11.0, y_m=0.0, yaw_rad=0.0)
    scene.step(1.0)
    agents = {agent.id: agent for agent in scene.agents}
    assert list(agents) == sorted(agents)
    assert len(agents) == scene.num_actors == 2
    assert agents[car].world_from_agent[:2, 3] == pytest.approx([19.0, 3.5], abs=0.1)
    assert agents[car].speed_mps == pytest.approx(5.0, abs=1e-3)
    meta = objects(scene)[car]
    assert (agents[car].type, agents[car].model) == ("Car", meta["model"])


def test_a_rolling_scan_sees_a_scripted_car_move_during_the_turn(core: Any) -> None:
    del core

    def middle_x(speed: float, *, rolling: bool) -> float:
        scene = cadet.Scene.empty(rig=SMALL)
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        car = scene.add("car", x_m=0.0, y_m=9.0, yaw_rad=0.0, speed_mps=speed)
        scan = scene.scan(cadet.Lidar(rolling=rolling))
        return float(np.median(scan.points_velo[scan.actor_id == car, 0]))

    # A car to the left is scanned a quarter of a turn before or after the instant of the scan: 25 ms.
    still, moving = (middle_x(speed, rolling=True) - middle_x(speed, rolling=False) for speed in (0.0, 20.0))
    assert abs(still) < 0.1
    assert abs(moving) == pytest.approx(0.5, abs=0.15)


def test_nobody_is_put_where_another_stands(scene: cadet.Scene) -> None:
    car = scene.add("car", x_m=15.0, y_m=0.0, yaw_rad=0.0)
    message = rf"^scene: a Van at \(16, 1\) would overlap the Car of id {car}; overlap=\"allow\" puts it there$"
    with pytest.raises(cadet.CadetError, match=message):
        scene.add("van", x_m=16.0, y_m=1.0, yaw_rad=0.3)
    with pytest.raises(cadet.CadetError, match=r"would overlap the ego \(id 0\)"):
        scene.add("pedestrian", path=[(0.0, 1.0, 0.5), (1.0, 3.0, 3.0)])
    with pytest.raises(cadet.CadetError, match=rf"^scene: the ego at \(14, 0\) would overlap the Car of id {car}"):
        scene.move_ego(x_m=14.0, y_m=0.0, yaw_rad=0.0)
    assert scene.num_actors == 1
    assert scene.add("van", x_m=16.0, y_m=1.0, yaw_rad=0.3, overlap="allow") == 2
    scene.move_ego(x_m=14.0, y_m=0.0, yaw_rad=0.0, overlap="allow")


def test_a_script_is_the_same_every_time(core: Any) -> None:
    del core

    def run() -> tuple[bytes, bytes]:
        scene = cadet.Scene.random(seed=3)
        x, y = scene.sensor_poses()["world_from_velo"][:2, 3]
        scene.add("pedestrian", path=[(0.0, x + 9.0, y), (4.0, x + 9.0, y + 4.0)], overlap="allow")
        scene.step(3.0)
        frame = scene.capture()
        return frame.image.tobytes(), frame.points_velo.tobytes()

    assert run() == run()
