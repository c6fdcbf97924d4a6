"""Whole frames of a KITTI folder: reading, writing, iterating."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import as_path, check_flag, check_kind, is_one_of, shown
from cadet._util.user_files import read_file
from cadet.errors import CadetError, FrameExistsError, MissingFileError
from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.files import images
from cadet.formats.kitti.files.folder import (
    SUFFIXES,
    camera_names,
    check_id,
    display_name,
    file_path,
    frame_ids,
    read_suffixes,
    sample_folder,
    split_folder,
    write_whole,
)
from cadet.formats.kitti.files.planes import plane_from_text, text_from_plane
from cadet.formats.kitti.files.text import content_lines, text_from_bytes
from cadet.formats.kitti.files.vector_images import bytes_from_flow, bytes_from_vectors
from cadet.formats.kitti.files.velodyne import bytes_from_points, points_from_bytes
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.frame_files import (
    MAPS,
    CameraFiles,
    FolderFiles,
    FrameFiles,
    frame_from_files,
    image_from_files,
    meta_from_files,
    read_map,
    read_text,
)
from cadet.formats.kitti.image_sets import list_frame, other_split, read_image_set
from cadet.formats.kitti.label import Label, labels_from_text, text_from_labels


def read_frame(root: str | Path, frame_id: str | int, *, has_extras: bool = True, camera: str | None = None) -> Frame:
    """Read one frame of a KITTI folder, real or generated.

    Args:
        root: the folder that holds `training`, or one that holds `calib` and its fellows itself.
        frame_id: the name of its files without suffix; a number means six digits.
        has_extras: read what KITTI's own frames lack too: maps of the image and meta; else they are None.
        camera: the name of a further camera of the rig (`cadet-gen --write cameras`): the frame as it sees it, without
            plane and meta; None for the first one.

    Returns:
        The frame; labels are empty where the set has none, everything else optional is None where nothing was written.

    Raises:
        MissingFileError: no KITTI folder, no such frame, or a file that its fellows have is missing.
        KittiFormatError: a damaged file, named with line and reason.
    """
    check_flag("", "has_extras", has_extras)
    folder = sample_folder(root)
    files: FrameFiles = FolderFiles(folder)
    if camera is not None:
        if not is_one_of(camera, camera_names(folder)):
            known = ", ".join(camera_names(folder)) or "none but the first"
            raise MissingFileError(f"{folder}: no camera {shown(camera)}; there are {known}")
        files = CameraFiles(files, camera)
    return frame_from_files(files, check_id(frame_id), has_extras=has_extras)


def read_labels(path: str | Path, frame_id: str | int | None = None) -> tuple[Label, ...]:
    """Read only labels, or a detector's results.

    Args:
        path: their file, such as `out/training/label_2/000012.txt`; with a `frame_id` the KITTI folder, such as `out`.
        frame_id: as for `read_frame`.

    Raises:
        MissingFileError: there is no such file.
        KittiFormatError: a malformed line.
    """
    return labels_from_text(*_text_of(path, "label_2", frame_id))


def read_calib(path: str | Path, frame_id: str | int | None = None) -> Calibration:
    """Read only a calibration.

    Args:
        path: its file; with a `frame_id` the KITTI folder.
        frame_id: as for `read_frame`.

    Raises:
        MissingFileError: there is no such file.
        KittiFormatError: a missing key or malformed number.
    """
    return Calibration.from_text(*_text_of(path, "calib", frame_id))


def _text_of(path: str | Path, kind: str, frame_id: str | int | None) -> tuple[str, str]:
    if frame_id is not None:
        return read_text(FolderFiles(sample_folder(path)), kind, check_id(frame_id))
    file = as_path("path", path)
    if file.is_dir():
        raise MissingFileError(f"{file}: a folder: name a file of {kind}, or say which frame of the folder is meant")
    name = display_name(file)
    return text_from_bytes(read_file(file), name), name


def read_meta(root: str | Path, frame_id: str | int) -> dict[str, Any] | None:
    """Read only what else the generator knew of a frame; None where nothing was written, as of KITTI's own.

    Raises:
        KittiFormatError: not a JSON object.
    """
    files, frame_id = FolderFiles(sample_folder(root)), check_id(frame_id)
    return meta_from_files(files, frame_id) if files.has("meta", frame_id) else None


def check_files(root: str | Path, frame_id: str | int) -> list[tuple[str, CadetError | OSError]]:
    """List what is wrong with each file of a frame: its folder, and the error that reading it raises.

    A label file is read line by line, so it may give several.

    Raises:
        MissingFileError: no KITTI folder.
    """
    return errors_of_files(FolderFiles(sample_folder(root)), check_id(frame_id))


def errors_of_files(files: FrameFiles, frame_id: str) -> list[tuple[str, CadetError | OSError]]:
    """List what is wrong with each file of a frame, wherever they lie: as `check_files`."""
    readers: dict[str, Callable[[], object]] = {
        "image_2": lambda: image_from_files(files, frame_id),
        "velodyne": lambda: points_from_bytes(*files.read("velodyne", frame_id)),
        "calib": lambda: Calibration.from_text(*read_text(files, "calib", frame_id)),
    }
    optional: dict[str, Callable[[], object]] = {
        "planes": lambda: plane_from_text(*read_text(files, "planes", frame_id)),
        "meta": lambda: meta_from_files(files, frame_id),
    }
    readers |= {kind: reader for kind, reader in optional.items() if files.has(kind, frame_id)}
    wrong = [(kind, error) for kind, reader in readers.items() if (error := _error_of(reader)) is not None]
    is_image_read = all(kind != "image_2" for kind, _ in wrong)
    if is_image_read:
        shape = image_from_files(files, frame_id).shape
        maps = {kind: partial(read_map, files, kind, frame_id, shape) for kind in MAPS}
        wrong += [(kind, error) for kind, reader in maps.items() if (error := _error_of(reader)) is not None]
    return wrong + _label_errors(files, frame_id)


def encode_frame(frame: Frame) -> dict[str, bytes]:
    """Return the bytes of a frame's files by folder; what is None has no entry.

    Args:
        frame: the frame.

    Raises:
        CadetError: what the format cannot hold: an instance id above 65534, a `meta` that is not JSON.
    """
    check_kind("", "frame", frame, Frame)
    contents = {"image_2": images.encode_png(frame.image)}
    contents |= encode_facts(frame.points_velo, frame.calib, frame.labels, frame.plane)
    if frame.meta is not None:
        contents["meta"] = encode_meta(frame.meta)
    return contents | encode_maps({kind: getattr(frame, kind) for kind in MAPS})


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


def encode_maps(maps: Mapping[str, NDArray[Any] | None]) -> dict[str, bytes]:
    """Return the bytes of those maps that are not None, by folder.

    Raises:
        CadetError: an instance id above 65534.
    """
    return {kind: _ENCODE[kind](values) for kind, values in maps.items() if values is not None}


_ENCODE: Final[dict[str, Callable[[NDArray[Any]], bytes]]] = {
    "depth": lambda depth: images.encode_png(images.pixels_from_depth(depth)),
    "instance": lambda instance: images.encode_png(images.pixels_from_instance(instance)),
    "semantic": images.encode_png,
    "normals": lambda normals: bytes_from_vectors(normals, "normals"),
    "optical_flow": bytes_from_flow,
    "scene_flow": lambda scene_flow: bytes_from_vectors(scene_flow, "scene_flow"),
    "radiance": lambda radiance: bytes_from_vectors(radiance, "radiance"),
}


def encode_meta(meta: dict[str, Any]) -> bytes:
    """Return the bytes of a `meta` file.

    Raises:
        CadetError: what JSON cannot hold.
    """
    try:
        return (json.dumps(meta, indent=1, allow_nan=False) + "\n").encode("ascii")
    except (TypeError, ValueError) as error:
        raise CadetError(f"meta: invalid JSON: {error}") from None


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
        frame_id: the name of its files without suffix; a number means six digits.
        frame: the frame.
        split: "train" or "val": the list that names the frame, besides `trainval`; lists that are missing are made.
            None leaves the lists alone.
        overwrite: replace a frame that is there; its files that `frame` lacks are removed.

    Raises:
        FrameExistsError: the frame is there and `overwrite` is not set.
        CadetError: what the format cannot hold: an instance id above 65534, a `meta` that is not JSON; an unknown
            split, or a frame that the other split lists.
    """
    folder = as_path("root", root) / "training"
    frame_id = check_id(frame_id)
    check_flag("", "overwrite", overwrite)
    if split is not None:
        other_split(root, frame_id, split)
    present = [
        path
        for kind in SUFFIXES
        for suffix in read_suffixes(kind)
        if (path := file_path(folder, kind, frame_id, suffix)).exists()
    ]
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
        root: the folder that holds `training` and `ImageSets`, or `training` itself.
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

    def has(self, kind: str, frame_id: str) -> bool:
        """Tell whether a frame has a file of one kind (a key of `cadet.formats.kitti.files.folder.SUFFIXES`)."""
        return FolderFiles(self.folder).has(kind, frame_id)

    def read_frame(self, frame_id: str, *, has_extras: bool = True) -> Frame:
        """Read a frame of the folder: see `read_frame`."""
        return read_frame(self.folder, frame_id, has_extras=has_extras)

    def read_labels(self, frame_id: str) -> tuple[Label, ...]:
        """Read only the labels of a frame of the folder: see `read_labels`."""
        return read_labels(self.folder, frame_id)

    def __repr__(self) -> str:
        return f"Dataset({str(self.root)!r}, split={self.split!r}): {len(self)} frames"


def _error_of(reader: Callable[[], object]) -> CadetError | OSError | None:
    try:
        reader()
    except (CadetError, OSError) as error:
        return error
    return None


def _label_errors(files: FrameFiles, frame_id: str) -> list[tuple[str, CadetError | OSError]]:
    if not files.has_kind("label_2"):
        return []
    try:
        text, name = read_text(files, "label_2", frame_id)
    except (CadetError, OSError) as error:
        return [("label_2", error)]
    errors = [_error_of(partial(Label.from_line, line, name, number)) for number, line in content_lines(text)]
    return [("label_2", error) for error in errors if error is not None]
