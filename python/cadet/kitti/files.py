"""Where the files of a KITTI folder lie, and how they are written."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Final

import numpy as np

from cadet.checks import as_path, shown
from cadet.errors import CadetError, MissingFileError
from cadet.user_files import names_file

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
    "image_3": ".png",
    "point_labels": ".label",
}
"""Every folder of a training set and the suffix of its files."""

_IMAGE_SUFFIXES: Final = (".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG")
_READ_SUFFIXES: Final = {"image_2": _IMAGE_SUFFIXES, "image_3": _IMAGE_SUFFIXES}

REQUIRED: Final = ("image_2", "velodyne", "calib")
"""The folders that every frame must have a file in."""

_ID: Final = re.compile(r"[0-9]{6}")
_MAX_ID: Final = 999_999


def check_id(frame_id: str | int) -> str:
    """Return a frame's id as six digits.

    Raises:
        CadetError: it is neither six digits nor a number that has them.
    """
    is_number = isinstance(frame_id, (int, np.integer)) and not isinstance(frame_id, bool)
    if is_number and 0 <= int(frame_id) <= _MAX_ID:
        return f"{int(frame_id):06d}"
    if not isinstance(frame_id, str) or not _ID.fullmatch(frame_id):
        raise CadetError(f"frame id: expected six digits such as '000012', got {shown(frame_id)}")
    return frame_id


def sample_folder(root: str | Path) -> Path:
    """Find the folder that holds `calib` and the other folders: `root/training`, or `root` itself.

    Raises:
        MissingFileError: neither is a KITTI folder.
    """
    root = as_path("root", root)
    for folder in (root / "training", root):
        if any((folder / name).is_dir() for name in REQUIRED):
            return folder
    raise MissingFileError(f"{root}: no KITTI folder: neither training/calib nor calib lies there")


def testing_folder(root: str | Path) -> Path | None:
    """Find the folder of the test frames beside `root/training`; None where there is none."""
    folder = Path(root) / "testing"
    return folder if any((folder / name).is_dir() for name in REQUIRED) else None


def split_folder(root: str | Path, split: str | None) -> Path:
    """Find the folder that holds a split's frames: `root/testing` for "test", else what `sample_folder` finds.

    Raises:
        MissingFileError: there is none.
    """
    if split != "test":
        return sample_folder(root)
    folder = testing_folder(root)
    if folder is None:
        raise MissingFileError(f"{root}: no test frames: there is no testing/calib")
    return folder


def file_path(folder: Path, kind: str, frame_id: str, suffix: str | None = None) -> Path:
    """Name the file of one kind (a key of `SUFFIXES`) of a frame, as it is written unless another suffix is given."""
    return folder / kind / f"{frame_id}{suffix or SUFFIXES[kind]}"


def read_suffixes(kind: str) -> tuple[str, ...]:
    """Return the suffixes that files of one kind are read with; the first that is there is read."""
    return _READ_SUFFIXES.get(kind, (SUFFIXES[kind],))


def found_path(folder: Path, kind: str, frame_id: str) -> Path:
    """Find the file of one kind of a frame by each suffix that is read; where there is none, name what is written."""
    paths = [file_path(folder, kind, frame_id, suffix) for suffix in read_suffixes(kind)]
    # Not exists: a broken link in a file's place is to be found.
    return next((path for path in paths if os.path.lexists(path)), paths[0])


def display_name(path: Path) -> str:
    """Name a file in messages: its folder and name."""
    return f"{path.parent.name}/{path.name}"


def frame_ids(folder: Path) -> tuple[str, ...]:
    """List the ids that any required folder has, sorted."""
    ids: set[str] = set()
    for kind in REQUIRED:
        ids |= ids_among((path.name for path in (folder / kind).glob("*")), read_suffixes(kind))
    return tuple(sorted(ids))


def ids_among(names: Iterable[str], suffixes: Collection[str]) -> set[str]:
    """Return the ids of those names that end in one of the suffixes."""
    paths = map(Path, names)
    return {path.stem for path in paths if path.suffix in suffixes and _ID.fullmatch(path.stem)}


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
