"""Configurations: what comes with the package, what is refused, and that nothing is lost on the way to a checkpoint."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avod.config import Config, ObjectClass
from avod.config.base import config_names, table_of_settings
from avod.config.tables import changed_config, config_from_table, table_from_config
from cadet.bev import BevConfig
from cadet.errors import CadetError, MissingFileError


def test_car_default_writes_every_default_down() -> None:
    assert Config.named("car_default") == Config()


@pytest.mark.parametrize("name", config_names())
def test_a_configuration_survives_json(name: str) -> None:
    config = Config.named(name)
    assert config_from_table(json.loads(json.dumps(table_from_config(config))), "checkpoint.json") == config


@pytest.mark.parametrize("prefix", ["car", "ped"])
def test_the_papers_three_maps_change_the_maps_alone(prefix: str) -> None:
    default = Config.named(f"{prefix}_default")
    for name, bev in (("max3_density3", BevConfig.max3_density3()), ("max_min_density", BevConfig.max_min_density())):
        changed = Config.named(f"{prefix}_{name}")
        assert changed.bev == bev
        assert table_from_config(changed) | {"bev": None} == table_from_config(default) | {"bev": None}


def test_class_groups() -> None:
    assert Config.named("people_default").class_names == ("Pedestrian", "Cyclist")
    assert Config.named("all_default").class_names == ("Car", "Pedestrian", "Cyclist")
    people = Config.named("people_default")
    assert (people.rpn.proposals, people.rpn.positive_iou) == (1024, 0.45)
    assert (people.second_stage.negative_iou, people.second_stage.positive_iou) == (0.45, 0.55)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[rpn]\nhiden = 3", "{file}: rpn.hiden: unknown key; known: crop_size, bottleneck_channels, hidden, "),
        ('[rpn]\n"hid\\nen" = 3', "{file}: rpn.'hid\\nen': unknown key; known: crop_size, "),
        ("epochs = 3", "{file}: epochs: unknown key; known: classes, network, ignored_types, ground, bev, "),
        ("[[classes]]\nname = 'Car'\nsizes = []", "{file}: classes[0].sizes: unknown key; known: name, "),
        ("[rpn]\nhidden = 2.5", "{file}: rpn.hidden: expected a whole number, got 2.5"),
        ("[rpn]\nhidden = true", "{file}: rpn.hidden: expected a whole number, got True"),
        ("[rpn]\nhidden = 0", "{file}: rpn: RpnConfig.hidden: expected a whole number from 1 to 65536, got 0"),
        ("rpn = 3", "{file}: rpn: expected a table, got 3"),
        ("[image]\nsize = [1200]", "{file}: image.size: expected 2 values, got 1"),
        ("[image]\nsize = [1201, 360]", "{file}: Config.image.size[0]: expected a multiple of 8, got 1201"),
        (
            "[second_stage]\ngradient = 'some'",
            "{file}: second_stage.gradient: expected one of 'through', 'stopped', got",
        ),
        (
            "[bev]\nslice_maps = ['mean']",
            "{file}: bev.slice_maps[0]: expected one of 'max_height', 'min_height', 'dens",
        ),
        (
            "[[classes]]\nname = 'DontCare'",
            "{file}: classes[0]: ObjectClass.name: expected a type of labels such as Car, got 'D",
        ),
        ("ground = 'flat'", "{file}: ground: expected one of 'file', 'estimated', got 'flat'"),
        ("rpn = ", "{file}: invalid TOML: "),
        ("base = 'nothing'", "{file}: base: unknown configuration 'nothing'; known: all_default, "),
    ],
)
def test_nonsense_is_refused_by_file_and_key(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(CadetError) as error:
        Config.named(path)
    assert str(error.value).startswith(message.format(file=path))


def test_a_file_builds_on_another(tmp_path: Path) -> None:
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    first.write_text("base = 'tiny_car'\n[rpn]\nhidden = 7\n")
    second.write_text(f"base = '{first}'\n[rpn]\ncrop_size = 4\n")
    config = Config.named(second)
    assert (config.rpn.hidden, config.rpn.crop_size) == (7, 4)
    assert config.bev == Config.named("tiny_car").bev
    first.write_text(f"base = '{second}'\n")
    with pytest.raises(CadetError, match="in a circle"):
        Config.named(first)
    with pytest.raises(MissingFileError, match="no such file"):
        Config.named(tmp_path / "third.toml")
    with pytest.raises(CadetError, match="a path of 305 bytes"):
        Config.named("x" * 300 + ".toml")


def test_the_same_class_twice_is_refused() -> None:
    with pytest.raises(CadetError, match="each once"):
        Config(classes=(ObjectClass(), ObjectClass()))


def test_a_configuration_is_written_as_toml() -> None:
    for name in config_names():
        config = Config.named(name)
        assert Config.from_toml(config.to_toml()) == config


def test_settings_change_a_configuration_by_key() -> None:
    config = Config.named("tiny_car")
    given = ["training.learning_rate=1e-3", "rpn.hidden = 7", "ground=file", "image.size=[1200, 360]"]
    changed = changed_config(config, table_of_settings(given))
    assert (changed.training.learning_rate, changed.rpn.hidden, changed.ground) == (1e-3, 7, "file")
    assert changed.image.size == (1200, 360) and changed.rpn.crop_size == config.rpn.crop_size
    assert changed_config(config, {}) is config
    for text, message in (
        ("rpn.hiden=7", r"^--set: rpn\.hiden: unknown key; known: crop_size"),
        ("rpn.hidden=wide", r"^--set: rpn\.hidden: expected a whole number, got 'wide'"),
        ("rpn.hidden", r"^--set: expected KEY=VALUE such as training\.learning_rate=1e-4, got 'rpn\.hidden'"),
        ("a b=1", r"^--set: expected KEY=VALUE"),
    ):
        with pytest.raises(CadetError, match=message):
            changed_config(config, table_of_settings([text]))
