"""The commands of `avod`."""

from __future__ import annotations

import importlib.util
import sys

from avod.cli.process import set_up_process

_NEEDED = ("torch", "safetensors", "click", "rich")


def run_avod() -> None:
    """Run `avod`."""
    missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        sys.stderr.write(f"avod needs {' and '.join(missing)}: pip install 'cadet-sim[avod]'\n")
        sys.exit(2)
    set_up_process()
    try:
        from avod.cli.commands import avod
        from cadet.cli.errors import run
    except ImportError as error:
        # The loader of shared libraries says no more where the memory doesn't suffice to map PyTorch's.
        reason = " ".join(str(error).split())
        sys.stderr.write(f"avod: a library can't be loaded: {reason}; is memory limited (ulimit -v)?\n")
        sys.exit(2)

    run(avod, "avod")
