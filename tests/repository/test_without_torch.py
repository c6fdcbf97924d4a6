"""What `avod` says where PyTorch is not installed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

_WITHOUT = "import sys; sys.modules['torch'] = None; sys.modules['safetensors'] = None; sys.argv = ['avod', 'train'];"


def run(code: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(Path(__file__).parents[2] / "python"), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, "-c", f"{_WITHOUT} {code}"],
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, "PYTHONPATH": path},
    )


def test_the_command_is_one_clear_line() -> None:
    done = run("from avod.cli import run_avod; run_avod()")
    assert done.returncode == 2
    assert done.stderr == "avod needs torch and safetensors: pip install 'cadet-sim[avod]'\n"


def test_configurations_are_read_and_the_detector_says_what_it_needs() -> None:
    done = run("import avod; print(len(avod.load_config('car_default').classes)); avod.Detector")
    assert done.stdout == "1\n"
    assert done.stderr.splitlines()[-1] == (
        "ModuleNotFoundError: avod.Detector needs torch: pip install 'cadet-sim[avod]'"
    )
