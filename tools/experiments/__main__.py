"""`python -m tools.experiments`, from the folder that holds `tools`."""

from __future__ import annotations

import importlib.util
import sys

from avod.cli.process import set_up_process

_NAME = "python -m tools.experiments"
_NEEDED = ("torch", "safetensors", "matplotlib", "scipy")


def main() -> None:
    """Run the command, if its libraries are there."""
    missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        sys.exit(f"{_NAME} needs {' and '.join(missing)}: `make build-dev` installs the development tools")
    set_up_process()
    from cadet.cli.errors import run
    from tools.experiments.command import experiments

    run(experiments, _NAME)


main()
