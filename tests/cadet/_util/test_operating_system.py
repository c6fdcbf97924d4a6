"""What the system tells of its memory."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cadet._util.operating_system import free_memory_gb


def write(root: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


def test_free_memory_is_the_machines_or_what_a_container_may_still_take(tmp_path: Path) -> None:
    machine = {"proc/meminfo": "MemTotal: 16000000 kB\nMemAvailable:    5000000 kB\n"}
    assert free_memory_gb(write(tmp_path, machine)) == 5.12
    unlimited = {"sys/fs/cgroup/memory.max": "max\n", "sys/fs/cgroup/memory.current": "900\n"}
    assert free_memory_gb(write(tmp_path, unlimited)) == 5.12
    limited = {"sys/fs/cgroup/memory.max": "4000000000\n", "sys/fs/cgroup/memory.current": "1000000000\n"}
    assert free_memory_gb(write(tmp_path, limited)) == 3.0


def test_where_nobody_tells_nothing_is_assumed(tmp_path: Path) -> None:
    assert free_memory_gb(tmp_path) is None
    assert free_memory_gb(write(tmp_path, {"proc/meminfo": "odd"})) is None


@pytest.mark.skipif(sys.platform != "linux", reason="Linux tells")
def test_this_machine_has_some() -> None:
    free_gb = free_memory_gb()
    assert free_gb is not None and 0.01 < free_gb < 1e5
