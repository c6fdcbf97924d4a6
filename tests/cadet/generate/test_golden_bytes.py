"""The same seed gives the same bytes, whatever the processor: a change here is a change of every dataset.

`make golden` renews what is held (python/cadet/generate/golden_frames.json).
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import cadet
import golden_frames
from cadet.generate.golden_frames import CASES, digest, stored


def test_every_policy_and_rig_of_the_package_has_a_golden_frame() -> None:
    assert {case.policy for case in CASES.values()} == set(cadet.ResetPolicy._presets())
    assert {case.rig for case in CASES.values()} == set(cadet.Rig._presets())
    assert any("rain" in (case.weather or "") for case in CASES.values())
    assert set(stored()) == set(CASES)
    assert len(set(stored().values())) == len(CASES)


@pytest.mark.parametrize("name", CASES)
def test_golden_bytes(name: str) -> None:
    assert digest(CASES[name].capture()) == stored()[name]


def test_nothing_of_an_earlier_frame_shows() -> None:
    """Buffers are used again."""
    for seed, weather in [(0, "clear_noon"), (3, "clear_sunset"), (1, "soft_rain_noon"), (2, "clear_noon")]:
        cadet.Scene.random(seed=seed, weather=weather).capture()
        assert digest(CASES["kitti"].capture()) == stored()["kitti"], f"after a frame of seed {seed}"


@pytest.mark.timeout(600)
@pytest.mark.parametrize("processor", ["SandyBridge", "max"])
def test_processors_without_wide_registers_give_the_same_bytes(processor: str) -> None:
    """The kernels are compiled for AVX2 and AVX-512 too; SandyBridge has neither, qemu's largest has AVX2."""
    emulator = shutil.which("qemu-x86_64")
    if emulator is None:
        pytest.skip("qemu-x86_64, which emulates other processors, is not installed (Debian: qemu-user)")
    here = Path(golden_frames.__file__).parent
    environment = os.environ | {
        "PYTHONPATH": f"{here.parents[1] / 'python'}{os.pathsep}{here}",
        # NumPy's own linear algebra takes more of a processor for granted than it finds.
        "OPENBLAS_CORETYPE": "Prescott",
    }
    done = subprocess.run(
        [emulator, "-cpu", processor, sys.executable, golden_frames.__file__],
        env=environment,
        text=True,
        capture_output=True,
        timeout=590,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert json.loads(done.stdout) == stored()
