"""The same seed gives the same bytes, whatever the processor: a change here is a change of every dataset."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cadet

GOLDEN = "2587ecf074747004f85e29b9bfea3ef020e360d1a575830f024bc9f21e1808b4"


def digest_of_a_frame() -> str:
    frame = cadet.Scene.random(seed=0, weather="clear_noon").capture()
    digest = hashlib.sha256()
    for part in (frame.image, frame.points_velo, frame.instance, frame.plane):
        assert part is not None
        digest.update(np.ascontiguousarray(part).tobytes())
    digest.update("\n".join(label.to_line() for label in frame.labels).encode())
    return digest.hexdigest()


def test_golden_bytes_whatever_was_captured_before() -> None:
    """Buffers are used again: nothing of an earlier frame may show."""
    for seed, weather in [(0, "clear_noon"), (3, "clear_sunset"), (1, "soft_rain_noon"), (2, "clear_noon")]:
        cadet.Scene.random(seed=seed, weather=weather).capture()
        assert digest_of_a_frame() == GOLDEN, f"after a frame of seed {seed}"


@pytest.mark.parametrize("processor", ["SandyBridge", "max"])
def test_processors_without_wide_registers_give_the_same_bytes(processor: str) -> None:
    """The kernels are compiled for AVX2 and AVX-512 too; SandyBridge has neither, qemu's largest has AVX2."""
    emulator = shutil.which("qemu-x86_64")
    if emulator is None:
        pytest.skip("qemu-x86_64, which emulates other processors, is not installed (Debian: qemu-user)")
    root = Path(__file__).parents[2]
    environment = os.environ | {
        "PYTHONPATH": f"{root / 'python'}:{Path(__file__).parent}",
        # NumPy's own linear algebra takes more of a processor for granted than it finds.
        "OPENBLAS_CORETYPE": "Prescott",
    }
    done = subprocess.run(
        [emulator, "-cpu", processor, sys.executable, __file__],
        env=environment,
        text=True,
        capture_output=True,
        timeout=400,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.split() == [GOLDEN]


if __name__ == "__main__":
    sys.stdout.write(digest_of_a_frame())
