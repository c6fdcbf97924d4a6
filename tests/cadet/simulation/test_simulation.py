"""A simulation's TOML file: what it may say, and what is refused with file and key."""

from __future__ import annotations

from pathlib import Path

import pytest

import cadet
from cadet.errors import CadetError, FileFormatError, MissingFileError
from cadet.simulation.simulation import Simulation
from mesh_files.obj_meshes import assets_folder


def read(folder: Path, text: str) -> Simulation:
    (folder / "town.toml").write_text(text)
    return Simulation.read(folder / "town.toml")


def test_an_empty_file_is_the_stream_of_cadet_gen(tmp_path: Path) -> None:
    found = read(tmp_path, "")
    assert found == Simulation(cadet.ResetPolicy.kitti(), 0)


def test_every_key_changes_what_it_names(tmp_path: Path) -> None:
    assets_folder(tmp_path / "mine")
    (tmp_path / "mine.toml").write_text(cadet.Lidar.vlp16().to_toml())
    found = read(
        tmp_path,
        'seed = 7\npolicy = "paper"\ndistricts = ["country_road", "quiet"]\nlidar = "mine.toml"\n'
        'image_size = [310, 94]\nweathers = ["snow", "dusk"]\n'
        'assets = "mine"\nsamples_per_episode = 3\nvehicle_shares = {Car = 0.8, Van = 0.2}\n',
    )
    policy = found.policy
    assert (found.seed, policy.name, policy.samples_per_episode) == (7, "paper", 3)
    assert [weather.name for weather, _ in policy.weathers] == ["snow", "dusk"]
    assert [district.name for district, _ in policy.districts] == ["country_road", "quiet"]
    assert [district.vehicle_shares for district, _ in policy.districts] == [{"Car": 0.8, "Van": 0.2}] * 2
    assert policy.assets is not None
    for rig, _ in policy.rigs:
        assert (rig.camera.width, rig.camera.height) == (310, 94)
        assert rig.lidar._to_native().num_rings == 16
    assert read(tmp_path, 'rig = "nuscenes"').policy.rigs[0][0].name == "nuscenes"


def test_simulations_differ_where_their_frames_do(tmp_path: Path) -> None:
    texts = ["", "seed = 1", 'policy = "paper"', "image_size = [310, 94]", 'lidar = "vlp16"', 'weathers = ["snow"]']
    identities = [str(read(tmp_path, text).identity()) for text in texts]
    assert len(set(identities)) == len(texts)
    assert str(read(tmp_path, "seed = 0").identity()) == identities[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("sead = 1", "sead: unknown key; known: seed, policy, "),
        ("seed = -1", "seed: expected a whole number from 0"),
        ("seed = ", "invalid TOML"),
        ('policy = "town"', "policy: "),
        ('districts = ["town"]', "districts: unknown district 'town'; known: parked_rows, "),
        ("policy = 3", "policy: unknown policy 3; known: kitti, paper"),
        ('rig = "car"', "rig: "),
        ("vehicle_shares = {Bus = 1}", "vehicle_shares: District.vehicle_shares: expected weights by class (Car, "),
        ('lidar = "missing.toml"', "lidar: "),
        ("image_size = [310]", "image_size: expected (width, height), got [310]"),
        ('weathers = "snow"', "weathers: expected a list of strings, got 'snow'"),
        ('weathers = ["hail"]', "weathers: "),
        ('maps = ["missing.xodr"]', "maps: "),
        ('assets = "missing"', "assets: "),
        ("samples_per_episode = 0", "samples_per_episode: "),
    ],
)
def test_what_is_wrong_is_said_with_file_and_key(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(FileFormatError) as refused:
        read(tmp_path, text)
    assert str(refused.value).startswith(f"{tmp_path}/town.toml: {said}")
    assert "\n" not in str(refused.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"none\.toml: no such file"):
        Simulation.read(tmp_path / "none.toml")
    with pytest.raises(CadetError, match="path: expected a path"):
        Simulation.read(3)  # type: ignore[arg-type]
