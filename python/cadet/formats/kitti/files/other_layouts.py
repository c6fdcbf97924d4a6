"""Folders that are no KITTI folder: what they are, by `manifest.json` or by how they are laid out, and what to do."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Final

from cadet._util.plain_text import json_from_text
from cadet.errors import FileFormatError

MANIFEST: Final = "manifest.json"

_MOST_NAMED: Final = 5
_EXPECTED: Final = "training/image_2, training/velodyne and training/calib"
_ANEW: Final = "write the set anew with cadet-gen --format kitti"
_OURS: Final = {
    "webdataset": "cadet convert {root} NEW_FOLDER --to kitti makes a KITTI folder of it",
    "kitti_tracking": _ANEW,
    "kitti_raw": _ANEW,
    "nuscenes": _ANEW,
    "mcap": _ANEW,
    "parquet": _ANEW,
}
"""What to do about a set of each of our formats where a KITTI folder is needed."""
_SEQUENCES: Final = ("image_02/[0-9][0-9][0-9][0-9]", "velodyne/0000")
"""Folders of KITTI's tracking set, one for each drive."""
_OBJECT: Final = f"copy its frames to the layout of KITTI's object set, {_EXPECTED}, each with a name of its own"

_SIGNS: Final = (
    (("*/*.tar",), "shards of WebDataset", _OURS["webdataset"]),
    (("v1.0-*", "samples/LIDAR_TOP"), "a nuScenes folder", "nuscenes-devkit's export_kitti.py writes a KITTI folder"),
    (
        (*_SEQUENCES, *(f"training/{pattern}" for pattern in _SEQUENCES)),
        "KITTI's tracking set, which has a folder for each sequence",
        _OBJECT,
    ),
    (("20??_??_??/*_sync", "20??_??_??_drive_*", "velodyne_points"), "KITTI's raw data", _OBJECT),
    (
        ("sequences/[0-9]*", "dataset/sequences", "[0-9][0-9]/velodyne"),
        "KITTI's odometry set, or SemanticKITTI",
        _OBJECT,
    ),
    (("data_3d_raw", "data_2d_raw"), "KITTI-360", _OBJECT),
    (("*.tfrecord", "*/*.tfrecord"), "Waymo's records", "MMDetection3D's create_data.py waymo writes kitti_format"),
    (
        ("*/training/image_2", "*/training/velodyne", "*/training/calib", "*/image_2", "*/calib"),
        "a folder that holds a KITTI folder, or one of its archives",
        "name {root}/{first}, once image_2, velodyne, calib and label_2 lie side by side there",
    ),
    (("points/*.npy",), "an OpenPCDet custom set", _OBJECT + ", scans as float32 x, y, z, intensity in .bin"),
)
"""Patterns of what lies in a folder, what it then is, and what to do; the first row that fits counts."""

_OTHER_NAMES: Final = {
    "image_2": ("image_02", "images", "image", "image_0", "colored_0", "image_3"),
    "velodyne": ("velodyne_points", "lidar", "points", "pointcloud", "velodyne_reduced"),
    "calib": ("calib.txt", "calib/calib.txt", "calibs", "calibration", "../calib.txt"),
    "label_2": ("label_02", "labels", "label", "label_0", "label_all"),
}
"""What converters call a folder, or put in its place, by its name in KITTI."""


def no_kitti_folder(root: Path) -> str:
    """Say that a folder is not a KITTI folder: what it is instead and what to do, or what lies there."""
    if not root.is_dir():
        return f"{root}: {'no folder' if root.exists() else 'no such folder'}"
    name = format_of(root)
    if name in _OURS:
        remedy = _OURS[name].format(root=root)
        return f"{root}: a set of format {name} ({MANIFEST}), and a KITTI folder is needed: {remedy}"
    for patterns, what, remedy in _SIGNS:
        for found in (path for pattern in patterns for path in root.glob(pattern)):
            place = found.relative_to(root)
            remedy = remedy.format(root=root, first=place.parts[0])
            return f"{root}: {what} ({place}), and a KITTI folder is needed: {remedy}"
    return f"{root}: no KITTI folder: it {_holds(root)}; expected {_EXPECTED}"


def no_frames(root: Path, folder: Path, kinds: tuple[str, ...]) -> str:
    """Say that a KITTI folder has no frames: what lies in its folders, and what was expected."""
    found = [f"{kind} {_holds(folder / kind)}" for kind in kinds if (folder / kind).is_dir()]
    expected = ", ".join(f"{kind}/000000" for kind in kinds)
    return f"{root}: no frames: {'; '.join(found)}; expected files of one name, as {expected} with their suffixes"


def format_of(root: Path) -> str | None:
    """Return the format of a set that cadet wrote; None where no manifest says it."""
    path = root / MANIFEST
    try:
        content: Any = json_from_text(path.read_bytes(), MANIFEST) if path.is_file() else None
    except (FileFormatError, OSError):
        return None
    # A KITTI folder's manifest names none.
    name = content.get("dataset_format", "kitti") if isinstance(content, dict) and "cadet" in content else None
    return name if isinstance(name, str) else None


def has_sequences(folder: Path) -> bool:
    """Tell whether a folder holds KITTI's tracking set, whose `calib` and `velodyne` are named as the object set's."""
    if (folder / "image_2").is_dir():
        return False
    return any(path.is_dir() for pattern in _SEQUENCES for path in folder.glob(pattern))


def instead(folder: Path, kind: str) -> str:
    """Say, as the end of a line, what lies in place of one of KITTI's kinds of files; empty where nothing does."""
    name = next((name for name in _OTHER_NAMES.get(kind, ()) if (folder / name).exists()), None)
    if name is None:
        return f"; {kind} {_holds(folder / kind)}" if (folder / kind).is_dir() else ""
    if name.endswith(".txt"):
        return f"; {name} is there: copy it to {kind}/ID.txt for every frame, with KITTI's keys"
    return f"; {name} is there: rename it to {kind} if it holds the same"


def _holds(folder: Path) -> str:
    try:
        names = sorted(os.listdir(folder))  # noqa: PTH208 - names alone
    except OSError as error:
        return f"cannot be listed ({error.strerror or error})"
    named = ", ".join(name if name.isprintable() else ascii(name)[1:-1] for name in names[:_MOST_NAMED])
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return f"holds {named}{more}" if names else "is empty"
