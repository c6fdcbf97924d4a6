"""The tests that `make test-fast` leaves out: generated worlds, trainings, other programs, and the pages' code."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

_TESTS: Final = Path(__file__).parents[1]
_MODULES: Final[dict[str, str]] = {
    "avod": "evaluation packaged validation",
    "avod/cli": "cli first_run",
    "avod/data": "frames mixture paste shards simulated subset",
    "avod/model": "arithmetic",
    "avod/train": "average checkpoints processes resume training",
    "cadet/datasets": "lidar_fit range_offsets report",
    "cadet/formats": "coco foreign_folders fuzz_readers kitti_raw kitti_sequences nuscenes nuscenes_sweeps readers "
    "ros_bags toolboxes",
    "cadet/formats/kitti": "depths",
    "cadet/generate": "dataset faults generate generate_errors generate_shards generate_splits object_sink "
    "plain_scripts ray same_bytes sequences",
    "cadet/sensors": "calibrations embree image_texture kitti_look lidars returns road_scans scan_modes sensor_suite "
    "sensors_agree",
    "cadet/simulation": "benchmark_scenes cyclists ego_commands gym image_size label_limits labels scripted streaming "
    "why_traffic_stands",
    "cadet/figures": "gallery recording",
    "cadet/worlds": "assets_in_frames night paper_policy props_in_frames scene_config trucks",
    "cadet/worlds/meshes": "broken_inputs gltf_assets",
    "repository": "action docs docs_site makefile notebooks",
    "tools": "experiments experiments_command gpu_run",
}
SLOW: Final = (
    *(f"{folder}/test_{name}.py" for folder, names in _MODULES.items() for name in names.split()),
    "cadet/generate/test_golden_bytes.py::test_processors_without_wide_registers_give_the_same_bytes",
)
"""Modules, or one test of a module, in the folder `tests`."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that are slow."""
    missing = sorted(name for name in SLOW if not (_TESTS / name.partition("::")[0]).is_file())
    if missing:
        raise pytest.UsageError(f"tests/support/slow_tests.py: no such tests: {', '.join(missing)}")
    for item in items:
        path = item.path.relative_to(_TESTS).as_posix() if item.path.is_relative_to(_TESTS) else ""
        if path in SLOW or f"{path}::{item.name.partition('[')[0]}" in SLOW:
            item.add_marker(pytest.mark.slow)
