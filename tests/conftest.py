"""What all tests share: the compiled core, Ctrl-C that is heard, a mark for slow ones, and no skips in CI."""

from __future__ import annotations

import importlib
import importlib.util
import signal
from typing import Any

import pytest

from in_ci import pytest_make_collect_report, pytest_runtest_makereport
from slow_tests import pytest_collection_modifyitems

__all__ = [
    "core",
    "pytest_collection_modifyitems",
    "pytest_make_collect_report",
    "pytest_report_header",
    "pytest_runtest_makereport",
]

try:
    importlib.import_module("cadet._cadet")
except ImportError as error:
    raise pytest.UsageError(f"the compiled core is not built: run `make build` ({error})") from None

# A shell starts its background jobs with Ctrl-C ignored, and so would be what tests interrupt.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_report_header() -> list[str]:
    """Say what is left out."""
    missing = [name for name in ("torch", "safetensors") if importlib.util.find_spec(name) is None]
    needed = f"they need {' and '.join(missing)} (pip install 'cadet-sim[avod]')"
    return [f"tests/avod and tests/tools are skipped: {needed}"] if missing else []


@pytest.fixture(scope="session")
def core() -> Any:
    """Return the compiled core, for tests of what the package hides."""
    return importlib.import_module("cadet._cadet")
