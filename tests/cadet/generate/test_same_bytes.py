"""`cadet-gen` on the compiled core writes the same bytes for any number of workers and after any kill."""

from __future__ import annotations

import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

NUM_FRAMES = 50  # two whole episodes and half of a third


def start(*arguments: object) -> subprocess.Popen[str]:
    """Start `cadet-gen` as a group of processes of its own, so that its workers can be killed with it."""
    code = "from cadet.cli import run_cadet_gen\nif __name__ == '__main__':\n    run_cadet_gen()"
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3] / "python")},
        text=True,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def write(out: Path, workers: int, *arguments: object) -> subprocess.Popen[str]:
    size = ("--image-size", "310x94", "--write", "depth,instance,semantic")
    return start(out, "-n", NUM_FRAMES, "--seed", 5, "--workers", workers, *size, *arguments)


def finish(process: subprocess.Popen[str]) -> None:
    with process:
        _, stderr = process.communicate(timeout=280)
    assert process.returncode == 0, stderr


def tree(root: Path) -> dict[str, str]:
    files = (path for path in root.rglob("*") if path.is_file())
    return {str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The files of three episodes that one worker wrote in one go."""
    out = tmp_path_factory.mktemp("whole") / "out"
    finish(write(out, 1))
    files = tree(out)
    # Nine files a frame, four lists, manifest, recipe, description, and the run's settings.
    assert len(files) == 9 * NUM_FRAMES + 8
    assert len({digest for name, digest in files.items() if "velodyne" in name}) == NUM_FRAMES
    return files


@pytest.mark.timeout(600)
def test_two_workers_write_the_same_bytes(whole: dict[str, str], tmp_path: Path) -> None:
    finish(write(tmp_path / "out", 2))
    assert tree(tmp_path / "out") == whole


@pytest.mark.timeout(600)
@pytest.mark.parametrize("kill_at", ["000007", "000041"])
def test_after_kill_9_resuming_gives_the_same_bytes(whole: dict[str, str], tmp_path: Path, kill_at: str) -> None:
    """In the first two episodes, which two workers make at the same time, and in the third."""
    out = tmp_path / "out"
    with write(out, 2) as process:
        frame = out / "training" / "velodyne" / f"{kill_at}.bin"
        while not frame.exists() and process.poll() is None:
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate(timeout=60)
    assert frame.exists()
    assert not (out / "manifest.json").exists(), "the run had ended before it was killed"
    assert len(tree(out)) < len(whole)
    finish(write(out, 2, "--resume"))
    assert tree(out) == whole
