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
    "cadet/formats": "foreign_folders fuzz_readers kitti_raw kitti_sequences nuscenes toolboxes",
    "cadet/formats/kitti": "depths",
    "cadet/generate": "dataset faults generate generate_errors generate_shards generate_splits object_sink "
    "plain_scripts ray same_bytes sequences",
    "cadet/sensors": "calibrations embree image_texture kitti_look lidars returns road_scans scan_modes sensor_suite "
    "sensors_agree",
    "cadet/simulation": "benchmark_scenes cyclists ego_commands gym image_size label_limits labels scripted streaming "
    "why_traffic_stands",
    "cadet/view": "gallery recording",
    "cadet/worlds": "assets_in_frames night paper_policy props_in_frames scene_config trucks",
    "cadet/worlds/meshes": "broken_inputs gltf_assets",
    "repository": "docs docs_site makefile",
    "tools": "experiments experiments_command gpu_run",
}
SLOW: Final = frozenset(
    _TESTS / folder / f"test_{name}.py" for folder, names in _MODULES.items() for name in names.split()
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of slow modules."""
    missing = sorted(str(path.relative_to(_TESTS)) for path in SLOW if not path.is_file())
    if missing:
        raise pytest.UsageError(f"tests/support/slow_tests.py: no such tests: {', '.join(missing)}")
    for item in items:
        if item.path in SLOW:
            item.add_marker(pytest.mark.slow)
