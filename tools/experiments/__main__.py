"""`python -m tools.experiments`, from the folder that holds `tools`."""

from __future__ import annotations

import os

# Read when OpenMP is loaded, with torch: threads that wait for others must not take processor time.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

from cadet.cli.errors import run
from tools.experiments.command import experiments

run(experiments, "python -m tools.experiments")
