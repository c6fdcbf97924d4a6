"""Where the files of a KITTI folder lie, and how they are written."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

import numpy as np

from cadet._util.checks import as_path, shown
from cadet._util.user_files import names_file
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.other_layouts import has_sequences, no_kitti_folder

SUFFIXES: Final = {
    "image_2": ".png",
    "velodyne": ".bin",
    "calib": ".txt",
    "label_2": ".txt",
    "planes": ".txt",
    "meta": ".json",
    "depth": ".png",
    "instance": ".png",
    "semantic": ".png",
    "normals": ".png",
    "optical_flow": ".png",
    "scene_flow": ".png",
    "radiance": ".png",
    "image_3": ".png",
    "label_3": ".txt",
    "point_labels": ".label",
    "point_times": ".bin",
    "points_ply": ".ply",
    "points_pcd": ".pcd",
    "points_las": ".las",
    "points_npz": ".npz",
    "range_image": ".npy",
}
"""Every folder of a training set and the suffix of its files."""

CAMERAS: Final = "cameras"
"""The folder of a rig's further cameras: `cameras/NAME` holds folders of `OF_CAMERA`."""
OF_CAMERA: Final = (
    *("image_2", "calib", "label_2"),
    *("depth", "instance", "semantic", "normals", "optical_flow", "scene_flow", "radiance"),
)
"""The folders that a further camera has, each with what the first camera's has."""

_CAMERA: Final = re.compile(r"[A-Za-z0-9_-]{1,64}")
_IMAGE_SUFFIXES: Final = (".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG")
_READ_SUFFIXES: Final = {"image_2": _IMAGE_SUFFIXES, "image_3": _IMAGE_SUFFIXES}

REQUIRED: Final = ("image_2", "velodyne", "calib")
"""The folders that every frame must have a file in."""

_NUMBERED: Final = re.compile(r"[0-9]{6}")
_MAX_NUMBER: Final = 999_999
_MAX_ID_BYTES: Final = 200
"""Leaves room for suffixes and for the names that files have while they are written."""


def is_id(text: str) -> bool:
    """Tell whether a text can be a frame's id: the stem of a file that is not hidden, and that a list can hold."""
    is_plain = text.isprintable() and text == text.strip() and not text.startswith(".")
    return bool(text) and is_plain and "/" not in text and len(text.encode()) <= _MAX_ID_BYTES


def is_numbered(frame_id: str) -> bool:
    """Tell whether an id is of KITTI's own kind, six digits, as all ids are that cadet writes."""
    return _NUMBERED.fullmatch(frame_id) is not None


def check_id(frame_id: str | int) -> str:
    """Return a frame's id; a number means six digits.

    Raises:
        CadetError: no stem of a file, or a number of more digits.
    """
    is_number = isinstance(frame_id, (int, np.integer)) and not isinstance(frame_id, bool)
    if is_number and 0 <= int(frame_id) <= _MAX_NUMBER:
        return f"{int(frame_id):06d}"
    if not isinstance(frame_id, str) or not is_id(frame_id):
        raise CadetError(
            f"frame id: expected the name of a frame's files without suffix, such as '000012', got {shown(frame_id)}"
        )
    return frame_id


def is_camera_name(name: str) -> bool:
    """Tell whether a camera's name can be that of its folder: letters, digits, `_`, and `-`, up to 64."""
    return _CAMERA.fullmatch(name) is not None


def camera_kind(camera: str, kind: str) -> str:
    """Name the kind of file that a further camera has in place of one of `OF_CAMERA`."""
    return f"{CAMERAS}/{camera}/{kind}"


def is_kind(kind: str) -> bool:
    """Tell whether a folder is one of `SUFFIXES`, or one of a further camera's."""
    parent, _, own = kind.rpartition("/")
    lead, _, camera = parent.partition("/")
    return kind in SUFFIXES or (lead == CAMERAS and is_camera_name(camera) and own in OF_CAMERA)


def suffix_of(kind: str) -> str:
    """Return the suffix that files of one kind, such as a further camera's, are written with."""
    return SUFFIXES[kind.rpartition("/")[2]]


def camera_names(folder: Path) -> tuple[str, ...]:
    """List the further cameras of the folder that holds `calib`, sorted."""
    return tuple(sorted(name for name in _names(folder / CAMERAS) if is_camera_name(name)))


def kinds_in(folder: Path) -> tuple[str, ...]:
    """List the kinds of files that may be in the folder that holds `calib`, those of its further cameras last."""
    return (*SUFFIXES, *(camera_kind(camera, kind) for camera in camera_names(folder) for kind in OF_CAMERA))


def set_root(root: str | Path) -> Path:
    """Find the folder that holds `training` and `ImageSets`.

    It is `root` itself, `root/object` as KITTI's users keep its archives, or the parent if `root` is `training`.
    """
    root = as_path("root", root)
    if _holds_frames(root / "training"):
        return root
    if _holds_frames(root / "object" / "training"):
        return root / "object"
    return root.parent if root.name == "training" and _holds_frames(root) else root


def sample_folder(root: str | Path) -> Path:
    """Find the folder that holds `calib` and the other folders: `training` in `set_root`, or `root` itself.

    Raises:
        MissingFileError: neither is a KITTI folder; the line says what it is.
    """
    place = set_root(root)
    for folder in (place / "training", place):
        if _holds_frames(folder):
            return folder
    raise MissingFileError(no_kitti_folder(place))


def _holds_frames(folder: Path) -> bool:
    return any((folder / kind).is_dir() for kind in REQUIRED) and not has_sequences(folder)


def testing_folder(root: str | Path) -> Path | None:
    """Find the folder of the test frames beside `root/training`; None where there is none."""
    folder = set_root(root) / "testing"
    return folder if _holds_frames(folder) else None


def split_folder(root: str | Path, split: str | None) -> Path:
    """Find the folder that holds a split's frames: `root/testing` for "test", else what `sample_folder` finds.

    Raises:
        MissingFileError: there is none.
    """
    if split != "test":
        return sample_folder(root)
    folder = testing_folder(root)
    if folder is None:
        raise MissingFileError(
            f"{root}: no test frames: no testing/image_2, testing/velodyne or testing/calib is there"
        )
    return folder


def file_path(folder: Path, kind: str, frame_id: str, suffix: str | None = None) -> Path:
    """Name the file of one kind (see `is_kind`) of a frame, as it is written unless another suffix is given."""
    return folder / kind / f"{frame_id}{suffix or suffix_of(kind)}"


def read_suffixes(kind: str) -> tuple[str, ...]:
    """Return the suffixes that files of one kind are read with; the first that is there is read."""
    return _READ_SUFFIXES.get(kind.rpartition("/")[2], (suffix_of(kind),))


def found_path(folder: Path, kind: str, frame_id: str) -> Path:
    """Find the file of one kind of a frame by each suffix that is read; where there is none, name what is written."""
    paths = [file_path(folder, kind, frame_id, suffix) for suffix in read_suffixes(kind)]
    # Not exists: a broken link in a file's place is to be found.
    return next((path for path in paths if os.path.lexists(path)), paths[0])


def display_name(path: Path) -> str:
    """Name a file in messages: as it lies in the folder that holds `calib`."""
    return str(path.relative_to(folder_of(path)))


def folder_of(path: Path) -> Path:
    """Return the folder that holds `calib` and its fellows, of a frame's file or of one of its further cameras'."""
    is_of_camera = len(path.parts) > 4 and path.parts[-4] == CAMERAS
    return path.parents[3] if is_of_camera else path.parent.parent


def frame_ids(folder: Path) -> tuple[str, ...]:
    """List the ids of a folder's frames, sorted.

    Six digits are a frame's wherever they stand among `REQUIRED`. Other names are where two folders have them, or the
    only one that there is: a readme or a copy among the files is no frame.
    """
    by_kind = {kind: ids_among(_names(folder / kind), kind) for kind in (*REQUIRED, "label_2")}
    counts = Counter(frame_id for ids in by_kind.values() for frame_id in ids)
    needed = min(2, sum(map(bool, by_kind.values())))
    ids = set().union(*(by_kind[kind] for kind in REQUIRED))
    return tuple(sorted(one for one in ids if is_numbered(one) or counts[one] >= needed))


def ids_among(names: Iterable[str], kind: str) -> set[str]:
    """Return the ids of those names that are read as a file of one kind (a key of `SUFFIXES`)."""
    suffixes = read_suffixes(kind)
    return {path.stem for path in map(Path, names) if path.suffix in suffixes and is_id(path.stem)}


def _names(folder: Path) -> list[str]:
    try:
        return os.listdir(folder)  # noqa: PTH208 - names alone
    except OSError:
        return []


def write_whole(contents: Mapping[Path, bytes]) -> None:
    """Write files so that each appears whole or not at all: all are written aside first, then renamed into place.

    Missing folders are made. When a write fails, nothing has been renamed and what lay aside is removed.
    """
    aside = {path: path.with_name(f".{path.name}.{os.getpid()}.tmp") for path in contents}
    try:
        for path, data in contents.items():
            with names_file(path):
                path.parent.mkdir(parents=True, exist_ok=True)
                aside[path].write_bytes(data)
        for path in contents:
            aside[path].replace(path)
    finally:
        for path in aside.values():
            path.unlink(missing_ok=True)
