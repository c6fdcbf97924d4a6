"""Training by several processes on the CPU: as one process would, and each on its own device."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from avod.detector import Detector
from avod.device import Processes, name_of_process
from avod.train.log import read_log, read_validations
from avod.validate import Validator
from cadet.errors import CadetError
from detector.processes import STEPS, steps_of, without_draws
from detector.runs import Frozen, assert_same_training, small_config, write_set

ROOT = Path(__file__).parents[3]
SUPPORT = ROOT / "tests" / "support"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder in which two processes have trained."""
    folder = tmp_path_factory.mktemp("processes")
    write_set(folder / "set", num_train=4, num_val=3)
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    common = {"WORLD_SIZE": "2", "MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(port), "OMP_NUM_THREADS": "1"}
    common["PYTHONPATH"] = os.pathsep.join([str(ROOT / "python"), str(SUPPORT)])
    processes = []
    for rank in range(2):
        (folder / f"config{rank}").mkdir()
        environment = {**os.environ, **common, "RANK": str(rank), "LOCAL_RANK": str(rank)}
        command = [sys.executable, str(SUPPORT / "detector" / "processes.py"), str(folder), str(rank)]
        processes.append(subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True))
    for process in processes:
        message = process.communicate(timeout=200)[1]
        assert process.returncode == 0, message
    return folder


@pytest.mark.timeout(300)  # starts PyTorch twice
def test_two_processes_with_a_frame_each_train_as_one_with_two_frames(folder: Path) -> None:
    config = small_config(folder)
    alone = steps_of(config, folder / "set", Processes(), 2)
    first, second = (load_file(folder / f"rank{rank}") for rank in range(2))
    start = steps_of_nothing(folder)
    assert set(first) == set(second) == set(alone)
    for name, value in alone.items():
        assert torch.equal(first[name], second[name]), name
        torch.testing.assert_close(first[name], value, atol=2e-4, rtol=1e-3)
    moved = torch.stack([(alone[name] - value).abs().max() for name, value in start.items()])
    assert moved.max() > 0.005, "three steps that can be told from none"


def steps_of_nothing(folder: Path) -> dict[str, torch.Tensor]:
    torch.manual_seed(0)
    return dict(Frozen(without_draws(small_config(folder))).state_dict())


def test_two_processes_stop_together_and_go_on_as_if_they_had_not(folder: Path) -> None:
    assert_same_training(folder / "parts", folder / "unbroken")
    assert (folder / "parts" / "val.csv").read_bytes() == (folder / "unbroken" / "val.csv").read_bytes()
    assert json.loads((folder / "parts" / "run.json").read_text())["num_processes"] == 2
    assert [row["step"] for row in read_log(folder / "unbroken" / "log.csv")] == [STEPS]


def test_processes_share_the_frames_of_a_validation_out(folder: Path) -> None:
    config = small_config(folder)
    network = Detector(folder / "unbroken").network
    found = Validator(folder / "set", "val", config)(network, STEPS, Processes())
    assert found is not None
    row = read_validations(folder / "unbroken" / "val.csv")[-1]
    assert row["ap"] == pytest.approx(found.ap, abs=1e-3)
    for name, value in found.losses.items():
        assert row[name] == pytest.approx(value, rel=1e-5), name


def test_each_process_takes_its_own_device(monkeypatch: pytest.MonkeyPatch) -> None:
    assert [name_of_process(name) for name in ("cpu", "cuda", "cuda:1")] == ["cpu", "cuda", "cuda:1"]
    monkeypatch.setenv("WORLD_SIZE", "4")
    monkeypatch.setenv("LOCAL_RANK", "2")
    assert [name_of_process(name) for name in ("cpu", "cuda", "xpu")] == ["cpu", "cuda:2", "xpu:2"]
    with pytest.raises(
        CadetError, match=r"^device: 'cuda:1' is one device, for 4 processes: name the kind alone, cuda$"
    ):
        name_of_process("cuda:1")
    with (
        pytest.raises(CadetError, match="'mps' cannot be shared by 4 processes"),
        Processes.joined(torch.device("mps")),
    ):
        pass
