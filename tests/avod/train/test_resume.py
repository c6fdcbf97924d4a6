"""A training that stops, by whatever, and goes on: the same numbers, or a clear refusal."""

from __future__ import annotations

import dataclasses
import json
import multiprocessing
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import torch
from click.testing import CliRunner

import avod.train.run as run_module
from avod.cli.commands import avod
from avod.cli.stopping import Stopping
from avod.config import Config
from avod.detector import Detector
from avod.predict import predict
from avod.train import step as step_module
from avod.train.checkpoint import checkpoints
from avod.train.log import read_log
from avod.train.settings import read_record
from avod.train.step import NonFiniteLossError
from avod.validate import Validator
from cadet.errors import CadetError, CadetWarning, MissingFileError
from detector.runs import StopAfter, assert_same_training, short_run

STEPS = 14


@pytest.fixture(scope="module")
def unbroken(config: Config, data: Path, folder: Path) -> Path:
    short_run(config, data, folder / "unbroken", STEPS)
    return folder / "unbroken"


def copied(run: Path, to: Path) -> Path:
    shutil.copytree(run, to)
    return to


@pytest.mark.parametrize("workers", [0, 2])
def test_a_training_that_stops_and_goes_on_equals_one_that_never_stopped(
    config: Config, data: Path, unbroken: Path, tmp_path: Path, workers: int
) -> None:
    # Between two checkpoints and between two rows of the log; at a checkpoint; and right before the last step.
    for after, name in ((4, "000000004"), (2, "000000006"), (7, "000000013")):
        is_new = not (tmp_path / "run.json").exists()
        last = short_run(
            config, data, tmp_path, STEPS, workers=workers, resume=not is_new, should_stop=StopAfter(after)
        )
        assert last.name == name and (last / "optimizer.safetensors").is_file()
    short_run(config, data, tmp_path, STEPS, workers=workers, resume=True)
    assert_same_training(tmp_path, unbroken)


@pytest.mark.parametrize("workers", [0, 2])
def test_the_callers_random_numbers_are_left_alone(
    config: Config, data: Path, unbroken: Path, tmp_path: Path, workers: int
) -> None:
    torch.manual_seed(7)
    before = torch.get_rng_state()
    validator = Validator(data, "val", config, workers=workers)
    short_run(config, data, tmp_path / "run", 2, workers=workers, validate=validator, val_every=1)
    assert torch.equal(torch.get_rng_state(), before)
    assert len(list(predict(Detector(unbroken), data, ("000003", "000004"), workers=workers))) == 2
    assert torch.equal(torch.get_rng_state(), before)


def start(*arguments: object) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3] / "python")}
    command = [sys.executable, "-m", "avod", *map(str, arguments), "--threads", "1", "--workers", "1"]
    return subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True)


@pytest.mark.timeout(400)  # starts PyTorch
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL, signal.SIGINT])
def test_a_process_that_a_signal_ends_leaves_a_training_that_goes_on(
    config: Config, data: Path, unbroken: Path, folder: Path, tmp_path: Path, number: signal.Signals
) -> None:
    out = tmp_path / "run"
    begin = ("train", "--config", folder / "small.toml", "--data", data, "--out", out, "--steps", STEPS)
    process = start(*begin)
    while not checkpoints(out / "checkpoints"):
        assert process.poll() is None
        time.sleep(0.01)
    # To the workers too, as Ctrl-C and most managers of jobs do.
    os.killpg(process.pid, number)
    message = process.communicate()[1]
    if number == signal.SIGKILL:
        assert process.returncode == -signal.SIGKILL
    else:
        reason = "interrupted" if number == signal.SIGINT else "ended by SIGTERM"
        assert process.returncode == 128 + number
        expected = rf"{reason}; last checkpoint: (\S+); to continue: avod train --out {out} --resume"
        found = re.fullmatch(expected, message.splitlines()[-1])
        assert found and int(Path(found[1]).name) < STEPS, message
    assert len(checkpoints(out / "checkpoints")) < 5
    assert call("train", "--out", out, "--resume").return_value == 0
    assert_same_training(out, unbroken)


def test_what_went_on_from_another_training_and_was_killed_at_once_does_so_again(
    config: Config, data: Path, unbroken: Path, tmp_path: Path
) -> None:
    def die(step: int, losses: dict[str, Any]) -> None:
        raise ZeroDivisionError

    config = dataclasses.replace(config, training=dataclasses.replace(config.training, checkpoint_steps=100))
    short_run(config, data, tmp_path / "whole", STEPS + 4, resume_from=unbroken)
    with pytest.raises(ZeroDivisionError):
        short_run(config, data, tmp_path / "parts", STEPS + 4, resume_from=unbroken, on_step=die)
    assert not checkpoints(tmp_path / "parts" / "checkpoints")
    assert read_record(tmp_path / "parts").resume_from == str(checkpoints(unbroken / "checkpoints")[-1])
    # Killed after a checkpoint of its own, it goes on from that one.
    for after in (1, 2):
        short_run(config, data, tmp_path / "parts", STEPS + 4, resume=True, should_stop=StopAfter(after))
    short_run(config, data, tmp_path / "parts", STEPS + 4, resume=True)
    assert_same_training(tmp_path / "parts", tmp_path / "whole")


def test_no_worker_outlives_a_training_that_fails(config: Config, data: Path, tmp_path: Path) -> None:
    def fail(step: int, losses: dict[str, Any]) -> None:
        raise ZeroDivisionError(str(step))

    with pytest.raises(ZeroDivisionError) as info:
        short_run(config, data, tmp_path, STEPS, workers=2, on_step=fail)
    # Python waits for its children at the end, and these hear no signal: gone while the error is still held.
    assert info.tb is not None and multiprocessing.active_children() == []


def test_a_second_signal_ends_at_once_and_signals_come_back() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with Stopping(None) as stopping:
        assert not stopping()
        signal.raise_signal(signal.SIGTERM)
        assert stopping() and stopping.exit_code == 143 and stopping.reason == "ended by SIGTERM"
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGTERM) == before


def call(*arguments: object) -> Any:
    return CliRunner().invoke(
        avod,
        [str(argument) for argument in (*arguments, "--workers", 0)],
        standalone_mode=False,
        catch_exceptions=False,
    )


def test_a_training_that_is_out_of_time_says_so(data: Path, folder: Path, unbroken: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    options = ("--config", folder / "small.toml", "--data", data, "--out", out, "--steps", STEPS)
    result = call("train", *options, "--max-minutes", 1e-6)
    assert result.return_value == 75
    assert f"the time is up; last checkpoint: {out}/checkpoints/000000001; to continue" in result.output
    # What is not said again is as it was, the number of steps too.
    assert call("train", "--out", out, "--resume").return_value == 0
    assert_same_training(out, unbroken)


def test_a_training_that_was_killed_before_its_first_checkpoint_begins_again(
    config: Config, data: Path, unbroken: Path, tmp_path: Path
) -> None:
    class KilledError(Exception):
        pass

    def kill(step: int, losses: object) -> None:
        if step == 2:
            raise KilledError

    with pytest.raises(KilledError):
        short_run(config, data, tmp_path / "run", STEPS, on_step=kill)
    assert not checkpoints(tmp_path / "run" / "checkpoints")
    short_run(config, data, tmp_path / "run", STEPS, resume=True)
    assert_same_training(tmp_path / "run", unbroken)
    for empty in ("none", "run/checkpoints"):
        with pytest.raises(MissingFileError, match=r"holds no training that --resume could go on with$"):
            short_run(config, data, tmp_path / empty, STEPS, resume=True)


def test_a_step_without_a_finite_loss_is_named_and_can_be_left_out(
    config: Config, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trained: list[int] = []
    right = step_module.training_step

    def step_without(*arguments: Any, step: int, **others: Any) -> Any:
        if step == 4:
            raise NonFiniteLossError("step 4: the box loss of frame 000001 is nan")
        trained.append(step)
        return right(*arguments, step=step, **others)

    monkeypatch.setattr(run_module, "training_step", step_without)
    out = tmp_path / "run"
    message = (
        rf"^step 4: the box loss of frame 000001 is nan; look .* or go on .* by --out {out} --resume --skip-steps 4$"
    )
    with pytest.raises(NonFiniteLossError, match=message):
        short_run(config, data, out, STEPS)
    with pytest.raises(CadetError, match="--skip-steps 2: 3 steps are done"):
        short_run(config, data, out, STEPS, resume=True, skip_steps=(2,))
    trained.clear()
    # It stops once more before the step; what was said is remembered.
    short_run(config, data, out, STEPS, resume=True, skip_steps=(4,), should_stop=StopAfter(1))
    seen: list[tuple[int, bool]] = []
    short_run(config, data, out, STEPS, resume=True, on_step=lambda step, losses: seen.append((step, bool(losses))))
    assert trained == [3, *range(5, STEPS)]
    assert seen == [(step, step != 5) for step in range(5, STEPS + 1)]
    assert read_record(out).skipped_steps == (4,)
    short_run(config, data, tmp_path / "known", STEPS, skip_steps=(4,))
    assert_same_training(out, tmp_path / "known")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": 3}, r"trained with seed 0, which --seed 3 cannot change"),
        ({"split": None}, r"its training has split = 'train', and is to go on with None: it would be another training"),
        ({"init": "tiny_car"}, "not both"),
        ({"init_refinement": "tiny_car"}, "not both"),
        ({"resume_from": "tiny_car"}, "not both"),
    ],
)
def test_changes_that_make_another_training_are_refused(
    config: Config, data: Path, unbroken: Path, tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    out = copied(unbroken, tmp_path / "run")
    with pytest.raises(CadetError, match=message):
        short_run(config, data, out, STEPS + 1, resume=True, **change)


def test_a_schedule_that_spans_the_steps_keeps_their_number(config: Config, data: Path, tmp_path: Path) -> None:
    cycle = dataclasses.replace(config, training=dataclasses.replace(config.training, schedule="one_cycle"))
    short_run(cycle, data, tmp_path, STEPS, should_stop=StopAfter(1))
    with pytest.raises(CadetError, match=rf"has training\.steps = {STEPS}, and is to go on with {STEPS + 1}: change"):
        short_run(cycle, data, tmp_path, STEPS + 1, resume=True)


def test_other_settings_and_other_frames_are_refused_and_other_folders_said(
    config: Config, data: Path, unbroken: Path, tmp_path: Path
) -> None:
    out = copied(unbroken, tmp_path / "run")
    faster = dataclasses.replace(config, training=dataclasses.replace(config.training, learning_rate=0.5))
    with pytest.raises(
        CadetError, match=r"has training\.learning_rate = 0\.004, and is to go on with 0\.5: change noth"
    ):
        short_run(faster, data, out, STEPS + 1, resume=True)
    with pytest.raises(CadetError, match=f"{STEPS} steps are done, and training ends at {STEPS - 1}"):
        short_run(config, data, out, STEPS - 1, resume=True)
    assert short_run(config, data, out, STEPS, resume=True).name == f"{STEPS:09d}"
    assert_same_training(out, unbroken)
    moved = copied(data, tmp_path / "moved")
    with pytest.warns(CadetWarning, match=rf"data was '{data}' and is '{moved}': numbers may differ"):
        short_run(config, moved, out, STEPS + 1, resume=True)
    (moved / "ImageSets" / "train.txt").write_text("000000\n000002\n000001\n")
    with pytest.raises(CadetError, match=r"has a checksum of its frames' ids = \d+, and is to go on with \d+"):
        short_run(config, moved, out, STEPS + 2, resume=True)
    (moved / "ImageSets" / "train.txt").write_text("000000\n000001\n")
    with pytest.raises(CadetError, match="has frames to learn from = 3, and is to go on with 2"):
        short_run(config, moved, out, STEPS + 2, resume=True)
    with pytest.warns(CadetWarning, match="precision was None and is 'bfloat16'"):
        short_run(config, data, copied(unbroken, tmp_path / "b"), STEPS + 1, resume=True, precision=torch.bfloat16)


def test_going_on_from_elsewhere_says_what_is_another(
    config: Config, data: Path, unbroken: Path, tmp_path: Path
) -> None:
    faster = dataclasses.replace(config, training=dataclasses.replace(config.training, learning_rate=0.5))
    with pytest.warns(CadetWarning, match=r"was trained with training\.learning_rate = 0\.004, and .* with 0\.5"):
        short_run(faster, data, tmp_path / "a", STEPS + 1, resume_from=unbroken)
    with pytest.raises(CadetError, match="trained with seed 0, which --seed 8 cannot change: leave it out"):
        short_run(config, data, tmp_path / "b", STEPS + 1, resume_from=unbroken, seed=8)


def test_a_folder_from_before_records_goes_on(config: Config, data: Path, unbroken: Path, tmp_path: Path) -> None:
    out = copied(unbroken, tmp_path / "run")
    (out / "run.json").unlink()
    settings = out / "checkpoints" / "000000014" / "checkpoint.json"
    table = json.loads(settings.read_text())
    for name in ("data", "split", "pending"):
        table.pop(name)
    settings.write_text(json.dumps(table))
    with pytest.raises(CadetError, match="train needs --data: only a training that goes on by --resume knows its own"):
        call("train", "--out", out, "--resume", "--steps", 15)
    assert call("train", "--out", out, "--resume", "--steps", 15, "--data", data).return_value == 0
    assert [row["step"] for row in read_log(out / "log.csv")] == [10, 14, 15]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "other"}, r"run\.json: not a record of an avod training"),
        ({"version": 7}, r"run\.json: version 7, expected 1"),
        ({"seed": "one"}, r"run\.json: seed: expected a whole number, got 'one'"),
        ({"seed": -1}, r"run\.json: Record\.seed: expected "),
        ({"skipped_steps": [1.5]}, r"run\.json: skipped_steps\[0\]: expected a whole number, got 1\.5"),
        ({"data": ["one", 2]}, r"run\.json: data\[1\]: expected a string, got 2"),
        ({"data": 3}, r"run\.json: data: expected a string, got 3"),
        ({"other": 3}, r"run\.json: other: unknown key"),
    ],
)
def test_damaged_records_are_refused(
    config: Config, data: Path, unbroken: Path, tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    out = copied(unbroken, tmp_path / "run")
    (out / "run.json").write_text(json.dumps(json.loads((out / "run.json").read_text()) | change))
    with pytest.raises(CadetError, match=message):
        short_run(config, data, out, STEPS + 1, resume=True)
