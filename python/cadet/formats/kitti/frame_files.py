"""A frame from its files' bytes, wherever they lie: in a folder, or in an archive."""

from __future__ import annotations

import glob
import os
import stat
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from cadet._util.plain_text import json_from_text
from cadet.errors import FileFormatError, KittiFormatError, MissingFileError
from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.files import images
from cadet.formats.kitti.files.dialects import accept
from cadet.formats.kitti.files.folder import (
    OF_CAMERA,
    SUFFIXES,
    camera_kind,
    display_name,
    found_path,
    kinds_in,
    suffix_of,
)
from cadet.formats.kitti.files.planes import plane_from_text
from cadet.formats.kitti.files.text import text_from_bytes
from cadet.formats.kitti.files.vector_images import flow_from_bytes, vectors_from_bytes
from cadet.formats.kitti.files.velodyne import points_from_bytes
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.label import Label, labels_from_text


class FrameFiles(Protocol):
    """A store of frames' files. Kinds are those of `cadet.formats.kitti.files.folder.is_kind`."""

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of files that frames may have, in the order in which they are listed."""

    def has(self, kind: str, frame_id: str) -> bool:
        """Tell whether anything stands in a file's place, readable or not."""

    def has_kind(self, kind: str) -> bool:
        """Tell whether frames of this store have such files."""

    def read(self, kind: str, frame_id: str) -> tuple[bytes, str]:
        """Return a file's bytes, and its name for messages.

        Raises:
            MissingFileError: there is none.
            FileFormatError: it is no file, or its store is damaged.
        """


@dataclass(frozen=True)
class FolderFiles:
    """The files of a folder that holds `calib` and its fellows."""

    folder: Path

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of files that frames may have, further cameras' last."""
        return kinds_in(self.folder)

    def has(self, kind: str, frame_id: str) -> bool:
        """Tell whether anything stands in a file's place."""
        # Not is_file: a folder or a broken link in a file's place is to be found, not passed over.
        return os.path.lexists(found_path(self.folder, kind, frame_id))

    def has_kind(self, kind: str) -> bool:
        """Tell whether there is such a folder."""
        return (self.folder / kind).is_dir()

    def read(self, kind: str, frame_id: str) -> tuple[bytes, str]:
        """Return a file's bytes, and its name for messages.

        Raises:
            MissingFileError: there is none.
            KittiFormatError: something else stands in its place.
        """
        path = found_path(self.folder, kind, frame_id)
        try:
            # Opening a pipe would wait for its writer.
            if not stat.S_ISREG(path.stat().st_mode):
                raise KittiFormatError("not a regular file", display_name(path))
            return path.read_bytes(), display_name(path)
        except FileNotFoundError:
            others = sorted(other.name for other in path.parent.glob(f"{glob.escape(frame_id)}.*"))
            beside = f"; {others[0]} is there: save it as {path.name}" if others else ""
            raise MissingFileError(f"{path}: no such file{beside}") from None


@dataclass(frozen=True)
class CameraFiles:
    """The files of frames as a further camera saw them: its own, and those that all share, such as scans."""

    files: FrameFiles
    camera: str

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of files that one camera's frames may have."""
        return tuple(SUFFIXES)

    def has(self, kind: str, frame_id: str) -> bool:
        """Tell whether anything stands in a file's place; planes and `meta` are the first camera's."""
        return kind not in ("planes", "meta") and self.files.has(self._kind(kind), frame_id)

    def has_kind(self, kind: str) -> bool:
        """Tell whether there is such a folder."""
        return self.files.has_kind(self._kind(kind))

    def read(self, kind: str, frame_id: str) -> tuple[bytes, str]:
        """Return a file's bytes, and its name for messages: as the store of all cameras does."""
        return self.files.read(self._kind(kind), frame_id)

    def _kind(self, kind: str) -> str:
        return camera_kind(self.camera, kind) if kind in OF_CAMERA else kind


def frame_from_files(files: FrameFiles, frame_id: str, *, has_extras: bool = True) -> Frame:
    """Read one frame: see `cadet.kitti.read_frame`.

    Raises:
        MissingFileError: a file that its fellows have is missing.
        KittiFormatError: a damaged file, named with line and reason.
    """
    image = image_from_files(files, frame_id)
    points_velo = points_from_bytes(*files.read("velodyne", frame_id))
    calib = Calibration.from_text(*read_text(files, "calib", frame_id))
    extras: dict[str, Any] = {}
    if has_extras:
        extras = {kind: read_map(files, kind, frame_id, image.shape) for kind in MAPS}
        extras["meta"] = meta_from_files(files, frame_id) if files.has("meta", frame_id) else None
    return Frame(
        image=image,
        points_velo=points_velo,
        labels=labels_from_files(files, frame_id) if files.has_kind("label_2") else (),
        calib=calib,
        plane=plane_from_text(*read_text(files, "planes", frame_id)) if files.has("planes", frame_id) else None,
        **extras,
    )


def image_from_files(files: FrameFiles, frame_id: str, kind: str = "image_2") -> NDArray[np.uint8]:
    """Read a camera's image: (H, W, 3) RGB.

    Raises:
        MissingFileError: there is none.
        KittiFormatError: as `images.decode_image` refuses it.
    """
    data, name = files.read(kind, frame_id)
    if not name.endswith(suffix_of(kind)):
        accept("image-suffix", f"{Path(name).suffix} is read where KITTI has {suffix_of(kind)}", name)
    return images.decode_image(data, name)


def labels_from_files(files: FrameFiles, frame_id: str) -> tuple[Label, ...]:
    """Read the labels of a frame.

    Raises:
        MissingFileError: there is no label file.
        KittiFormatError: a malformed line.
    """
    return labels_from_text(*read_text(files, "label_2", frame_id))


def read_text(files: FrameFiles, kind: str, frame_id: str) -> tuple[str, str]:
    """Return a file's text and its name.

    Raises:
        MissingFileError: there is none.
        KittiFormatError: it is not ASCII.
    """
    data, name = files.read(kind, frame_id)
    return text_from_bytes(data, name), name


def read_map(files: FrameFiles, kind: str, frame_id: str, image_shape: tuple[int, ...]) -> NDArray[Any] | None:
    """Read a map of the image, of a kind of `MAPS`; None where there is none.

    Raises:
        KittiFormatError: a damaged one, or one of another size than the image.
    """
    if not files.has(kind, frame_id):
        return None
    data, name = files.read(kind, frame_id)
    values = MAPS[kind](data, name)
    if values.shape[:2] != image_shape[:2]:
        raise KittiFormatError(
            f"{values.shape[1]} x {values.shape[0]} pixels, the image has {image_shape[1]} x {image_shape[0]}", name
        )
    return values


MAPS: Final[dict[str, Callable[[bytes, str], NDArray[Any]]]] = {
    "depth": lambda data, name: images.depth_from_pixels(images.decode_map(data, name, np.uint16)),
    "instance": lambda data, name: images.instance_from_pixels(images.decode_map(data, name, np.uint16)),
    "semantic": lambda data, name: images.decode_map(data, name, np.uint8),
    "normals": lambda data, name: vectors_from_bytes(data, name, "normals"),
    "optical_flow": flow_from_bytes,
    "scene_flow": lambda data, name: vectors_from_bytes(data, name, "scene_flow"),
    "radiance": lambda data, name: vectors_from_bytes(data, name, "radiance"),
}
"""The maps of an image, and what decodes each from its file's bytes and name."""


def meta_from_files(files: FrameFiles, frame_id: str) -> dict[str, Any]:
    """Read what else the generator knew.

    Raises:
        KittiFormatError: not a JSON object.
    """
    data, name = files.read("meta", frame_id)
    try:
        meta = json_from_text(data, name)
    except FileFormatError as error:
        raise KittiFormatError(error.reason, name, error.line) from None
    if not isinstance(meta, dict):
        raise KittiFormatError(f"expected a JSON object, got {type(meta).__name__}", name, 1)
    return meta
