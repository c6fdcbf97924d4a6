"""`python -m tools.experiments` from the shell, in small."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from cadet.errors import CadetError
from detector.experiments import micro_scale, micro_sets
from tools.experiments import scales
from tools.experiments.command import experiments

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("paper")
    micro_sets(folder)
    return folder


@pytest.fixture(autouse=True)
def _micro(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(scales.SCALES, "tiny", micro_scale(folder))


def call(*arguments: object, code: int = 0) -> Result:
    command = [*map(str, arguments), "--workers", "0"]
    result = CliRunner().invoke(experiments, command, standalone_mode=False)
    if code == 0 and result.exception is not None:
        raise result.exception
    assert (result.return_value or 0) == code
    return result


def arguments(folder: Path, out: Path) -> tuple[object, ...]:
    where = ("--data-real", folder / "real", "--data-sim", folder / "sim", "-o", out)
    return (*where, "--classes", "Car", "--maps", "default")


def test_a_dry_run_lists_and_estimates_and_writes_nothing(folder: Path, tmp_path: Path) -> None:
    text = call(*arguments(folder, tmp_path / "out"), "--dry-run").stdout
    lines = [re.split(r"  +", line) for line in text.splitlines()]
    assert [line[:3] for line in lines[:4]] == [
        ["cell", "steps", "tested on"],
        ["car-default-sim-seed0", "4", "sim, real"],
        ["car-default-real-seed0", "4", "real"],
        ["car-default-tuned-seed0", "2", "real, sim"],
    ]
    assert re.search(r"^Car: \d+\.\d{3} s a step, \d+\.\d{3} s a frame in detection, timed on cpu$", text, re.M)
    assert re.search(r"^3 of 3 cells to run; devices that share them by --cells: \S+ (h|min) on 1, ", text, re.M)
    assert not (tmp_path / "out").exists()


@pytest.mark.timeout(240)  # trains seven times
def test_cells_are_run_one_by_one_and_the_table_grows(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    first = call(*arguments(folder, out), "--cells", "*-sim-*")
    assert "car-default-sim-seed0: done" in first.stderr
    table = (out / "table.md").read_text()
    assert table == first.stdout and "| simulated " in table and "| real " not in table
    again = call(*arguments(folder, out))
    assert again.stdout == (out / "table.md").read_text()
    assert all(f"| {name} " in again.stdout for name in ("simulated", "real", "simulated, then real"))
    results = json.loads((out / "results.json").read_text())
    assert results["scale"] == "micro" and results["sets"]["real"]["num_train"] == 4
    assert len(results["rows"]) == 5 and (out / "matrix.png").is_file()
    text = call(*arguments(folder, out), "--dry-run").stdout
    assert text.count("finished") == 3 and "0 of 3 cells to run" in text
    # A number of frames, with weights that are given.
    init = out / "cells" / "car-default-sim-seed0" / "best"
    few = call(
        *(
            "--data-real",
            folder / "real",
            "-o",
            out,
            "--classes",
            "Car",
            "--frames",
            "3,1",
            "--init",
            init,
            "--seeds",
            2,
        )
    )
    rows = [line.split("|")[3].strip() for line in few.stdout.splitlines() if line.startswith("| Car ")]
    # Simulated frames and given weights alone, then from scratch and tuned with each number.
    assert rows == ["0", "0", "1", "1", "3", "3"]


def test_what_cannot_be_run_is_one_clear_line(folder: Path, tmp_path: Path) -> None:
    real = ("--data-real", folder / "real", "-o", tmp_path)
    few = ("--frames", "10,40")
    for given, message in (
        (real, "--data-sim: needed to train on"),
        ((*real, "--init", "tiny_car"), "--init: pre-trained weights are for --frames"),
        ((*real, *few, "--init", "tiny_car"), "--init: these weights are of one class"),
        ((*arguments(folder, tmp_path), "--frames", "10,x"), "--frames: expected numbers of frames such as"),
        ((*arguments(folder, tmp_path), "--frames", "0"), "--frames: expected numbers of frames such as"),
        ((*arguments(folder, tmp_path), "--classes", "Van"), "--classes: expected some of Car,Pedestrian, got 'Van'"),
        ((*arguments(folder, tmp_path), "--scale", "center"), "--scale center: its detector is none of the paper's"),
        ((*arguments(folder, tmp_path), "--maps", "max"), "--maps: expected some of default,max3_density3,max_min"),
        ((*arguments(folder, tmp_path), "--data-sim", tmp_path / "no"), "no: no such folder"),
        ((*arguments(folder, tmp_path), "--cells", "ped*"), "--cells ped*: names none of"),
    ):
        result = CliRunner().invoke(experiments, [*map(str, given)], standalone_mode=False)
        assert isinstance(result.exception, CadetError) and message in str(result.exception), given
    assert list(tmp_path.iterdir()) == []


def test_a_stop_says_how_to_go_on(folder: Path, tmp_path: Path) -> None:
    result = call(*arguments(folder, tmp_path / "out"), "--max-minutes", "1e-9", code=75)
    assert result.stderr.splitlines()[-1] == "the time is up; the same command continues"


@pytest.mark.timeout(240)  # starts PyTorch twice
def test_two_processes_share_a_cell(folder: Path, tmp_path: Path) -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    paths = os.pathsep.join(map(str, (ROOT, ROOT / "python", ROOT / "tests" / "support")))
    environment = {**os.environ, "PYTHONPATH": paths, "WORLD_SIZE": "2", "OMP_NUM_THREADS": "1"}
    environment |= {"MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(port)}
    code = (
        "import sys; from pathlib import Path\n"
        "from tools.experiments import scales; from detector.experiments import micro_scale\n"
        "scales.SCALES['tiny'] = micro_scale(Path(sys.argv.pop(1)))\n"
        "import tools.experiments.__main__"
    )
    processes = []
    for rank in range(2):
        (tmp_path / f"config{rank}").mkdir()
        command = [
            sys.executable,
            "-c",
            code,
            tmp_path / f"config{rank}",
            *arguments(folder, tmp_path / "out"),
        ]
        command += ["--cells", "*-sim-*", "--workers", "0", "--threads", "1"]
        one = {**environment, "RANK": str(rank), "LOCAL_RANK": str(rank)}
        processes.append(
            subprocess.Popen(
                list(map(str, command)), env=one, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
        )
    outputs = [process.communicate(timeout=200) for process in processes]
    assert [process.returncode for process in processes] == [0, 0], outputs
    assert outputs[1][0] == "" and "| simulated " in outputs[0][0]
    cell = tmp_path / "out" / "cells" / "car-default-sim-seed0"
    assert json.loads((cell / "run" / "run.json").read_text())["num_processes"] == 2
    assert len(list((cell / "detections_sim").iterdir())) == 2
