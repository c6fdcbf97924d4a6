"""Two groups of tests: on a fake core, always; on the real one, where it is built."""

from __future__ import annotations

import importlib
import importlib.util
import signal
import sys
from collections.abc import Iterator
from importlib.machinery import PathFinder
from typing import Any

import pytest

import fake_native

_FAKED = (
    "Assets",
    "BeamTable",
    "Camera",
    "EncoderFiring",
    "LabelConfig",
    "Laser",
    "Lidar",
    "ListedFiring",
    "Pose",
    "PropConfig",
    "Request",
    "Rig",
    "Scene",
    "SceneConfig",
    "SuburbConfig",
    "UniformFiring",
    "VehicleMesh",
    "encode_png",
    "weather_names",
)


def _is_core_built() -> bool:
    package = importlib.util.find_spec("cadet")
    locations = None if package is None else package.submodule_search_locations
    return PathFinder.find_spec("cadet._cadet", locations) is not None


IS_CORE_BUILT = _is_core_built()
if not IS_CORE_BUILT:
    # The package can't be imported without a core, so the fake must stand before any test is.
    sys.modules["cadet._cadet"] = fake_native

# A shell starts its background jobs with Ctrl-C ignored, and so would be what tests interrupt.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Whole folders that look at what the real core makes.
collect_ignore_glob = [] if IS_CORE_BUILT else ["generated/*", "avod/*", "fuzz/*"]


def pytest_report_header() -> list[str]:
    """Say what the tests run on."""
    lines = [] if IS_CORE_BUILT else ["the compiled core is not built (`make build`): tests of it are skipped"]
    missing = [name for name in ("torch", "safetensors") if importlib.util.find_spec(name) is None]
    if missing:
        lines.append(f"tests/avod is skipped: it needs {' and '.join(missing)} (pip install 'cadet-sim[avod]')")
    return lines


@pytest.fixture
def fake_core(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Put the fake core's parts into the place of the real one's."""
    core = sys.modules.get("cadet._cadet") or importlib.import_module("cadet._cadet")
    for name in _FAKED:
        monkeypatch.setattr(core, name, getattr(fake_native, name))
    monkeypatch.delenv("CADET_FAKE", raising=False)
    # What one core has built is nothing to the other.
    caches = (importlib.import_module("cadet.assets")._native, importlib.import_module("cadet.lidar")._to_native)
    for built in caches:
        built.cache_clear()
    yield fake_native
    for built in caches:
        built.cache_clear()


@pytest.fixture(scope="session")
def core() -> Any:
    """Skip where the compiled core is missing."""
    if not IS_CORE_BUILT:
        pytest.skip("the compiled core is not built: run `make build`")
    return importlib.import_module("cadet._cadet")
