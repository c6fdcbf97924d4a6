"""Warnings of what was passed over: once each, where users see them."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

from cadet import Assets, CadetWarning, Environment, Scene, SceneConfig
from cadet.notices import notice
from gen_process import FINE, SIZE, run
from obj_meshes import assets_folder

pytestmark = pytest.mark.usefixtures("fake_core")

LINE = 'lossy.xodr: road "7": lost'


@pytest.fixture
def lossy(tmp_path: Path) -> Path:
    """A map that the fake core reads with a loss. Its text is the test's own, so that it was not spoken of before."""
    path = tmp_path / "lossy.xodr"
    path.write_text(f"<OpenDRIVE><!-- {tmp_path} --></OpenDRIVE>")
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
        Scene.empty(map=lossy)
        Scene.empty(map=lossy)
        environment = Environment(map=lossy)
        environment.reset(seed=0)
        environment.step()
    assert [(str(warning.message), warning.filename) for warning in caught] == [(LINE, __file__)]


def test_an_environment_alone_warns_too(lossy: Path) -> None:
    environment = Environment(map=lossy)
    environment.reset(seed=0)
    with pytest.warns(CadetWarning, match='^lossy.xodr: road "7": lost$'):
        environment.step()


def test_cadet_gen_prints_a_maps_losses_in_one_line_however_many_workers_read_it(lossy: Path, tmp_path: Path) -> None:
    done = run(tmp_path / "out", "-n", 60, *SIZE, "--map", lossy, "--workers", 2)
    assert done.returncode == FINE, done.stderr
    assert [line for line in done.stderr.splitlines() if "lossy" in line] == [f"cadet-gen: warning: {LINE}"]


def test_what_finds_no_room_is_warned_of_if_the_user_asked_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cadet.notices._said", set())
    monkeypatch.setattr("cadet._cadet.Scene.shortfalls", lambda self: [("num_cars", 500, 20), ("num_trams", 3, 0)])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Scene.random(seed=4)
        Scene.random(seed=4, config=SceneConfig(num_cars=500))
    line = "config.num_cars: 20 of 500 find room (seed 4, episode 0)"
    assert [(str(warning.message), warning.filename) for warning in caught] == [(line, __file__)]


def test_meshes_that_say_too_little_are_warned_of_at_the_callers_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cadet._cadet.Assets.assumptions", lambda self: ["car.obj: glass is assumed"])
    own = assets_folder(tmp_path / "own")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Assets.read(own)
        Scene.empty(assets=Assets.read(own))
    assert [(str(warning.message), warning.filename) for warning in caught] == [("car.obj: glass is assumed", __file__)]
