"""What the commands set for their process."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

_CODE = """
import sys
import numpy as np
from avod.cli.process import set_up_process

if sys.argv[1] == "kept":
    set_up_process()
def resident_mb():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096 / 2**20
values = np.ones(64 << 17)
del values
print(resident_mb())
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other allocators have no such setting")
def test_memory_of_large_arrays_is_kept_for_the_next() -> None:
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3] / "python")}
    usual, kept = (
        float(subprocess.check_output([sys.executable, "-c", _CODE, name], env=environment, timeout=100))
        for name in ("usual", "kept")
    )
    assert kept > usual + 48.0
