"""The commands of `avod`."""

from __future__ import annotations

import importlib.util
import os
import sys

_NEEDED = ("torch", "safetensors", "click", "rich")


def run_avod() -> None:
    """Run `avod`."""
    missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        sys.stderr.write(f"avod needs {' and '.join(missing)}: pip install 'cadet-sim[avod]'\n")
        sys.exit(2)
    # Read when OpenMP is loaded, with torch: threads that wait for others must not take processor time.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    try:
        from avod.cli.commands import avod
        from cadet.cli.errors import run
    except ImportError as error:
        # The loader of shared libraries says no more where the memory doesn't suffice to map PyTorch's.
        reason = " ".join(str(error).split())
        sys.stderr.write(f"avod: a library can't be loaded: {reason}; is memory limited (ulimit -v)?\n")
        sys.exit(2)

    run(avod, "avod")
