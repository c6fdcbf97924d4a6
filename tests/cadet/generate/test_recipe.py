"""Recipes: the same settings back from the file, the same bytes again, and what does not fit is said."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from cadet import CadetError, Lidar, MissingFileError, ResetPolicy, Rig, __version__
from cadet.cli.gen import cadet_gen
from cadet.cli.verify import verify_command
from cadet.errors import FrameExistsError
from cadet.generate import Recipe, Settings, compare, generate, generate_frame
from cadet.generate.golden_frames import generator
from cadet.generate.settings import FORMAT_VERSION
from gen_process import tree
from small_runs import ROAD

KITTI = ResetPolicy.kitti()
QUICK = replace(
    KITTI.with_each_rig(lambda rig: rig.with_lidar(Lidar.vlp16()).with_image_size(64, 32)), samples_per_episode=2
)
SETTINGS = {
    "plain": Settings(policy=KITTI),
    "paper": Settings(policy=ResetPolicy.paper(), seed=2**63 - 1, num_frames=10_000, test_fraction=0.1),
    "shards": Settings(policy=KITTI.with_weathers("snow"), format="webdataset", shard_size=10, write=("depth",)),
    "sequence": Settings(policy=KITTI.as_sequence(hz=10.0), format="nuscenes", rig=Rig.named("nuscenes")),
    "own": Settings(policy=replace(QUICK, name="own", sun_elevation_deg=(5.0, 20.0)), val_fraction=0.0),
}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a set of three frames in two episodes."""
    out = tmp_path_factory.mktemp("made") / "out"
    generate(out, Settings(policy=QUICK, seed=4, num_frames=3), workers=1)
    return out


def gen(*arguments: object) -> Result:
    return CliRunner().invoke(cadet_gen, [*map(str, arguments)])


def verify(*arguments: object) -> Result:
    return CliRunner().invoke(verify_command, [*map(str, arguments)], standalone_mode=False)


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
def test_a_recipe_gives_its_settings_back(settings: Settings) -> None:
    recipe = Recipe(settings, "0" * 64)
    assert Recipe.from_toml(recipe.to_toml()) == recipe
    assert Recipe(settings).to_toml() != recipe.to_toml()


@pytest.mark.parametrize("name", ["plain", "paper", "shards", "sequence"])
def test_a_recipe_from_a_preset_is_short(name: str) -> None:
    assert len(Recipe(SETTINGS[name], "0" * 64).to_toml()) < 500


def test_a_dataset_is_made_again_from_the_recipe_in_it(made: Path, tmp_path: Path) -> None:
    done = gen(tmp_path / "again", "--recipe", made / "recipe.toml", "--workers", 1)
    assert done.exit_code == 0 and "manifest.json is the recipe's" in done.output, done.output
    assert tree(tmp_path / "again") == tree(made)


def test_a_longer_run_has_a_recipe_of_its_own(made: Path, tmp_path: Path) -> None:
    out = shutil.copytree(made, tmp_path / "out")
    generate(out, Settings(policy=QUICK, seed=4, num_frames=4), workers=1, resume=True)
    old, new = Recipe.read(made / "recipe.toml"), Recipe.read(out / "recipe.toml")
    assert (old.settings.num_frames, new.settings.num_frames) == (3, 4)
    assert old.manifest_sha256 != new.manifest_sha256


def test_a_frame_alone_is_that_of_the_whole_dataset(made: Path, tmp_path: Path) -> None:
    assert gen(tmp_path / "one", "--recipe", made / "recipe.toml", "--frame", 1).exit_code == 0
    assert tree(tmp_path / "one") == {name: digest for name, digest in tree(made).items() if "/000001." in name}
    # The second frame of the first episode is no frame of the second one.
    names = generate_frame(tmp_path / "one", Settings(policy=QUICK, seed=4, num_frames=3), 2)
    assert {name: tree(tmp_path / "one")[name] for name in names}.items() <= tree(made).items()


def test_a_dataset_that_is_its_recipes_is_told_from_one_that_is_not(made: Path, tmp_path: Path) -> None:
    out = shutil.copytree(made, tmp_path / "out")
    fine = verify(out)
    # Six files a frame, and the manifest.
    assert (fine.return_value, fine.output) == (
        0,
        "3 of 3 frames made again: 19 of 19 files are the recipe's, byte for byte\n",
    )
    scan = bytearray((out / "training/velodyne/000002.bin").read_bytes())
    scan[0] ^= 1
    (out / "training/velodyne/000002.bin").write_bytes(scan)
    (out / "training/label_2/000000.txt").unlink()
    bad = verify(out)
    assert bad.return_value == 1
    assert bad.output == (
        "missing  training/label_2/000000.txt\n"
        "differs  training/velodyne/000002.bin\n"
        "3 of 3 frames made again: 17 of 19 files are the recipe's, byte for byte\n"
    )


def test_another_manifest_is_found_whatever_frames_are_drawn(made: Path) -> None:
    recipe = replace(Recipe.read(made / "recipe.toml"), manifest_sha256="0" * 64)
    assert compare(made, recipe, num_frames=1).differing == ("manifest.json",)
    other = compare(made, replace(recipe, settings=Settings(policy=QUICK, seed=5, num_frames=3)), num_frames=1)
    assert len(other.differing) > 1


def test_maps_are_named_by_hand(made: Path, tmp_path: Path) -> None:
    (tmp_path / "street.xodr").write_text(ROAD.xodr)
    (tmp_path / "by_hand.toml").write_text('seed = 5\nmaps = ["street.xodr"]\n')
    settings = Recipe.read(tmp_path / "by_hand.toml").settings
    assert settings == Settings(policy=replace(KITTI, maps=settings.policy.maps), seed=5)
    assert settings.policy.maps[0].sha256 == ROAD.sha256


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (
            ('cadet = "', 'cadet = "9'),
            f"cadet: the recipe is of '9{__version__}', this is '{__version__}', which gives ",
        ),
        (("format_version = ", "format_version = 9"), f"format_version: the recipe is of 9{FORMAT_VERSION}, this is "),
        (('generator = "', 'generator = "9'), f"generator: the recipe is of '9{generator()}', this is "),
        (("seed = ", "sed = "), "sed: unknown key; known: cadet, format_version, generator, manifest_sha256, seed, "),
        (("num_frames = 3", "num_frames = 0"), "Settings.num_frames: expected a whole number from 1 to 1000000, got 0"),
        (('"kitti"', '"kiti"'), "unknown format 'kiti'; known: kitti, "),
    ],
)
def test_a_recipe_that_is_wrong_is_refused(made: Path, tmp_path: Path, change: tuple[str, str], line: str) -> None:
    file = tmp_path / "recipe.toml"
    file.write_text((made / "recipe.toml").read_text().replace(*change, 1))
    with pytest.raises(CadetError) as caught:
        Recipe.read(file)
    assert str(caught.value).startswith(f"{file}: {line}"), caught.value


def test_what_does_not_go_with_a_recipe_is_refused(made: Path, tmp_path: Path) -> None:
    recipe = made / "recipe.toml"
    asked = gen(tmp_path / "out", "--recipe", recipe, "--seed", 3).exception
    assert str(asked) == "--seed: the recipe has all settings; leave it out, or change the recipe"
    for option in (["--workers", 2], ["--resume"], ["-n", 7]):
        ignored = gen(tmp_path / "out", "--seed", 1, "--frame", 3, *option).exception
        assert isinstance(ignored, CadetError) and "--frame writes one frame alone; leave it out" in str(ignored)
    beyond = gen(tmp_path / "out", "--recipe", recipe, "--frame", 3).exception
    assert str(beyond) == "frame: expected a whole number from 0 to 2, got 3"
    assert not (tmp_path / "out").exists()
    with pytest.raises(FrameExistsError, match=r"000001\.png is there: name another folder"):
        generate_frame(made, Recipe.read(recipe).settings, 1)
    with pytest.raises(CadetError, match="webdataset does not"):
        generate_frame(tmp_path / "out", SETTINGS["shards"], 1)
    (tmp_path / "other.toml").write_text(recipe.read_text().replace('manifest_sha256 = "', 'manifest_sha256 = "0'))
    other = gen(tmp_path / "out", "--recipe", tmp_path / "other.toml", "--workers", 1).exception
    assert "is whole, but not the dataset that" in str(other)
    (tmp_path / "out/recipe.toml").unlink()
    with pytest.raises(MissingFileError, match=r"there is no recipe\.toml in it: name one with --recipe"):
        raise verify(tmp_path / "out").exception or AssertionError
    with pytest.raises(MissingFileError, match="no dataset of cadet-gen's: there is no manifest"):
        compare(tmp_path, Recipe.read(recipe))
