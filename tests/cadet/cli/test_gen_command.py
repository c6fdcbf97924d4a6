"""`cadet gen`: the command of `cadet-gen`, and what its options make of a policy."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

import cadet
from cadet._util.plain_tables import toml_of_table
from cadet.cli.gen import cadet_gen
from cadet.cli.tools import cadet as command
from cadet.generate import Settings, Summary


@pytest.fixture
def given(monkeypatch: pytest.MonkeyPatch) -> list[Settings]:
    """Return what `generate` is called with, in place of writing it."""
    found: list[Settings] = []

    def note(root: Path, settings: Settings, **_: object) -> Summary:
        found.append(settings)
        return Summary(1, 0, Counter())

    monkeypatch.setattr("cadet.cli.gen.generate", note)
    return found


def gen(*arguments: object) -> Result:
    result = CliRunner().invoke(command, ["gen", "out", *map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result


def test_both_commands_are_one() -> None:
    assert command.commands["gen"] is cadet_gen


def test_scans_turn_where_that_is_asked_for(given: list[Settings]) -> None:
    gen("--rolling", "--returns", "last", "--divergence-mrad", 3)
    gen("--rig", "nuscenes", "--no-rolling")
    turning, still = (settings.policy for settings in given)
    for rig, _ in turning.rigs:
        assert rig.lidar == cadet.Lidar("hdl64e_kitti", rolling=True, returns="last", divergence_mrad=3.0)
    assert [rig.lidar.rolling for rig, _ in still.rigs] == [False]


def test_options_and_the_keys_of_a_file_make_the_same_policy(given: list[Settings], tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(cadet.Rig.paper().to_toml().replace('"paper"', '"mine"'))
    values: dict[str, Any] = {
        "policy": "paper",
        "districts": ["quiet", "main_road"],
        "weathers": ["snow"],
        "rig": str(tmp_path / "rig.toml"),
        "lidar": "vlp16",
        "rolling": True,
        "returns": "last",
        "divergence_mrad": 1.5,
        "image_size": [310, 94],
        "hz": 4.0,
        "length_s": 3.0,
    }
    options = {**values, "districts": "quiet,main_road", "weathers": "snow", "image_size": "310x94"}
    arguments = [text for key, value in options.items() for text in (f"--{key.replace('_', '-')}", str(value))]
    arguments.remove("True")
    gen(*arguments, "--write", "depth", "--write", "instance,semantic", "--val-fraction", 0.5)
    (settings,) = given
    (tmp_path / "town.toml").write_text(toml_of_table(values))
    assert settings.policy == cadet.ResetPolicy.read(tmp_path / "town.toml")
    assert settings.policy != cadet.ResetPolicy.paper()
    assert (settings.write, settings.val_fraction) == (("depth", "instance", "semantic"), 0.5)
    gen("--points", "ply,las", "--write", "points_ply", "--policy", tmp_path / "town.toml")
    assert given[1].write == ("points_ply", "points_las")
    assert given[1].policy == settings.policy


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rig", "velo"], "--rig: unknown rig 'velo'; known: kitti, paper"),
        (["--rig", "no.toml"], "--rig: no.toml: no such file"),
        (["--districts", "quiet,town"], "--districts: unknown district 'town'"),
        (["--divergence-mrad", "99"], "--divergence-mrad: Lidar.divergence_mrad: expected a number from 0 to"),
        (["--hz", "7"], "--hz: expected a rate that divides"),
        (["--skip-bad"], "--skip-bad: goes with assets"),
        (["--points", "ply,xyz"], "--points: unknown 'xyz'; known: ply, pcd, las, npz"),
        (["--write", "flow"], "--write: cannot write 'flow'"),
        (["--test-fraction", "0.4"], "--test-fraction: expected a number from 0 to 0.34, got 0.4"),
    ],
)
def test_what_is_wrong_is_said_by_option(arguments: list[str], message: str) -> None:
    with pytest.raises(cadet.CadetError) as caught:
        CliRunner().invoke(command, ["gen", "out", *arguments], catch_exceptions=False)
    assert str(caught.value).startswith(message)
