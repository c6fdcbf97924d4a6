"""Workers start from whatever the caller runs, with no `if __name__ == "__main__"`, and run nothing of it again."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import math, sys
from dataclasses import replace
import cadet
from cadet.generate import Settings, generate
from cadet._util.process_map import process_map

print("began")
rig = cadet.Rig(camera=cadet.Camera.kitti().resized(124, 38), lidar=cadet.Lidar.vlp16())
policy = replace(cadet.ResetPolicy.kitti().with_rig(rig), samples_per_episode=2)
print(generate("drives", Settings(num_frames=4, policy=policy), workers=2).num_new)
with cadet.stream(policy, workers=2, config=cadet.SceneConfig(num_cars=9)) as frames:
    print([next(frames).meta["episode"] for _ in range(3)])
print(sum(process_map(math.sqrt, [4.0] * 40, workers=2)))

class Mine(cadet.ResetPolicy):
    pass

try:
    generate("mine", Settings(num_frames=4, policy=Mine(**vars(policy))), workers=2)
except cadet.CadetError as error:
    print(error)
"""
WAYS = {
    "script": ["script.py"],
    "stdin": ["-"],
    "command": ["-c", SCRIPT],
    "module": ["-m", "script"],
    "notebook": ["-c", "import code; code.InteractiveInterpreter().runsource(open('script.py').read(), symbol='exec')"],
}


@pytest.mark.parametrize("way", WAYS)
def test_workers_start_from_anywhere(way: str, tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, *WAYS[way]],
        input=SCRIPT,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        cwd=tmp_path,
    )
    assert (done.returncode, done.stderr) == (0, "")
    *lines, refused = done.stdout.splitlines()
    assert lines == ["began", "4", "[0, 0, 1]", "80.0"]
    assert refused.startswith("workers do not import the script that was started: define what they need in a module (")
