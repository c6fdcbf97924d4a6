"""What runs below a process, as Linux tells it."""

from __future__ import annotations

import contextlib
from pathlib import Path


def workers_of(pid: int) -> list[int]:
    """Return the processes that a process has spawned to make frames; none once it has ended."""
    workers: list[int] = []
    with contextlib.suppress(OSError):
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            with contextlib.suppress(OSError):
                if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                    workers.append(int(child))
    return workers
