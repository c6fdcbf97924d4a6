from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from cadet import (
    CadetError,
    Camera,
    Environment,
    Lidar,
    MissingFileError,
    NonFiniteError,
    Rig,
    RoadMap,
    Scene,
    SceneConfig,
    ShapeError,
    stream,
)
from fuzz.road_text import map_of, road
from small_runs import ROAD

RIG = Rig(camera=Camera.kitti().resized(64, 32), lidar=Lidar.vlp16())
TOWN = map_of(road(0, length_m=200.0))
NAN = float("nan")


def empty() -> Scene:
    return Scene.empty(rig=RIG)


def test_what_is_asked_for_reaches_the_frame(tmp_path: Path) -> None:
    path = tmp_path / "village.xodr"
    path.write_text(TOWN)
    frame = Scene.random(seed=1, map=path, weather="snow", rig=RIG, config=SceneConfig(num_cars=3)).capture()
    assert frame.meta is not None
    assert (frame.meta["map"], frame.meta["weather"]) == ("village.xodr", "snow")
    assert frame.image.shape == (32, 64, 3)
    assert frame.calib.P2[0, 0] == pytest.approx(721.5377 * 64 / 1242)


def test_without_a_seed_one_is_drawn_and_told() -> None:
    scene = Scene.random(rig=RIG, map=ROAD)
    seed, meta = scene.seed, scene.capture().meta
    assert seed is not None and meta is not None and meta["seed"] == seed
    assert Scene.random(seed=seed, rig=RIG, map=ROAD).capture().meta == meta
    assert Scene.random(rig=RIG, map=ROAD).seed != seed
    scene.step(1.0)
    assert scene.seed == seed and empty().seed is None


def test_a_map_is_a_file_or_one_that_was_read(tmp_path: Path) -> None:
    path = tmp_path / "village.xodr"
    path.write_text(TOWN)
    read = RoadMap.read(path)
    one, two = (Scene.random(seed=1, map=given, rig=RIG).capture().meta for given in (read, path))
    assert one == two and one is not None and one["map"] == "village.xodr"
    Scene.empty(map=read, rig=RIG)
    for environment in (Environment(map=read), stream(map=read, workers=0)._shares[0].environment):
        assert environment.policy.maps == (read,)


def test_the_same_instant_gives_the_same_frame_and_a_later_one_fresh_noise() -> None:
    scene = Scene.random(seed=1, rig=RIG, map=ROAD)
    first, second, third = (scene.capture() for _ in range(3))
    assert np.array_equal(first.image, second.image)
    assert first.meta is not None
    assert first.meta["seed"] == 1
    assert first.meta == second.meta == third.meta
    assert list(first.meta) == list(second.meta)
    scene.step(0.0)
    moved = scene.capture().meta
    assert moved is not None
    assert (moved["sample"], moved.get("seed"), moved == scene.capture().meta) == (1, None, True)
    assert not np.array_equal(first.image, scene.capture().image)


def places(scene: Scene) -> dict[int, list[float]]:
    """Return x and y of every agent."""
    return {agent.id: np.round(agent.position_world[:2], 3).tolist() for agent in scene.agents}


def test_actors_and_the_ego_go_where_they_are_put() -> None:
    scene = empty()
    car = scene.add("car", x_m=12, y_m=-3.5, yaw_rad=0.1, model_seed=3)
    van = scene.add("van", x_m=30, y_m=0, yaw_rad=np.pi / 2, speed_mps=5)
    walker = scene.add("pedestrian", path=[(0, 6, 8), (3, 9, 8)])
    assert places(scene) == {car: [12, -3.5], van: [30, 0], walker: [6, 8]}
    kinds = {agent.id: agent.type for agent in scene.agents}
    assert kinds == {car: "Car", van: "Van", walker: "Pedestrian"}
    ahead = scene.add("car", x_m=40, y_m=-3.5)
    (placed,) = [agent.world_from_agent for agent in scene.agents if agent.id == ahead]
    assert placed[:3, 0] == pytest.approx([1, 0, 0]), "it looks along the road unless it is told where to"
    scene.step(1.0)
    moved = places(scene)
    assert moved[car] == [12, -3.5]
    assert moved[van] == pytest.approx([30, 5], abs=0.1) and moved[walker] == pytest.approx([7, 8], abs=0.1)
    scene.move_ego(x_m=1, y_m=2, yaw_rad=np.pi / 2)
    pose = scene.sensor_poses()["world_from_velo"]
    assert pose[:2, 3] == pytest.approx([1, 2], abs=0.1)
    assert pose[:2, 0] == pytest.approx([0, 1], abs=0.01), "it looks north"


def test_no_two_stand_in_a_place_unless_it_is_allowed() -> None:
    scene = empty()
    scene.add("car", x_m=12, y_m=0)
    for x in (12.0, 0.0):
        with pytest.raises(CadetError, match="overlap"):
            scene.add("van", x_m=x, y_m=0, yaw_rad=1)
    with pytest.raises(CadetError, match="overlap"):
        scene.move_ego(x_m=12, y_m=0, yaw_rad=0)
    assert scene.num_actors == 1
    scene.add("van", x_m=12, y_m=0, yaw_rad=1, overlap="allow")
    scene.move_ego(x_m=12, y_m=0, yaw_rad=0, overlap="allow")
    assert scene.num_actors == 2


def test_scans_rays_and_poses_are_those_of_the_square() -> None:
    scene = empty()
    poses = scene.sensor_poses()
    assert sorted(poses) == ["world_from_cam", "world_from_velo"]
    assert poses["world_from_velo"][:3, 3] == pytest.approx([0, 0, 1.73], abs=0.01)
    scan = scene.scan(Lidar.cadet(), ideal=True)
    is_hit = np.isfinite(scan.range_m)
    assert scan.points_velo.shape == (40 * (scan.column.max() + 1), 4) and 0 < is_hit.sum() < len(is_hit)
    points_world = scan.points_velo[is_hit, :3] @ poses["world_from_velo"][:3, :3].T + poses["world_from_velo"][:3, 3]
    assert np.abs(points_world[:, 2]).max() < 0.01, "the ground is all there is"
    hits = scene.cast_rays([[50, 0, 1], [50, 0, 2]], [[0, 0, -3], [0, 0, 1]])
    assert hits.range_m.tolist() == [1.0, np.inf] and hits.actor_id.tolist() == [0, -1]
    assert hits.normal_world[0].tolist() == [0, 0, 1]
    assert scene.cast_rays([], []).range_m.shape == (0,)
    vertices, faces, actor_id = scene.triangles()
    assert vertices.shape[1:] == (3,) and faces.shape == (scene.num_triangles, 3) == (len(actor_id), 3)
    assert np.abs(vertices[:, :2]).max() == 200.0


@pytest.mark.parametrize(
    ("use", "kind", "message"),
    [
        (lambda: Scene.random(seed=-3), CadetError, "seed: expected a whole number from 0 to 2**63 - 1, got -3"),
        (
            lambda: Scene.random(seed=1, map="/no/such.xodr"),
            MissingFileError,
            "unknown map '/no/such.xodr': expected an OpenDRIVE file (.xodr)",
        ),
        (lambda: Scene.random(seed=1, config=cast(Any, {})), CadetError, "config: expected a SceneConfig, got {}"),
        (lambda: Scene.random(seed=1, rig=cast(Any, "kitti")), CadetError, "rig: expected a Rig, got 'kitti'"),
        (
            lambda: empty().add("car", x_m=NAN, y_m=0, yaw_rad=0),
            CadetError,
            "add.x_m: expected a number from -1e+06 to 1e+06, got nan",
        ),
        (
            lambda: empty().add("car", x_m=0, y_m=0, yaw_rad=0, model_seed=-1),
            CadetError,
            "add.model_seed: expected a whole number from 0 to 9223372036854775807, got -1",
        ),
        (
            lambda: empty().add("car", x_m=0),
            CadetError,
            "add: expected x_m and y_m, where the actor stands, or a path",
        ),
        (
            lambda: empty().add("car", x_m=0, y_m=0, yaw_rad=0, path=[(0, 0, 0), (1, 1, 1)]),
            CadetError,
            "add.path: it says where the actor goes and how fast; leave out x_m, y_m, yaw_rad and speed_mps",
        ),
        (
            lambda: empty().add("car", speed_mps=3, path=[(0, 0, 0), (1, 1, 1)]),
            CadetError,
            "add.path: it says where the actor goes and how fast; leave out x_m, y_m, yaw_rad and speed_mps",
        ),
        (
            lambda: empty().add("car", x_m=0, y_m=0, yaw_rad=0, speed_mps=-1),
            CadetError,
            "add.speed_mps: expected a number from 0 to 70, got -1",
        ),
        (
            lambda: empty().add("car", path=[(0, 0), (1, 1)]),
            ShapeError,
            "path: expected (n, 3) number, got (2, 2) float64",
        ),
        (lambda: empty().add("car", path=[(0, 0, NAN), (1, 1, 0)]), NonFiniteError, "path: not finite at [0, 2]"),
        (
            lambda: empty().add("car", x_m=0, y_m=0, yaw_rad=0, overlap=cast(Any, True)),
            CadetError,
            'add.overlap: expected "refuse" or "allow", got True',
        ),
        (
            lambda: empty().move_ego(x_m=0, y_m=0, yaw_rad=0, overlap="no"),
            CadetError,
            'move_ego.overlap: expected "refuse" or "allow", got \'no\'',
        ),
        (lambda: empty().step(-1.0), CadetError, "step.seconds: expected a number from 0 to 3600, got -1.0"),
        (lambda: empty().scan(cast(Any, "cadet")), CadetError, "lidar: expected a Lidar, got 'cadet'"),
        (
            lambda: empty().cast_rays(np.zeros((2, 3), np.float32), np.ones((2, 3))),
            ShapeError,
            "origins_world: expected (n, 3) float64, got (2, 3) float32; convert with .astype(np.float64)",
        ),
        (
            lambda: empty().cast_rays(np.zeros((2, 3)), np.ones(3)),
            ShapeError,
            "directions_world: expected (n, 3) float64, got (3,) float64",
        ),
        (
            lambda: empty().cast_rays([[0, 0, NAN]], [[1, 0, 0]]),
            NonFiniteError,
            "origins_world: not finite at [0, 2]",
        ),
    ],
)
def test_misuse_is_refused_in_one_line(use: Any, kind: type[CadetError], message: str) -> None:
    with pytest.raises(CadetError) as caught:
        use()
    assert type(caught.value) is kind
    assert str(caught.value) == message


def test_a_file_that_is_no_map_is_named(tmp_path: Path) -> None:
    (tmp_path / "photo.xodr").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(CadetError) as caught:
        Scene.empty(map=tmp_path / "photo.xodr")
    assert str(caught.value) == "photo.xodr:1: not UTF-16: convert it with iconv -f utf-16 -t UTF-8, and declare that"
