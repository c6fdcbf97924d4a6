"""The package on the compiled core: scenes, environments and files agree, and limits are those of both."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cadet import CadetError, Camera, Environment, Lidar, ResetPolicy, Rig, Scene, Semantic, kitti
from cadet.formats.kitti.from_sample import frame_from_sample
from cadet.formats.kitti.lint import lint
from cadet.sensors.sample import Wanted
from cadet.simulation.episode import Episode

ROOT = Path(__file__).parents[2]
SMALL = replace(Rig.kitti(), camera=Camera.kitti().resized(310, 94))


def cadet_gen(*arguments: object) -> subprocess.CompletedProcess[str]:
    code = "from cadet.cli import run_cadet_gen\nif __name__ == '__main__':\n    run_cadet_gen()"
    command = [sys.executable, "-c", code, *map(str, arguments)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
    return subprocess.run(command, env=environment, text=True, capture_output=True, timeout=110, check=False)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three frames written by one worker."""
    out = tmp_path_factory.mktemp("dataset") / "out"
    done = cadet_gen(out, "-n", 3, "--seed", 5, "--workers", 1, "--image-size", "310x94", "--write", "depth,instance")
    assert done.returncode == 0, done.stderr
    return out


def test_what_is_written_passes_the_lint(dataset: Path) -> None:
    assert lint(dataset) == []


def test_scene_environment_and_files_agree(dataset: Path) -> None:
    policy = ResetPolicy.kitti().with_each_rig(lambda rig: replace(rig, camera=rig.camera.resized(310, 94)))
    scene_frame = Scene.random(seed=5, policy=policy).capture()
    env = Environment(policy=policy)
    env.reset(seed=5)
    env_frame = env.step()
    written = kitti.read_frame(dataset, 0)
    for frame in (env_frame, written):
        np.testing.assert_array_equal(frame.image, scene_frame.image)
        np.testing.assert_array_equal(frame.points_velo, scene_frame.points_velo)
        np.testing.assert_array_equal(frame.calib.P2, scene_frame.calib.P2)
    assert scene_frame.depth is not None
    assert scene_frame.instance is not None
    assert written.instance is not None
    np.testing.assert_array_equal(written.instance, scene_frame.instance)
    assert written.meta is not None
    assert scene_frame.meta is not None
    # JSON knows no tuples.
    assert {**written.meta, "sha256": None} == {**json.loads(json.dumps(scene_frame.meta)), "sha256": None}


def test_without_maps_all_else_is_the_same() -> None:
    policy = ResetPolicy.kitti().with_rig(SMALL)
    with_maps = frame_from_sample(Episode(policy, 5, 0).next_sample(0))
    without = frame_from_sample(Episode(policy, 5, 0, wanted=Wanted(maps=False)).next_sample(0))
    assert with_maps.depth is not None
    assert (without.depth, without.instance, without.semantic) == (None, None, None)
    np.testing.assert_array_equal(without.image, with_maps.image)
    np.testing.assert_array_equal(without.points_velo, with_maps.points_velo)
    assert without.labels == with_maps.labels


def test_the_core_enforces_the_limits_that_it_states(core: Any) -> None:
    """Python refuses what lies beyond them; behind it, the core's own checks know the same numbers."""
    limits = core.limits()
    scene = Scene.empty(rig=SMALL)
    for beyond in (limits["step_s"][1] + 1.0, -1.0):
        with pytest.raises(CadetError, match="step"):
            scene.step(beyond)
        with pytest.raises(CadetError, match="seconds"):
            scene._native.step(beyond)
    most = limits["divergence_mrad"][1]
    Lidar.vlp16(divergence_mrad=most)._to_native()
    for divergence_mrad in (most * 1.01, -0.1):
        with pytest.raises(CadetError, match="divergence"):
            core.Lidar.preset("hdl64e_kitti").scanning(
                rolling=False, returns="strongest", divergence_mrad=divergence_mrad
            )
    least, most = limits["image_side_px"]
    for side in (int(least) - 1, int(most) + 1):
        with pytest.raises(CadetError, match=f"from {least:g} to {most:g}"):
            SMALL.camera.resized(side, 100)


def test_semantic_values_are_the_enums() -> None:
    frame = Scene.random(seed=1, rig=SMALL).capture()
    assert frame.semantic is not None
    seen = {Semantic(int(value)) for value in np.unique(frame.semantic)}
    assert {Semantic.SKY, Semantic.ROAD} <= seen


def test_the_presets_have_their_beams() -> None:
    origins, directions, ring, column = Lidar.hdl64e_uniform().rays()
    assert origins.shape == directions.shape == (64 * 2083, 3)
    assert np.abs(np.linalg.norm(directions, axis=1) - 1.0).max() < 1e-12
    assert not origins.any()
    assert (ring.max(), column.max()) == (63, 2082)
    kitti_origins = Lidar.hdl64e_kitti().rays()[0]
    assert np.unique(kitti_origins[:, 2]).size > 60
    assert not Lidar("hdl64e_kitti", single_origin=True).rays()[0].any()
    assert Lidar.cadet().rays()[2].max() == 39


def test_a_scripted_car_is_where_it_was_put() -> None:
    scene = Scene.empty(rig=SMALL)
    pose = scene.sensor_poses()["world_from_velo"]
    x, y, _ = (pose @ [15.0, 0.0, 0.0, 1.0])[:3]
    actor = scene.add("car", x_m=x, y_m=y, yaw_rad=float(np.arctan2(pose[1, 0], pose[0, 0])), model_seed=3)
    scan = scene.scan(Lidar.hdl64e_uniform(), ideal=True)
    hits = scan.points_velo[scan.actor_id == actor, :3]
    assert len(hits) > 200
    # A car is between 3 and 5.5 m long: its near end is that much closer than its middle.
    assert 15.0 - 2.75 < hits[:, 0].min() < 15.0 - 1.5
    cars = [label for label in scene.capture().labels if label.type == "Car"]
    assert len(cars) == 1
    assert cars[0].occluded == 0
    # Camera 0 is 27 cm ahead of the LIDAR, and the box displaced by 0.115 m toward it.
    assert cars[0].location_cam[2] == pytest.approx(15.0 - 0.27 - 0.115, abs=0.2)


@pytest.mark.parametrize(
    ("use", "pattern"),
    [
        (
            lambda: Scene.empty().add("zeppelin", x_m=0, y_m=0, yaw_rad=0),
            r"^unknown class \"zeppelin\"; known: Car, .*$",
        ),
        (lambda: Scene.empty().cast_rays([[0, 0, 9]], [[0, 0, 0]]), r"^.*direction.*$"),
        (lambda: Scene.empty(map=ROOT / "pyproject.toml"), r"^pyproject\.toml:1: .+$"),
    ],
)
def test_the_core_refuses_nonsense_in_one_line(use: Any, pattern: str) -> None:
    with pytest.raises(CadetError) as caught:
        use()
    assert re.match(pattern, str(caught.value)), str(caught.value)


def test_the_default_policy_has_streets_with_and_without_cars() -> None:
    env = Environment(policy=replace(ResetPolicy.kitti(), samples_per_episode=1), rig=SMALL)
    env.reset(seed=0)
    counts = [sum(label.type == "Car" for label in env.step().labels) for _ in range(4)]
    assert max(counts) >= 3
    assert len(set(counts)) >= 2
