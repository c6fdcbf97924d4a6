"""`python -m tools.experiments`, from the folder that holds `tools`."""

from __future__ import annotations

import importlib.util
import os
import sys

_NAME = "python -m tools.experiments"
_NEEDED = ("torch", "safetensors", "matplotlib", "scipy")


def main() -> None:
    """Run the command, if its libraries are there."""
    missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        sys.exit(f"{_NAME} needs {' and '.join(missing)}: `make build-dev` installs the development tools")
    # Read when OpenMP is loaded, with torch: threads that wait for others must not take processor time.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    from cadet.cli.errors import run
    from tools.experiments.command import experiments

    run(experiments, _NAME)


main()
