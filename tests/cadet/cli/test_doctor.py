"""`cadet doctor`."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from cadet._util.extras import EXTRAS, Extra
from cadet.cli import doctor

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PROJECT = Path(__file__).parents[3] / "pyproject.toml"
SAME = "Bytes: a seed gives the same frames here as on other machines"


def run(monkeypatch: pytest.MonkeyPatch, **changes: object) -> tuple[int, str]:
    for name, value in {"num_processors": lambda: 2, "_episode_s": lambda _: 4.8, **changes}.items():
        monkeypatch.setattr(doctor, name, value)
    # The core reads the number of threads once, in whatever process uses it first.
    monkeypatch.setattr(doctor, "prepare", lambda _: None)
    done = CliRunner().invoke(doctor.doctor_command, standalone_mode=False)
    return done.return_value, done.output


def test_the_extras_are_the_packages() -> None:
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    assert set(EXTRAS) == set(extras) - {"dev", "docs"}
    for name, extra in EXTRAS.items():
        found = [line.split(">")[0].removesuffix("-sdk") for line in extras[name]]
        assert found == [*extra.modules]


def test_what_is_missing_is_told_with_the_way_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    extras = {"json": Extra("nothing", ("json",)), "odd": Extra("much", ("json", "no_such_module"))}
    code, text = run(monkeypatch, EXTRAS=extras, stored=lambda: {"kitti": "0"}, _PROMISED=("other", "x86_64"))
    assert code == 0
    assert "json   nothing   installed\n" in text
    assert "odd    much      missing no_such_module: pip install 'cadet-sim[odd]'\n" in text
    assert "than on Linux on x86-64, for which alone they are promised\n" in text
    # 50 episodes of 4.8 s on two processors.
    assert text.endswith("Speed: cadet-gen -n 1000 takes about 2.0 minutes\n")


def test_other_bytes_than_promised_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    assert SAME in run(monkeypatch)[1]
    monkeypatch.setattr(doctor, "_PROMISED", (sys.platform, "x86_64"))
    code, text = run(monkeypatch, stored=lambda: {"kitti": "0" * 64})
    assert (code, "please report it with this text" in text) == (1, True)
