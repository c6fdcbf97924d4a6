"""The ego driven by speed and lateral offset, in the scripted and the generated world."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cadet
from fuzz.road_text import map_of, road

SMALL = cadet.Rig(camera=cadet.Camera.kitti().resized(310, 94), lidar=cadet.Lidar.vlp16())


MIDDLE_M = -1.6
"""The y of the right lane's middle."""


def straight(folder: Path) -> cadet.Scene:
    """Return a scene on a road along x, with the ego at x = 50 m on the right lane."""
    path = folder / "straight.xodr"
    path.write_text(map_of(road(0, length_m=900.0)))
    scene = cadet.Scene.empty(map=path, rig=SMALL)
    scene.move_ego(x_m=50.0, y_m=MIDDLE_M, yaw_rad=0.0)
    return scene


def place(scene: cadet.Scene) -> tuple[float, float, float]:
    """Return the ego's x and y in the world and its speed."""
    sample = scene.capture().sample
    assert sample is not None
    x, y = sample.world_from_ego[:2, 3].tolist()
    return x, y, sample.ego_speed_mps


def test_speed_and_offset_are_reached_and_kept_until_the_driver_takes_over(tmp_path: Path) -> None:
    scene = straight(tmp_path)
    for speed_mps, lateral_m in ((6.0, 0.0), (10.0, 1.5), (4.0, -1.0)):
        scene.command_ego(speed_mps=speed_mps, lateral_m=lateral_m)
        scene.step(9.0)
        before, (x, y, found) = place(scene)[0], place(scene)
        assert found == pytest.approx(speed_mps, abs=0.1)
        assert y - MIDDLE_M == pytest.approx(lateral_m, abs=0.1)
        scene.step(1.0)
        assert place(scene)[0] - before == pytest.approx(speed_mps, abs=0.1)
    scene.command_ego(speed_mps=0.0, lateral_m=2.0)
    scene.step(6.0)
    x, y, found = place(scene)
    assert found < 0.05 and y - MIDDLE_M < 0.5, "who stands does not move sideways"
    scene.step(3.0)
    assert place(scene)[:2] == pytest.approx((x, y), abs=0.01)
    scene.command_ego(speed_mps=None)
    scene.step(8.0)
    _, y, found = place(scene)
    assert found > 5.0 and y == pytest.approx(MIDDLE_M, abs=0.25), "the driver goes on in the lane's middle"


def test_a_command_is_held_whatever_stands_in_the_way(tmp_path: Path) -> None:
    speeds = {}
    for name, speed_mps, seconds in (("driver", None, 20.0), ("command", 8.0, 7.0)):
        scene = straight(tmp_path)
        scene.add("car", x_m=110.0, y_m=MIDDLE_M, yaw_rad=0.0)
        scene.command_ego(speed_mps=speed_mps)
        scene.step(seconds)
        speeds[name] = place(scene)[2]
    assert speeds["driver"] < 0.5, "the driver stops behind a car that stands"
    assert speeds["command"] > 7.0


def test_a_moved_ego_waits_and_numbers_are_checked(tmp_path: Path) -> None:
    scene = straight(tmp_path)
    scene.command_ego(speed_mps=5.0)
    scene.move_ego(x_m=80.0, y_m=MIDDLE_M, yaw_rad=0.0)
    scene.step(2.0)
    assert place(scene) == pytest.approx((80.0, MIDDLE_M, 0.0), abs=0.05)
    for arguments, message in (
        ({"speed_mps": 71.0}, r"command_ego.speed_mps: expected a number from 0 to 70, got 71.0"),
        ({"speed_mps": -1.0}, "command_ego.speed_mps"),
        ({"speed_mps": 5.0, "lateral_m": float("nan")}, "command_ego.lateral_m"),
        ({"speed_mps": 5.0, "lateral_m": 5.5}, "command_ego.lateral_m: expected a number from -5 to 5, got 5.5"),
    ):
        with pytest.raises(cadet.CadetError, match=message):
            scene.command_ego(**arguments)
    with pytest.raises(cadet.CadetError, match=r"^scene: the ego is on no lane to drive along$"):
        cadet.Scene.empty(rig=SMALL).command_ego(speed_mps=5.0)


def test_an_environment_drives_as_commanded_and_its_driver_as_ever() -> None:
    policy = cadet.ResetPolicy.kitti().with_rig(SMALL).as_sequence(hz=2, length_s=4)
    one, two, driven = (cadet.Environment(policy=policy) for _ in range(3))
    for env in (one, two, driven):
        env.reset(seed=3)
    first = [env.step() for env in (one, two, driven)]
    # The driver's own ways are the same frames, whether they were asked for by None or not at all.
    for _ in range(3):
        assert one.step().meta == two.step(speed_mps=None).meta
    frames = [driven.step(speed_mps=2.0) for _ in range(7)]
    speeds = [frame.meta["ego_speed_mps"] for frame in frames if frame.meta is not None]
    np.testing.assert_allclose(speeds[-3:], 2.0, atol=0.2)
    # A new episode is the driver's until commanded.
    driven.step()
    assert driven.episode == 1 and first[0].meta == first[2].meta
    with pytest.raises(cadet.CadetError, match=r"step.speed_mps: expected a number from 0 to 70"):
        driven.step(speed_mps=100.0)
