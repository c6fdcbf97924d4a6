"""Validation during training: what it finds, what it keeps, and that it changes nothing."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import torch
from click.testing import CliRunner

from avod.cli.commands import avod
from avod.config import Config
from avod.detector import Detector
from avod.device import Processes
from avod.evaluate import evaluate_detector, score
from avod.figures import _AP_COLOR, loss_figure
from avod.model.avod.network import AvodNetwork
from avod.train.log import Validated, ValidationLog, read_validations
from avod.validate import Validator
from cadet import kitti
from cadet.errors import CadetError, MissingFileError
from detector.logs import TERMS
from detector.runs import StopAfter, assert_same_training, short_run, weights

STEPS = 8


@pytest.fixture(scope="module")
def validated(config: Config, data: Path, folder: Path) -> Path:
    out = folder / "run"
    short_run(config, data, out, STEPS, val_every=3, validate=Validator(data, "val", config))
    return out


def test_validation_changes_no_step(config: Config, data: Path, validated: Path, tmp_path: Path) -> None:
    short_run(config, data, tmp_path, STEPS)
    assert_same_training(validated, tmp_path)
    rows = read_validations(validated / "val.csv")
    assert [row["step"] for row in rows] == [3, 6, 8]
    assert list(rows[0]) == ["step", *TERMS, "ap", "ap_Car", "ap_Pedestrian"]
    for row in rows:
        assert row["total"] == pytest.approx(sum(row[name] for name in TERMS[:-1]), rel=1e-4)
        assert row["ap"] == pytest.approx((row["ap_Car"] + row["ap_Pedestrian"]) / 2, abs=1e-3)
    assert len({row["total"] for row in rows}) == 3


def test_the_best_checkpoint_is_kept_and_scores_what_the_log_says(data: Path, validated: Path) -> None:
    rows = read_validations(validated / "val.csv")
    best = max(rows, key=lambda row: (row["ap"], row["step"]))
    settings = json.loads((validated / "best_val" / "checkpoint.json").read_text())
    assert settings["step"] == best["step"]
    assert not (validated / "best_val" / "optimizer.safetensors").exists()
    detector = Detector(validated / "best_val")
    ids = kitti.Dataset(data, "val").ids
    report = evaluate_detector(detector, data, ids)
    assert score(report, detector.config.class_names) == pytest.approx(best["ap"], abs=1e-3)
    if best["step"] == STEPS:
        last = weights(validated / "checkpoints" / f"{STEPS:09d}")
        assert all(torch.equal(tensor, last[name]) for name, tensor in weights(validated / "best_val").items())


def test_the_best_of_equal_ones_is_the_last_and_a_worse_one_is_not_kept(tmp_path: Path) -> None:
    log = ValidationLog(tmp_path, 0, TERMS, ("Car",))
    found = [log.add(step, made(ap)) for step, ap in enumerate((30.0, 40.0, 35.0, 40.0, 39.99), start=1)]
    assert found == [True, True, False, True, False]
    # Rows past the step that training goes on from are made again.
    again = ValidationLog(tmp_path, 1, TERMS, ("Car",))
    assert again.steps == [1] and [row["ap"] for row in read_validations(tmp_path / "val.csv")] == [30.0]
    assert again.add(2, made(31.0))
    # What has the same digits in the file is as good, in one process and after a stop.
    assert again.add(3, made(31.00004)) and again.add(4, made(31.00003))
    assert ValidationLog(tmp_path, 4, TERMS, ("Car",)).add(5, made(31.00002))
    with pytest.raises(CadetError, match=r"val.csv:1: expected the columns step, .*, ap, ap_Cyclist$"):
        ValidationLog(tmp_path, 5, TERMS, ("Cyclist",))


def made(ap: float) -> Validated:
    return Validated(dict.fromkeys(TERMS, 1.0), ap, {"Car": ap})


def test_a_validation_that_was_stopped_is_made_when_training_goes_on(
    config: Config, data: Path, validated: Path, tmp_path: Path
) -> None:
    stop = StopAfter(10**9)
    validator = Validator(data, "val", config, should_stop=lambda: True)
    short_run(config, data, tmp_path, STEPS, val_every=3, validate=validator, should_stop=StopAfter(3))
    assert read_validations(tmp_path / "val.csv") == []
    validator = Validator(data, "val", config)
    short_run(config, data, tmp_path, STEPS, val_every=3, validate=validator, should_stop=stop, resume=True)
    assert (tmp_path / "val.csv").read_bytes() == (validated / "val.csv").read_bytes()
    assert_same_training(tmp_path, validated)


def test_workers_and_repetition_change_no_validation(config: Config, data: Path, validated: Path) -> None:
    network = Detector(validated).network
    alone, helped = (Validator(data, "val", config, workers=n)(network, 8, Processes()) for n in (0, 2))
    assert alone is not None and alone == helped
    assert alone.losses["total"] == pytest.approx(read_validations(validated / "val.csv")[-1]["total"], rel=1e-4)


def test_losses_of_validation_are_those_of_training_without_its_draws(config: Config, data: Path) -> None:
    # An untrained network tells the classes apart by nothing: the logarithm of their number, within its noise.
    torch.manual_seed(0)
    network = AvodNetwork(config)
    for head in (network.anchor_classifier, network.second_stage):
        for output in head.outputs:
            assert isinstance(output, torch.nn.Linear)
            torch.nn.init.zeros_(output.weight)
    found = Validator(data, "val", config)(network, 0, Processes())
    assert found is not None
    assert found.losses["objectness"] == pytest.approx(math.log(2), rel=1e-4)
    assert found.losses["classification"] == pytest.approx(math.log(3), rel=1e-4)


def test_outputs_that_are_no_numbers_are_named(config: Config, data: Path) -> None:
    network = AvodNetwork(config)
    torch.nn.init.constant_(network.second_stage.outputs[0].bias, math.nan)  # type: ignore[arg-type]
    with pytest.raises(CadetError, match=r"^validation after step 7: the outputs on frame 000003 are not finite$"):
        Validator(data, "val", config)(network, 7, Processes())


def test_the_command_validates_and_draws(data: Path, folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    options = ["--config", folder / "small.toml", "--data", data, "--out", out, "--steps", 4, "--val-every", 2]
    call("train", *options)
    assert [row["step"] for row in read_validations(out / "val.csv")] == [2, 4]
    call("train", "--out", out, "--resume", "--steps", 5)
    assert [row["step"] for row in read_validations(out / "val.csv")] == [2, 4, 5], "said once, it stays"
    call("view", "--log", out, "-o", tmp_path / "a.png")
    assert (tmp_path / "a.png").is_file()
    options[7:] = [3, "--val-every", 2, "--val-split", "nosuch"]
    with pytest.raises(
        MissingFileError, match=r"nosuch\.txt: no such split: choose another list \(train, trainval, val\)"
    ):
        call("train", *options)


def call(*arguments: object) -> None:
    command = [str(argument) for argument in (*arguments, "--workers", 0)] if arguments[0] == "train" else None
    result = CliRunner().invoke(avod, command or [str(argument) for argument in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output


def test_the_figure_shows_ap_at_its_height() -> None:
    terms = dict.fromkeys(TERMS, 1.0)
    rows = [{"step": 10.0 * k, **terms} for k in range(1, 41)]
    validations = [{"step": 100.0 * k, **terms, "ap": ap} for k, ap in enumerate((0.0, 50.0, 100.0, 75.0), start=1)]
    image = loss_figure(rows, validations)
    is_ap = (np.abs(image.astype(int) - np.array(_AP_COLOR)).max(axis=2) < 40)[:, :808]
    for step, ap in ((100, 0.0), (200, 50.0), (300, 100.0), (400, 75.0)):
        column = round(60 + (step - 10) / 390 * 750)
        row = round(440 - ap / 100 * 420)
        assert is_ap[max(row - 4, 0) : row + 5, max(column - 5, 0) : column + 3].any(), (step, ap)
    assert not (np.abs(loss_figure(rows).astype(int) - np.array(_AP_COLOR)).max(axis=2) < 20).any()
