"""`cadet-gen --engine ray`: a Ray of two processors on this machine, whose workers get killed."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from cadet import Camera, Lidar, ResetPolicy, Rig, _cadet
from cadet.errors import CadetError
from cadet.generate import Settings, generate
from cadet.generate.engines.engine import Failed
from cadet.generate.engines.ray_engine import run_episode

PYTHON = Path(__file__).parents[3] / "python"

# Ray's tasks name their processes; those of other Rays on this machine have other ancestors.
RUN = """
import json, os, pickle, signal, sys
from pathlib import Path
from cadet.generate import generate

def stat(pid):
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()

def is_ours(pid):
    while pid > 1:
        if pid == os.getpid():
            return True
        pid = int(stat(pid)[1])
    return False

def kill_workers():
    killed = 0
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            is_task = (entry / "cmdline").read_bytes().startswith(b"ray::cadet episode")
            if is_task and is_ours(int(entry.name)):
                os.kill(int(entry.name), signal.SIGKILL)
                killed += 1
        except (FileNotFoundError, ProcessLookupError):
            continue
    return killed

frames, killed, warnings = [], [], []

def on_frame(is_new):
    frames.append(is_new)
    if not killed or killed[0] == 0:
        killed[:] = [kill_workers()]

out, settings = sys.argv[1], pickle.loads(Path(sys.argv[2]).read_bytes())
generate(out, settings, workers=2, engine="ray", address="local", on_frame=on_frame, on_warning=warnings.append)
print(json.dumps({"frames": len(frames), "killed": killed[0], "warnings": warnings}))
"""


@pytest.fixture(scope="module")
def settings() -> Settings:
    """Six short episodes of a small rig."""
    rig = Rig(camera=Camera.kitti().resized(64, 32), lidar=Lidar.vlp16())
    policy = replace(ResetPolicy.kitti(), samples_per_episode=4)
    return Settings(seed=5, num_frames=23, policy=policy.with_rig(rig))


def tree(root: Path) -> dict[str, str]:
    files = (path for path in root.rglob("*") if path.is_file())
    return {str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.timeout(300)
def test_after_workers_were_killed_the_bytes_are_those_of_a_local_run(settings: Settings, tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed (pip install 'cadet-sim[cluster]')")
    generate(tmp_path / "local", settings, workers=1)
    (tmp_path / "settings").write_bytes(pickle.dumps(settings))
    done = subprocess.run(
        [sys.executable, "-c", RUN, str(tmp_path / "ray"), str(tmp_path / "settings")],
        env={**os.environ, "PYTHONPATH": str(PYTHON)},
        capture_output=True,
        text=True,
        timeout=280,
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    assert told["killed"] >= 1
    assert len(told["warnings"]) == told["killed"]
    assert all("a worker died in episode " in line for line in told["warnings"])
    # Frames that a dead worker wrote count once, when its episode was made again.
    assert told["frames"] == settings.num_frames
    assert tree(tmp_path / "ray") == tree(tmp_path / "local")


def test_a_node_that_does_not_see_the_folder_says_so(settings: Settings, tmp_path: Path) -> None:
    ended = run_episode(str(tmp_path), settings, _cadet.__version__, 0)
    assert isinstance(ended, Failed)
    assert ended.is_users
    node = os.uname().nodename
    assert ended.message == (
        f"the node {node} has no run.json in {tmp_path}: name a folder that all nodes share, or a URL"
    )
    assert list(tmp_path.iterdir()) == []


def test_a_node_with_another_version_says_so(settings: Settings, tmp_path: Path) -> None:
    ended = run_episode(str(tmp_path), settings, "0.0.0", 0)
    assert isinstance(ended, Failed)
    assert f"has cadet {_cadet.__version__}, expected 0.0.0, which the run was started with" in ended.message


def test_without_ray_the_message_says_what_to_install(
    settings: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(CadetError, match=r"^--engine ray needs ray: pip install 'cadet-sim\[cluster\]'$"):
        generate(tmp_path / "out", settings, engine="ray")
    assert not (tmp_path / "out").exists()


def test_a_cluster_that_does_not_answer_costs_one_line_and_no_folder(settings: Settings, tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed (pip install 'cadet-sim[cluster]')")
    with socket.socket() as taken:
        # Bound but not listening: no other program can answer there.
        taken.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(CadetError, match=f"^no Ray at '{address}': .*refused"):
            generate(tmp_path / "out", settings, engine="ray", address=address)
    assert not (tmp_path / "out").exists()
