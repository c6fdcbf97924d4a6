"""`cadet-gen` as a process of its own, on the quick worlds of `small_runs`."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

HERE = Path(__file__).parents[1]
SIZE = ("--image-size", "64x32")
# Exit codes: nothing went wrong, the user can mend it, Ctrl-C.
FINE, FAILED, INTERRUPTED = 0, 2, 130


def start(*arguments: object, fault: str = "", preexec: Callable[[], None] | None = None) -> subprocess.Popen[str]:
    environment = {
        **os.environ,
        "PYTHONPATH": f"{HERE.parent / 'python'}:{HERE / 'support'}",
        "CADET_FAULT": fault,
    }
    command = [sys.executable, "-c", "import small_runs; small_runs.main()", *map(str, arguments)]
    return subprocess.Popen(
        command,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=preexec,
    )


def run(
    *arguments: object, fault: str = "", preexec: Callable[[], None] | None = None
) -> subprocess.CompletedProcess[str]:
    with start(*arguments, fault=fault, preexec=preexec) as process:
        stdout, stderr = process.communicate(timeout=60)
    return subprocess.CompletedProcess(process.args, process.returncode, stdout, stderr)


def tree(root: Path) -> dict[str, str]:
    files = (path for path in root.rglob("*") if path.is_file())
    return {str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def flip(path: Path, at: int) -> None:
    """Flip the bits of one byte of a file."""
    data = bytearray(path.read_bytes())
    data[at] ^= 0xFF
    path.write_bytes(data)


def wait_for(path: Path, process: subprocess.Popen[str]) -> None:
    for _ in range(600):
        if path.exists() or process.poll() is not None:
            break
        time.sleep(0.02)
    assert path.exists(), "the run ended or hung before it wrote the frame"


def workers_of(process: subprocess.Popen[str]) -> list[int]:
    """Return the ids of the processes that make episodes: multiprocessing's resource tracker is none."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return [int(pid) for pid in children if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]


def write_whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a dataset of ten frames in three episodes, by one worker in one go."""
    out = tmp_path_factory.mktemp("whole") / "out"
    done = run(out, "-n", 10, "--seed", 3, *SIZE, "--workers", 1)
    assert (done.returncode, done.stdout) == (FINE, "")
    return out
