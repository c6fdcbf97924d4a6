"""What a first training meets: used folders, empty lists, no terminal, odd names of pictures, versions."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from click.testing import CliRunner, Result

from avod.cli import options
from avod.cli.commands import avod
from avod.config import Config
from avod.figures import loss_figure
from avod.train import train
from avod.train.log import read_log
from avod.train.run import Run, with_steps
from cadet import __version__
from cadet._util import style
from cadet.cli import progress
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti import write_frame
from detector.logs import COLUMNS, TERMS
from synthetic import make_frame

CONFIG_FILE = Path(__file__).parents[2] / "support" / "detector" / "overfit.toml"
CONFIG = Config.named(CONFIG_FILE)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("kitti")
    for index in range(2):
        write_frame(root, index, make_frame(), split="train")
    return root


def call(*arguments: object) -> Result:
    return CliRunner().invoke(avod, [str(argument) for argument in arguments], catch_exceptions=False)


def run(dataset: Path, out: Path, steps: int, *, init: Path | None = None, resume_from: Path | None = None) -> Path:
    training = dataclasses.replace(CONFIG.training, checkpoint_steps=2)
    config = with_steps(dataclasses.replace(CONFIG, training=training), steps)
    return train(config, Run(data=dataset, out=out, split=None, init=init, resume_from=resume_from))


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_a_folder_that_holds_a_training_is_not_used_again(dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    first = run(dataset, out, 4)
    before = contents(out)
    used = (
        rf"^{out} holds another training: name a new folder with --out, or go on with this one by --out {out} --resume$"
    )
    with pytest.raises(CadetError, match=used):
        run(dataset, out, 4)
    with pytest.raises(CadetError, match=used):
        run(dataset, out, 6, init=first)
    other = run(dataset, tmp_path / "other", 2)
    with pytest.raises(CadetError, match=used):
        run(dataset, out, 6, resume_from=other)
    earlier = rf"^{out} holds checkpoints up to 000000004, and training is to go on from 000000002: go on from the last"
    first_of_two = out / "checkpoints" / "000000002"
    (first_of_two / "optimizer.safetensors").write_bytes((first / "optimizer.safetensors").read_bytes())
    with pytest.raises(CadetError, match=earlier):
        run(dataset, out, 6, resume_from=first_of_two)
    (first_of_two / "optimizer.safetensors").unlink()
    assert contents(out) == before
    assert run(dataset, out, 6, resume_from=out).name == "000000006"
    assert [row["step"] for row in read_log(out / "log.csv")] == [4, 6]
    assert run(dataset, tmp_path / "new", 7, resume_from=out / "checkpoints" / "000000006").name == "000000007"
    with pytest.raises(MissingFileError, match="of a training only the newest checkpoint can be resumed"):
        run(dataset, tmp_path / "newer", 5, resume_from=out / "checkpoints" / "000000004")


def test_a_log_alone_is_not_replaced_either(dataset: Path, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(",".join(COLUMNS) + "\n")
    # A training that ended before its first row has left nothing to lose.
    run(dataset, tmp_path, 1)
    (tmp_path / "checkpoints" / "000000001" / "checkpoint.json").unlink()
    with pytest.raises(CadetError, match=r"holds the log of another training: name a new folder with --out$"):
        run(dataset, tmp_path, 1)


def test_an_empty_list_says_what_to_do(dataset: Path) -> None:
    message = (
        f"{dataset}/ImageSets/val.txt names no frames; choose another list: train (2), trainval (2); "
        "cadet-gen writes validation frames from the 21st on: -n 40 gives 20"
    )
    with pytest.raises(MissingFileError) as error:
        call("eval", "--checkpoint", "tiny_car", "--data", dataset)
    assert str(error.value) == message
    with pytest.raises(MissingFileError, match="no test frames"):
        call("eval", "--checkpoint", "tiny_car", "--data", dataset, "--split", "test")
    assert "2 frames" in call("eval", "--checkpoint", "tiny_car", "--data", dataset, "--split", "train").output


def test_progress_without_a_terminal_is_a_line_now_and_then(
    dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "run"
    common = ["--data", dataset, "--checkpoint", out]
    common_training = ["train", "--config", CONFIG_FILE, "--data", dataset, "--out", out]
    assert "steps, " not in call(*common_training, "--steps", 2).output
    monkeypatch.setattr(progress, "_SECONDS_BETWEEN_LINES", 0.0)
    lines = call(*common_training, "--steps", 4, "--resume-from", out).output.splitlines()
    # What the first part did counts as done, and not for the rate.
    assert [line.split(",")[0] for line in lines[:3]] == ["2/4 steps", "3/4 steps", "4/4 steps"]
    assert lines[0].endswith(" 0.0/s, ? left")
    assert all("/s, 0:00:0" in line and " left, loss " in line for line in lines[1:3])
    predicted = call("predict", *common, "--out", tmp_path / "found").output
    assert [line.split(",")[0] for line in predicted.splitlines()[:2]] == ["1/2 frames", "2/2 frames"]
    evaluated = call("eval", *common, "--split", "train").output
    assert [line.split(",")[0] for line in evaluated.splitlines()[:2]] == ["1/2 frames", "2/2 frames"]


def test_every_command_has_one_task() -> None:
    assert Counter(name for names in avod.tasks.values() for name in names) == Counter(avod.commands.keys())
    assert "Detect:\n  predict" in call("--help").output


def test_threads_are_the_commands_alone(dataset: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    view = ["view", "--log", dataset, "-o", dataset / "a.png"]
    torch.set_num_threads(3)
    for chosen, expected in (([], min(3, options.DEFAULT_THREADS)), (["--threads", 1], 1), (["--threads", 2], 2)):
        with pytest.raises(MissingFileError):
            call(*view, *chosen)
        assert torch.get_num_threads() == expected
    assert "--threads" in call("train", "--help").output
    # Importing the detector changes nothing for its user.
    code = "import torch; n = torch.get_num_threads(); import avod.detector, os; "
    code += "assert torch.get_num_threads() == n and 'OMP_WAIT_POLICY' not in os.environ"
    environment = {name: value for name, value in os.environ.items() if not name.startswith("OMP")}
    environment["PYTHONPATH"] = str(Path(__file__).parents[3] / "python")
    subprocess.run([sys.executable, "-c", code], env=environment, check=True, timeout=100)


def rows(count: int) -> list[dict[str, float]]:
    return [
        {"step": 10.0 * (k + 1), "learning_rate": 1e-4, "seconds_per_step": 1.0}
        | {name: 0.1 * (index + 1) / (k + 1) for index, name in enumerate(TERMS)}
        for k in range(count)
    ]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_curves_of_short_runs_are_seen(count: int) -> None:
    image = loss_figure(rows(count))
    plot = image[:, 60 : 960 - 150].astype(int)
    is_total = (abs(plot - np.array(style.TEXT)).max(axis=2) < 12).sum(axis=0)
    # A mark for each row, evenly spaced from left to right.
    columns = np.linspace(60, 960 - 150, count) - 60 if count > 1 else np.array([0.0])
    for column in columns:
        near = slice(max(round(column) - 3, 0), round(column) + 4)
        assert is_total[near].sum() >= 12


def test_pictures_are_of_the_kind_that_their_name_says(dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    run(dataset, out, 1)
    shown = call("view", "--log", out, "-o", tmp_path / "a.jpg")
    assert shown.output == f"wrote {tmp_path / 'a.jpg'}\n"
    assert (tmp_path / "a.jpg").read_bytes()[:3] == b"\xff\xd8\xff"
    frame = ["view", "--checkpoint", "tiny_car", "--data", dataset, "--frame-id", "000000"]
    assert call(*frame, "-o", tmp_path / "b.png").output == f"wrote {tmp_path / 'b.png'}\n"
    assert cv2.imread(str(tmp_path / "b.png")) is not None
    evaluate = ["eval", "--checkpoint", "nothing", "--data", tmp_path / "nowhere"]
    # Refused before anything is read.
    for command in ([*frame[:2], "nothing", *frame[3:], "-o"], [*evaluate, "--plot"]):
        with pytest.raises(MissingFileError, match=r"^/nodir/x\.png: no such folder: /nodir$"):
            call(*command, "/nodir/x.png")
        with pytest.raises(CadetError, match=r"x\.gif: expected a name that ends in \.png, \.jpg, \.jpeg$"):
            call(*command, tmp_path / "x.gif")


def test_the_version_is_said() -> None:
    assert call("--version").output == f"avod, version {__version__}\n"
