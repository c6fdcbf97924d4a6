"""`python -m tools.experiments`, from the folder that holds `tools`."""

from __future__ import annotations

import importlib.util
import os
import sys

_NEEDED = ("torch", "safetensors", "matplotlib", "scipy")

missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
if missing:
    sys.exit(
        f"python -m tools.experiments needs {' and '.join(missing)}: `make build-dev` installs the development tools"
    )

# Read when OpenMP is loaded, with torch: threads that wait for others must not take processor time.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

from cadet.cli.errors import run
from tools.experiments.command import experiments

run(experiments, "python -m tools.experiments")
