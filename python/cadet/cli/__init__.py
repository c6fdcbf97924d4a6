"""The commands. click and rich are theirs alone: `import cadet` does without."""

from __future__ import annotations

import importlib.util
import sys


def _need(command: str) -> None:
    missing = [name for name in ("click", "rich") if importlib.util.find_spec(name) is None]
    if missing:
        sys.stderr.write(f"{command} needs {' and '.join(missing)}: pip install {' '.join(missing)}\n")
        sys.exit(2)


def run_cadet() -> None:
    """Run `cadet`."""
    _need("cadet")
    from cadet.cli.errors import run
    from cadet.cli.tools import cadet

    run(cadet, "cadet")


def run_cadet_gen() -> None:
    """Run `cadet-gen`."""
    _need("cadet-gen")
    from cadet.cli.errors import run
    from cadet.cli.gen import cadet_gen

    run(cadet_gen, "cadet-gen")
