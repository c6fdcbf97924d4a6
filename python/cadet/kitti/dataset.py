"""Whole frames of a KITTI folder: reading, writing, iterating."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet.checks import as_path, check_flag, check_kind
from cadet.errors import CadetError, FileFormatError, FrameExistsError, KittiFormatError, MissingFileError
from cadet.kitti import images
from cadet.kitti.calib import Calibration
from cadet.kitti.files import (
    SUFFIXES,
    check_id,
    display_name,
    file_path,
    frame_ids,
    sample_folder,
    split_folder,
    write_whole,
)
from cadet.kitti.frame import Frame
from cadet.kitti.image_sets import list_frame, other_split, read_image_set
from cadet.kitti.label import Label, labels_from_text, text_from_labels
from cadet.kitti.planes import plane_from_text, text_from_plane
from cadet.kitti.velodyne import bytes_from_points, points_from_bytes
from cadet.plain_text import json_from_text


def read_frame(root: str | Path, frame_id: str | int, *, has_extras: bool = True) -> Frame:
    """Read one frame of a KITTI folder, real or generated.

    Args:
        root: the folder that holds `training`, or one that holds `calib` and its fellows itself.
        frame_id: six digits, or the number they make.
        has_extras: read what KITTI's own frames lack too: depth, instance, semantic and meta; else they are None.

    Returns:
        The frame; labels are empty where the set has none, everything else optional is None where nothing was written.

    Raises:
        MissingFileError: no KITTI folder, no such frame, or a file that its fellows have is missing.
        KittiFormatError: a damaged file, named with line and reason.
    """
    check_flag("", "has_extras", has_extras)
    folder = sample_folder(root)
    frame_id = check_id(frame_id)
    image = images.decode_image(*_read_bytes(folder, "image_2", frame_id))
    points_velo = points_from_bytes(*_read_bytes(folder, "velodyne", frame_id))
    calib = Calibration.from_text(*_read_text(folder, "calib", frame_id))
    extras: dict[str, Any] = {}
    if has_extras:
        extras = {
            "depth": _read_depth(folder, frame_id, image.shape),
            "instance": _read_instance(folder, frame_id, image.shape),
            "semantic": _read_map(folder, "semantic", frame_id, np.uint8, image.shape),
            "meta": _read_meta(folder, frame_id) if _has(folder, "meta", frame_id) else None,
        }
    return Frame(
        image=image,
        points_velo=points_velo,
        labels=read_labels(folder, frame_id) if (folder / "label_2").is_dir() else (),
        calib=calib,
        plane=plane_from_text(*_read_text(folder, "planes", frame_id)) if _has(folder, "planes", frame_id) else None,
        **extras,
    )


def read_labels(root: str | Path, frame_id: str | int) -> tuple[Label, ...]:
    """Read only the labels of a frame.

    Raises:
        MissingFileError: there is no label file.
        KittiFormatError: a malformed line.
    """
    return labels_from_text(*_read_text(sample_folder(root), "label_2", check_id(frame_id)))


def read_calib(root: str | Path, frame_id: str | int) -> Calibration:
    """Read only the calibration of a frame.

    Raises:
        MissingFileError: there is no calibration file.
        KittiFormatError: a missing key or malformed number.
    """
    return Calibration.from_text(*_read_text(sample_folder(root), "calib", check_id(frame_id)))


def read_meta(root: str | Path, frame_id: str | int) -> dict[str, Any] | None:
    """Read only what else the generator knew of a frame; None where nothing was written, as of KITTI's own.

    Raises:
        KittiFormatError: no JSON object.
    """
    folder, frame_id = sample_folder(root), check_id(frame_id)
    return _read_meta(folder, frame_id) if _has(folder, "meta", frame_id) else None


def check_files(root: str | Path, frame_id: str | int) -> list[tuple[str, CadetError | OSError]]:
    """List what is wrong with each file of a frame: its folder, and the error that reading it raises.

    A label file is read line by line, so it may give several.

    Raises:
        MissingFileError: no KITTI folder.
    """
    folder = sample_folder(root)
    frame_id = check_id(frame_id)
    readers: dict[str, Callable[[], object]] = {
        "image_2": lambda: images.decode_image(*_read_bytes(folder, "image_2", frame_id)),
        "velodyne": lambda: points_from_bytes(*_read_bytes(folder, "velodyne", frame_id)),
        "calib": lambda: read_calib(folder, frame_id),
    }
    optional: dict[str, Callable[[], object]] = {
        "planes": lambda: plane_from_text(*_read_text(folder, "planes", frame_id)),
        "meta": lambda: _read_meta(folder, frame_id),
    }
    readers |= {kind: reader for kind, reader in optional.items() if _has(folder, kind, frame_id)}
    wrong = [(kind, error) for kind, reader in readers.items() if (error := _error_of(reader)) is not None]
    is_image_read = all(kind != "image_2" for kind, _ in wrong)
    if is_image_read:
        shape = images.decode_image(*_read_bytes(folder, "image_2", frame_id)).shape
        maps: dict[str, Callable[[], object]] = {
            "depth": lambda: _read_depth(folder, frame_id, shape),
            "instance": lambda: _read_instance(folder, frame_id, shape),
            "semantic": lambda: _read_map(folder, "semantic", frame_id, np.uint8, shape),
        }
        wrong += [(kind, error) for kind, reader in maps.items() if (error := _error_of(reader)) is not None]
    return wrong + _label_errors(folder, frame_id)


def encode_frame(frame: Frame) -> dict[str, bytes]:
    """Return the bytes of a frame's files by folder; what is None has no entry.

    Args:
        frame: the frame.

    Raises:
        CadetError: what the format cannot hold: an instance id above 65534, a `meta` that is no JSON.
    """
    check_kind("", "frame", frame, Frame)
    contents = {"image_2": images.encode_png(frame.image)}
    contents |= encode_facts(frame.points_velo, frame.calib, frame.labels, frame.plane)
    if frame.meta is not None:
        contents["meta"] = encode_meta(frame.meta)
    return contents | encode_maps(frame.depth, frame.instance, frame.semantic)


def encode_facts(
    points_velo: NDArray[np.float32],
    calib: Calibration,
    labels: tuple[Label, ...],
    plane: NDArray[np.float64] | None,
) -> dict[str, bytes]:
    """Return the bytes of a frame's files but those of images and `meta`, by folder."""
    contents = {
        "velodyne": bytes_from_points(points_velo),
        "calib": calib.to_text().encode("ascii"),
        "label_2": text_from_labels(labels).encode("ascii"),
    }
    if plane is not None:
        contents["planes"] = text_from_plane(plane).encode("ascii")
    return contents


def encode_maps(
    depth: NDArray[np.float32] | None, instance: NDArray[np.int32] | None, semantic: NDArray[np.uint8] | None
) -> dict[str, bytes]:
    """Return the bytes of those maps that are not None, by folder.

    Raises:
        CadetError: an instance id above 65534.
    """
    contents = {}
    if depth is not None:
        contents["depth"] = images.encode_png(images.pixels_from_depth(depth))
    if instance is not None:
        contents["instance"] = images.encode_png(images.pixels_from_instance(instance))
    if semantic is not None:
        contents["semantic"] = images.encode_png(semantic)
    return contents


def encode_meta(meta: dict[str, Any]) -> bytes:
    """Return the bytes of a `meta` file.

    Raises:
        CadetError: what JSON cannot hold.
    """
    try:
        return (json.dumps(meta, indent=1, allow_nan=False) + "\n").encode("ascii")
    except (TypeError, ValueError) as error:
        raise CadetError(f"meta: no JSON: {error}") from None


def write_frame(
    root: str | Path,
    frame_id: str | int,
    frame: Frame,
    *,
    split: str | None = "train",
    overwrite: bool = False,
) -> None:
    """Write one frame under `root/training` and list it under `root/ImageSets`; what is None is not written.

    Files appear whole or not at all. The lists are read and written for each frame: several processes that write one
    dataset pass `split=None` and list the frames at the end with `write_image_set`.

    Args:
        root: the dataset's folder; missing folders are made.
        frame_id: six digits, or the number they make.
        frame: the frame.
        split: "train" or "val": the list that names the frame, besides `trainval`; lists that are missing are made.
            None leaves the lists alone.
        overwrite: replace a frame that is there; its files that `frame` lacks are removed.

    Raises:
        FrameExistsError: the frame is there and `overwrite` is not set.
        CadetError: what the format cannot hold: an instance id above 65534, a `meta` that is no JSON; an unknown split,
            or a frame that the other split lists.
    """
    folder = as_path("root", root) / "training"
    frame_id = check_id(frame_id)
    check_flag("", "overwrite", overwrite)
    if split is not None:
        other_split(root, frame_id, split)
    present = [path for kind in SUFFIXES if (path := file_path(folder, kind, frame_id)).exists()]
    if present and not overwrite:
        raise FrameExistsError(f"{present[0]}: frame {frame_id} exists; pass overwrite=True to replace it")
    contents = encode_frame(frame)
    paths = {file_path(folder, kind, frame_id): data for kind, data in contents.items()}
    write_whole(paths)
    for path in present:
        if path not in paths:
            path.unlink()
    if split is not None:
        list_frame(root, frame_id, split)


class Dataset:
    """The frames of a KITTI folder, read when asked for.

    Args:
        root: the folder that holds `training` and `ImageSets`.
        split: a list of `ImageSets` such as "train"; None for every frame of `training`. The frames of "test" lie under
            `testing`, and KITTI's have no labels.

    Raises:
        MissingFileError: no KITTI folder, or no such split.
        KittiFormatError: a malformed list.
    """

    def __init__(self, root: str | Path, split: str | None = None) -> None:
        self.root = as_path("root", root)
        self.split = split
        self.folder = split_folder(root, split)
        self.ids: tuple[str, ...] = frame_ids(self.folder) if split is None else read_image_set(root, split).ids
        self._members = frozenset(self.ids)

    def __len__(self) -> int:
        return len(self.ids)

    def __iter__(self) -> Iterator[Frame]:
        return (read_frame(self.folder, frame_id) for frame_id in self.ids)

    def __getitem__(self, key: int | str) -> Frame:
        """Read the frame at an index (int) or with an id (str).

        Raises:
            IndexError: no such index.
            KeyError: no such id in this split.
        """
        if isinstance(key, str):
            if key not in self._members:
                raise KeyError(key)
            return read_frame(self.folder, key)
        return read_frame(self.folder, self.ids[key])

    def __repr__(self) -> str:
        return f"Dataset({str(self.root)!r}, split={self.split!r}): {len(self)} frames"


def _error_of(reader: Callable[[], object]) -> CadetError | OSError | None:
    try:
        reader()
    except (CadetError, OSError) as error:
        return error
    return None


def _label_errors(folder: Path, frame_id: str) -> list[tuple[str, CadetError | OSError]]:
    if not (folder / "label_2").is_dir():
        return []
    try:
        text, name = _read_text(folder, "label_2", frame_id)
    except (CadetError, OSError) as error:
        return [("label_2", error)]
    lines = enumerate(text.removesuffix("\n").split("\n") if text else (), start=1)
    errors = [_error_of(partial(Label.from_line, line, name, number)) for number, line in lines]
    return [("label_2", error) for error in errors if error is not None]


def _has(folder: Path, kind: str, frame_id: str) -> bool:
    # Not is_file: a folder or a broken link in a file's place is to be found, not passed over.
    return os.path.lexists(file_path(folder, kind, frame_id))


def _read_bytes(folder: Path, kind: str, frame_id: str) -> tuple[bytes, str]:
    path = file_path(folder, kind, frame_id)
    try:
        # Opening a pipe would wait for its writer.
        if not stat.S_ISREG(path.stat().st_mode):
            raise KittiFormatError("no regular file", display_name(path))
        return path.read_bytes(), display_name(path)
    except FileNotFoundError:
        raise MissingFileError(f"{path}: no such file") from None


def _read_text(folder: Path, kind: str, frame_id: str) -> tuple[str, str]:
    data, name = _read_bytes(folder, kind, frame_id)
    try:
        return data.decode("ascii"), name
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise KittiFormatError(f"byte 0x{data[error.start]:02x} is not ASCII", name, line) from None


def _read_map(
    folder: Path, kind: str, frame_id: str, dtype: type[np.generic], image_shape: tuple[int, ...]
) -> NDArray[Any] | None:
    if not _has(folder, kind, frame_id):
        return None
    data, name = _read_bytes(folder, kind, frame_id)
    pixels = images.decode_map(data, name, dtype)
    if pixels.shape != image_shape[:2]:
        raise KittiFormatError(
            f"{pixels.shape[1]} x {pixels.shape[0]} pixels, the image has {image_shape[1]} x {image_shape[0]}", name
        )
    return pixels


def _read_depth(folder: Path, frame_id: str, image_shape: tuple[int, ...]) -> NDArray[np.float32] | None:
    pixels = _read_map(folder, "depth", frame_id, np.uint16, image_shape)
    return None if pixels is None else images.depth_from_pixels(pixels)


def _read_instance(folder: Path, frame_id: str, image_shape: tuple[int, ...]) -> NDArray[np.int32] | None:
    pixels = _read_map(folder, "instance", frame_id, np.uint16, image_shape)
    return None if pixels is None else images.instance_from_pixels(pixels)


def _read_meta(folder: Path, frame_id: str) -> dict[str, Any]:
    data, name = _read_bytes(folder, "meta", frame_id)
    try:
        meta = json_from_text(data, name)
    except FileFormatError as error:
        raise KittiFormatError(error.reason, name, error.line) from None
    if not isinstance(meta, dict):
        raise KittiFormatError(f"expected a JSON object, got {type(meta).__name__}", name, 1)
    return meta
