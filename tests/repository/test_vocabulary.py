"""One name for each setting, over commands, TOML files, and Python."""

from __future__ import annotations

import re

import click
import pytest

pytest.importorskip("torch", reason="needs torch")

from vocabulary import COMMAND_ONLY, NOT_ALIKE, PAGE, commands, fields, keys, normal, options, page, parameters


def test_every_option_is_a_name_of_python() -> None:
    python = {*fields(), *parameters()}
    assert {name for name in options() if name not in python} == {*COMMAND_ONLY}


def test_every_key_of_a_file_is_a_name_of_python() -> None:
    # What a policy builds on, and a configuration; the images' size goes into a camera, a pose into a rig.
    own = {"base", "image_size", "position_in_ego_m", "roll_pitch_yaw_deg"}
    assert {name for name in keys() if name not in {*fields(), *parameters()}} == own


def test_no_two_names_mean_one_thing() -> None:
    alike: dict[str, set[str]] = {}
    for name in {*options(), *keys(), *fields(), *parameters()}:
        alike.setdefault(normal(name), set()).add(name)
    assert [names for names in alike.values() if len(names) > 1 and names not in NOT_ALIKE] == []


def test_a_flag_and_its_negation_are_one_option() -> None:
    for words, command in commands():
        for option in command.params:
            for text in option.secondary_opts:
                assert text in ("--loose", f"--no-{option.opts[0][2:]}"), words


def test_help_shows_no_default_that_only_python_writes() -> None:
    for words, command in commands():
        text = command.get_help(click.Context(command, info_name=words))
        assert not re.search(r"default:\s+(\(|\[|None|<)", text), words


def test_the_page_lists_all_names() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run python tests/support/vocabulary.py --write"
