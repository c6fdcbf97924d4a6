"""`avod worth`: a fixed training, its AP on other frames, and the error whose mending brings the most."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from avod import worth as module
from avod.cli import worth as command
from avod.cli.commands import avod
from avod.config import Config
from avod.train import with_steps
from avod.worth import REMEDIES, STEPS, fixed_recipe
from cadet.evaluation.analysis import analyze
from cadet.evaluation.analysis.mending import MENDED
from detector.runs import write_set
from synthetic import make_frame

CONFIG_FILE = Path(__file__).parents[1] / "support" / "detector" / "center.toml"


def call(*arguments: object) -> Result:
    return CliRunner().invoke(avod, ["worth", *map(str, arguments)], catch_exceptions=False)


def test_budgets_differ_in_their_steps_alone() -> None:
    recipes = [fixed_recipe(minutes) for minutes in STEPS]
    assert [recipe.training.steps for recipe in recipes] == sorted(STEPS.values())
    assert len({with_steps(recipe, 1) for recipe in recipes}) == 1


def test_the_error_that_was_made_is_the_first_to_mend() -> None:
    assert set(REMEDIES) < set(MENDED)
    (car,) = (label for label in make_frame().labels if label.type == "Car" and label.truncated == 0.0)
    x, y, z = car.location_cam
    moved = dataclasses.replace(car, location_cam=(x + 0.6, y, z), score=0.9)
    ids = [f"{k:06d}" for k in range(50)]
    analysis = analyze(dict.fromkeys(ids, (car,)), dict.fromkeys(ids, (moved,)), parts=("errors",), classes=("Car",))
    (first, gain), *others = module._gains(analysis, "Car")
    assert first == "place" and gain == pytest.approx(100.0)
    assert all(value == pytest.approx(0.0) for name, value in others if name in ("size", "vertical", "heading"))


def test_the_command_trains_tests_and_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data, out = write_set(tmp_path / "set"), tmp_path / "out"
    config = with_steps(Config.named(str(CONFIG_FILE)), 2)
    config = dataclasses.replace(config, detection=dataclasses.replace(config.detection, min_score=0.0))
    monkeypatch.setattr(command, "fixed_recipe", lambda minutes: config)
    result = call(data, "--test", data, "--test-split", "val", "--out", out, "--workers", 0)
    assert result.exit_code == 0, result.output
    assert f"2 frames of {data}, 2 steps on {data}" in result.output
    assert "AP if one kind of error were corrected" in result.output and "95 %" in result.output
    again = call(data, "--test", data, "--out", out, "--resume", "--workers", 0)
    assert again.exit_code == 0 and f"5 frames of {data}, 2 steps" in again.output
