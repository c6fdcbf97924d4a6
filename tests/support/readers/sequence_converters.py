"""Sequences converted by the other project's own program, and opened by its own reader."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any


def _run(command: list[str], folder: Path, **environment: str) -> None:
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]


def scenes_of_123d(scenes: Path, out: Path, *splits: str) -> list[Any]:
    """Convert splits of a set in nuScenes' format, such as "nuscenes_train", and return 123D's scenes."""
    (scenes / "can_bus").mkdir(exist_ok=True)
    command = [str(Path(sys.executable).with_name("py123d-conversion")), f"dataset={splits[0].rpartition('_')[0]}"]
    command += [f"dataset.parser.splits=[{','.join(splits)}]", "dataset.parser.nuscenes_map_root=null"]
    command += ["execution=sequential_executor"]
    _run(command, out, NUSCENES_DATA_ROOT=str(scenes), PY123D_DATA_ROOT=str(out))
    api = import_module("py123d.api")
    found: list[Any] = api.get_filtered_scenes(api.SceneFilter(iteration_threshold=100), out)
    return found


def sequence_of_ncore(drive: Path, out: Path, clone: str) -> Any:
    """Convert the only drive of a day, by the converter in a clone of NCore's repository; return NCore's sequence."""
    command = [sys.executable, "-m", "tools.data_converter.kitti.main", "--root-dir", str(drive.parent)]
    command += ["--output-dir", str(out), "--camera-id", "camera_color_left", "kitti-v4"]
    _run(command, out, PYTHONPATH=clone)
    v4 = import_module("ncore.data.v4")
    return v4.SequenceLoaderV4(v4.SequenceComponentGroupsReader(sorted((out / drive.name).glob("*.zarr.itar"))))
