"""`benches/gpu/run.sh` with commands that only note how they are called, and its weights in parts.

`make bench-gpu` runs it with the true commands.
"""

from __future__ import annotations

import os
import runpy
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from click import Command

from avod.cli.commands import avod
from avod.config import Config
from avod.model.avod.network import AvodNetwork
from avod.train.checkpoint import load_network, read_checkpoint, save_checkpoint
from cadet.cli.gen import cadet_gen
from cadet.cli.tools import cadet
from detector.runs import small_config

FOLDER = Path(__file__).parents[2] / "benches" / "gpu"
COMMANDS: dict[str, Command] = {"cadet-gen": cadet_gen}
COMMANDS |= {f"avod {name}": command for name, command in avod.commands.items()}
COMMANDS |= {f"cadet {name}": command for name, command in cadet.commands.items()}
# The third row is what the trial's time is read from, and the median is that of three.
FAKE = """#!/usr/bin/env bash
command="${0##*/}"
echo "$command ${*//$'\\n'/ }" >> "$CALLS"
case "$command $1" in
cadet-gen*)
    mkdir -p "$1/training/velodyne"
    touch "$1/run.json" "$1/training/velodyne/000000.bin" "$1/training/velodyne/000001.bin"
    exec sleep "${GEN_TAKES:-0}" ;;
"avod train")
    while [ "$1" != --out ]; do shift; done
    mkdir -p "$2/checkpoints/000000030"
    touch "$2/run.json"
    printf 'step,seconds_per_step\\n10,9.0\\n20,0.25\\n30,0.5\\n' > "$2/log.csv"
    exit "${TRAIN_ENDS:-0}" ;;
"avod bench") echo "inference 31.4" ;;
"cadet eval") echo "| Car | 3D |" ;;
esac
"""

Script = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def script(tmp_path: Path) -> Script:
    for name in ("avod", "cadet", "cadet-gen", "python3"):
        file = tmp_path / "bin" / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(FAKE)
        file.chmod(0o755)

    def run(**settings: object) -> subprocess.CompletedProcess[str]:
        (tmp_path / "calls").write_text("")
        env = {"PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}", "CALLS": str(tmp_path / "calls")}
        env |= {"OUT": str(tmp_path / "out"), "WORK": str(tmp_path / "work"), "REAL": str(tmp_path / "kitti")}
        env |= {name: str(value) for name, value in settings.items()}
        return subprocess.run([FOLDER / "run.sh"], env=env, capture_output=True, text=True, timeout=60)

    return run


def calls(tmp_path: Path) -> list[str]:
    """Name the commands that were called, with what they were told to do."""
    lines = [line.split() for line in (tmp_path / "calls").read_text().splitlines()]
    return [words[0] if words[0] in ("cadet-gen", "python3") else " ".join(words[:2]) for words in lines]


def test_everything_runs_once_and_is_reported(script: Script, tmp_path: Path) -> None:
    assert script(MINUTES=1).returncode == 0
    judged = ["avod predict", "cadet eval", "cadet eval"]
    assert calls(tmp_path) == [
        *("cadet --version", "python3", "cadet-gen", "cadet-gen", "avod train", "avod train", "python3", "python3"),
        *judged,
        *judged,
        *("avod bench", "avod bench"),
    ]
    report = (tmp_path / "out" / "report.md").read_text()
    assert "- set: 2 frames in " in report
    assert "- training: 30 steps in " in report
    assert "500 ms a step (median)" in report
    assert report.count("| Car | 3D |") == 4
    assert report.count("inference 31.4") == 2
    assert (tmp_path / "out" / "log.csv").is_file()
    assert script(MINUTES=1).returncode == 0
    assert calls(tmp_path) == []


def test_the_trial_says_how_many_steps_fit(script: Script, tmp_path: Path) -> None:
    assert script(MINUTES=1, BATCH=3, RATE=2e-4).returncode == 0
    config = Config.named(tmp_path / "work" / "run.toml")
    # Nine tenths of a minute by half a second each, the trial's last row.
    assert config.training.steps == 109
    assert config.training.frames_per_step == 3
    assert config.training.learning_rate == 2e-4
    assert config.second_stage.truth_steps == 54
    paper = Config.named("car_default")
    for part in ("classes", "bev", "image", "anchors", "path_drop", "rpn", "detection"):
        assert getattr(config, part) == getattr(paper, part)


@pytest.mark.parametrize(("code", "is_enough"), [(0, True), (75, True), (1, False), (2, False), (139, False)])
def test_training_may_run_out_of_time_but_not_fail(script: Script, tmp_path: Path, code: int, is_enough: bool) -> None:
    assert (script(STEPS=30, TRAIN_ENDS=code).returncode == 0) == is_enough
    assert ("avod predict" in calls(tmp_path)) == is_enough


def test_a_training_that_failed_goes_on(script: Script, tmp_path: Path) -> None:
    script(STEPS=30, TRAIN_ENDS=1)
    assert "--resume" not in (tmp_path / "calls").read_text()
    assert script(STEPS=30).returncode == 0
    assert calls(tmp_path)[0] == "avod train"
    assert "--resume" in (tmp_path / "calls").read_text().splitlines()[0].split()


def test_frames_may_run_out_of_time(script: Script, tmp_path: Path) -> None:
    assert script(STEPS=30, GEN_TAKES=30, GEN_SECONDS=0.3).returncode == 0
    assert "- set: 2 frames in 0." in (tmp_path / "out" / "report.md").read_text()


def test_its_options_are_those_of_the_commands(script: Script, tmp_path: Path) -> None:
    script(STEPS=30, TRAIN_ENDS=1)
    told = (tmp_path / "calls").read_text()
    script(STEPS=30)
    told += (tmp_path / "calls").read_text()
    known = [line.split() for line in told.splitlines() if not line.startswith(("python3", "cadet --version"))]
    assert len(known) == 12
    for words in known:
        name = words[0] if words[0] == "cadet-gen" else " ".join(words[:2])
        options = {option for parameter in COMMANDS[name].params for option in parameter.opts}
        assert {word for word in words if word.startswith("--")} <= options, name


def test_weights_come_back_from_their_parts(tmp_path: Path) -> None:
    config = small_config(tmp_path)
    network = AvodNetwork(config)
    saved = save_checkpoint(tmp_path / "run" / "checkpoints", network, None, config, step=7, seed=1)
    weights = runpy.run_path(str(FOLDER / "weights.py"))
    weights["split"].__globals__["PART_BYTES"] = 10_000
    weights["split"](tmp_path / "run", tmp_path / "parts")
    sizes = [part.stat().st_size for part in (tmp_path / "parts").glob("model.*")]
    assert len(sizes) > 10
    assert max(sizes) == 10_000
    assert sum(sizes) < 0.6 * (saved / "model.safetensors").stat().st_size
    weights["join"](tmp_path / "parts", tmp_path / "joined")
    joined = AvodNetwork(config)
    checkpoint = read_checkpoint(tmp_path / "joined")
    load_network(checkpoint, joined)
    assert (checkpoint.step, checkpoint.config) == (7, config)
    for name, value in network.state_dict().items():
        rounded = value.half().float() if value.dim() > 1 else value
        torch.testing.assert_close(joined.state_dict()[name], rounded, rtol=0, atol=0)
