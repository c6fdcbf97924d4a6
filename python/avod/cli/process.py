"""What the commands set for their whole process, before PyTorch is imported; `import avod` sets none of it."""

from __future__ import annotations

import ctypes
import os
import sys
from typing import Final

_M_TRIM_THRESHOLD: Final = -1
_M_MMAP_MAX: Final = -4


def set_up_process() -> None:
    """Let threads that wait sleep, and keep memory that is freed for what comes next."""
    # Read when OpenMP is loaded, with torch: threads that wait for others must not take processor time.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt is not None:
        # By default glibc returns every large tensor to the system, which fills the next one's pages with zeros again.
        mallopt(_M_MMAP_MAX, 0)
        mallopt(_M_TRIM_THRESHOLD, -1)
