"""Warnings of what was passed over: once each, where users see them."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import pytest

from cadet import Assets, CadetWarning, Camera, District, Environment, Lidar, Rig, Scene, SceneConfig
from cadet._util.notices import notice
from fuzz.road_text import map_of, road
from gen_process import FINE, SIZE, run
from mesh_files.obj_meshes import assets_folder
from small_runs import small_policy

RIG = Rig(camera=Camera.kitti().resized(64, 32), lidar=Lidar.vlp16())
LINE = "lossy.xodr:5: road 7: <spiral> without curvStart: a piece of 0.0001 m passed over"


@pytest.fixture
def lossy(tmp_path: Path) -> Path:
    """A map that is read with a loss. Its text is the test's own, so that it was not spoken of before."""
    path = tmp_path / "lossy.xodr"
    piece = '<geometry s="200" x="200" y="0" hdg="0" length="0.0001"><spiral curvEnd="0.5"/></geometry></planView>'
    text = map_of(road(7, length_m=200.0).replace("</planView>", piece))
    path.write_text(f"{text}<!-- {tmp_path} -->")
    return path


def test_a_notice_is_said_once_of_each_thing_and_names_the_callers_line() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        notice(["a", "b"], about="one")
        notice(["a"], about="one")
        notice(["a"], about="two")
    assert [str(warning.message) for warning in caught] == ["a", "b", "a"]
    assert {warning.filename for warning in caught} == {__file__}
    assert all(warning.category is CadetWarning for warning in caught)


def test_scenes_and_environments_warn_of_a_maps_losses_once(lossy: Path) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Scene.empty(map=lossy, rig=RIG)
        Scene.empty(map=lossy, rig=RIG)
        environment = Environment(map=lossy, rig=RIG)
        environment.reset(seed=0)
        environment.step()
    assert [(str(warning.message), warning.filename) for warning in caught] == [(LINE, __file__)]


def test_an_environment_alone_warns_too(lossy: Path) -> None:
    environment = Environment(map=lossy, rig=RIG)
    environment.reset(seed=0)
    with pytest.warns(CadetWarning, match=f"^{LINE}$"):
        environment.step()


def test_cadet_gen_prints_a_maps_losses_in_one_line_however_many_workers_read_it(lossy: Path, tmp_path: Path) -> None:
    done = run(tmp_path / "out", "-n", 8, *SIZE, "--map", lossy, "--workers", 2)
    assert done.returncode == FINE, done.stderr
    assert [line for line in done.stderr.splitlines() if "lossy" in line] == [f"cadet-gen: warning: {LINE}"]


def test_what_finds_no_room_is_warned_of_if_the_user_asked_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cadet._util.notices._said", set())
    crowd = District(name="crowd", parking_occupancy=(0.0, 0.0), num_cars=(500, 500), num_pedestrians=(0, 0))
    crowded = small_policy().with_districts(crowd)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Scene.random(seed=4, rig=RIG, policy=crowded)
        Scene.random(seed=4, rig=RIG, policy=crowded, config=SceneConfig(num_cars=500))
    ((said, place),) = [(str(warning.message), warning.filename) for warning in caught]
    assert re.fullmatch(r"config\.num_cars: \d\d? of 500 find room \(seed 4, episode 0\)", said) and place == __file__


def test_meshes_that_say_too_little_are_warned_of_at_the_callers_line(tmp_path: Path) -> None:
    own = assets_folder(tmp_path / "own")
    for file in ("car.obj", "car.mtl"):
        text = (own / "meshes" / file).read_text()
        (own / "meshes" / file).write_text(text.replace("Glass", "Roof").replace("d 0.2\n", ""))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Assets.read(own)
        Scene.empty(assets=Assets.read(own))
    ((said, place),) = [(str(warning.message), warning.filename) for warning in caught]
    assert "car.obj" in said and "assumed" in said and place == __file__
