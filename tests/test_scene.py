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

pytestmark = pytest.mark.usefixtures("fake_core")

RIG = Rig(camera=Camera.kitti().resized(64, 32))
NAN = float("nan")


def empty() -> Scene:
    return Scene.empty(rig=RIG)


def test_what_is_asked_for_reaches_the_frame(tmp_path: Path) -> None:
    path = tmp_path / "village.xodr"
    path.write_text("<OpenDRIVE/>")
    frame = Scene.random(seed=1, map=path, weather="snow", rig=RIG, config=SceneConfig(num_cars=1)).capture()
    assert frame.meta is not None
    assert (frame.meta["map"], frame.meta["weather"]) == ("village.xodr", "snow")
    assert frame.image.shape == (32, 64, 3)
    assert frame.calib.P2[0, 0] == pytest.approx(721.5377 * 64 / 1242)


def test_without_a_seed_one_is_drawn_and_told() -> None:
    scene = Scene.random(rig=RIG)
    seed, meta = scene.seed, scene.capture().meta
    assert seed is not None and meta is not None and meta["seed"] == seed
    assert Scene.random(seed=seed, rig=RIG).capture().meta == meta
    assert Scene.random(rig=RIG).seed != seed
    scene.step(1.0)
    assert scene.seed == seed and empty().seed is None


def test_a_map_is_a_file_or_one_that_was_read(tmp_path: Path) -> None:
    path = tmp_path / "village.xodr"
    path.write_text("<OpenDRIVE/>")
    read = RoadMap.read(path)
    one, two = (Scene.random(seed=1, map=given, rig=RIG).capture().meta for given in (read, path))
    assert one == two and one is not None and one["map"] == "village.xodr"
    Scene.empty(map=read, rig=RIG)
    for environment in (Environment(map=read), stream(map=read, workers=0)._shares[0].environment):
        assert environment.policy.maps == (read,)


def test_the_same_instant_gives_the_same_frame_and_a_later_one_fresh_noise() -> None:
    scene = Scene.random(seed=1, rig=RIG)
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


def test_actors_and_the_ego_go_where_they_are_put() -> None:
    scene = empty()
    assert scene.add("car", x=12, y=-3.5, yaw=0.1, model_seed=3) == 1
    scene.move_ego(x=1, y=2, yaw=3)
    scene.add("van", x=0, y=0, yaw=1, speed=5, overlap="allow")
    scene.add("pedestrian", path=[(0, 1, 2), (3, 4, 5)])
    scene.move_ego(x=1, y=2, yaw=3, overlap="allow")
    native = cast(Any, scene)._native
    assert native.calls == [
        "add car 3 (12.0, -3.5, 0.1) None False",
        "move_ego 1.0 2.0 3.0 False",
        "add van 0 (0.0, 0.0, 1.0) 5.0 True",
        "add pedestrian 0 [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]] None False",
        "move_ego 1.0 2.0 3.0 True",
    ]


def test_scans_rays_and_poses_pass_through() -> None:
    scene = empty()
    scan = scene.scan(Lidar.cadet(), ideal=True)
    assert scan.points_velo.shape == (4, 4)
    assert np.isinf(scan.range_m).all()
    hits = scene.cast_rays([[0, 0, 1], [0, 0, 2]], [[1, 0, 0], [0, 1, 0]])
    assert hits.range_m.tolist() == [7.0, 7.0]
    assert scene.cast_rays([], []).range_m.shape == (0,)
    assert sorted(scene.sensor_poses()) == ["world_from_cam", "world_from_velo"]
    assert [a.shape for a in scene.triangles()] == [(3, 3), (1, 3), (1,)]
    assert cast(Any, scene)._native.calls == ["scan cadet True 0"]


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
            lambda: empty().add("car", x=NAN, y=0, yaw=0),
            CadetError,
            "place.x: expected a number from -1e+06 to 1e+06, got nan",
        ),
        (
            lambda: empty().add("car", x=0, y=0, yaw=0, model_seed=-1),
            CadetError,
            "add.model_seed: expected a whole number from 0 to 9223372036854775807, got -1",
        ),
        (
            lambda: empty().add("car", x=0, y=0),
            CadetError,
            "place.yaw: expected a number from -1e+06 to 1e+06, got None",
        ),
        (
            lambda: empty().add("car", x=0, y=0, yaw=0, path=[(0, 0, 0), (1, 1, 1)]),
            CadetError,
            "add.path: it says where the actor goes and how fast; leave out x, y, yaw and speed",
        ),
        (
            lambda: empty().add("car", speed=3, path=[(0, 0, 0), (1, 1, 1)]),
            CadetError,
            "add.path: it says where the actor goes and how fast; leave out x, y, yaw and speed",
        ),
        (
            lambda: empty().add("car", x=0, y=0, yaw=0, speed=-1),
            CadetError,
            "add.speed: expected a number from 0 to 70, got -1",
        ),
        (
            lambda: empty().add("car", path=[(0, 0), (1, 1)]),
            ShapeError,
            "path: expected (n, 3) number, got (2, 2) float64",
        ),
        (lambda: empty().add("car", path=[(0, 0, NAN), (1, 1, 0)]), NonFiniteError, "path: not finite at [0, 2]"),
        (
            lambda: empty().add("car", x=0, y=0, yaw=0, overlap=cast(Any, True)),
            CadetError,
            'add.overlap: expected "refuse" or "allow", got True',
        ),
        (
            lambda: empty().move_ego(x=0, y=0, yaw=0, overlap="no"),
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
