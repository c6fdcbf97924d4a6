"""A drive of KITTI's raw data, synchronized and rectified, as frames without labels."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import as_path
from cadet._util.user_files import names_file
from cadet.errors import KittiFormatError, MissingFileError
from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.files.folder import check_id
from cadet.formats.kitti.files.images import decode_image
from cadet.formats.kitti.files.numbers import number_from_text
from cadet.formats.kitti.files.text import content_lines, text_from_bytes
from cadet.formats.kitti.files.velodyne import points_from_bytes
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.label import Label

_FOLDERS: Final = {"image_2": ("image_02/data", ".png"), "velodyne": ("velodyne_points/data", ".bin")}
_CAMERAS: Final = "calib_cam_to_cam.txt"
_VELO: Final = "calib_velo_to_cam.txt"
_IMU: Final = "calib_imu_to_velo.txt"


def is_raw_drive(folder: Path) -> bool:
    """Tell whether a folder is a drive of KITTI's raw data."""
    return all((folder / place).is_dir() for place, _ in _FOLDERS.values())


class RawDrive:
    """The frames of a drive: images of the left color camera, scans, and the calibration of its day.

    Args:
        folder: of the drive, such as `2011_09_26/2011_09_26_drive_0013_sync`; the three files `calib_*.txt` lie beside
            it or in it. Tracklets are not read.

    Attributes:
        folder: likewise.
        ids: of all frames, such as "0000000012".

    Raises:
        MissingFileError: no such folder, or no image in it.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = as_path("folder", folder)
        place, suffix = _FOLDERS["image_2"]
        self.ids: tuple[str, ...] = tuple(sorted(path.stem for path in (self.folder / place).glob(f"[!.]*{suffix}")))
        if not self.ids:
            raise MissingFileError(f"{self.folder / place}: no images: expected files such as 0000000000{suffix}")

    def has(self, kind: str, frame_id: str) -> bool:
        """Tell whether a frame has a file of one of the kinds `image_2`, `velodyne`, and `calib`."""
        return kind == "calib" or (kind in _FOLDERS and self.path(kind, frame_id).is_file())

    def path(self, kind: str, frame_id: str) -> Path:
        """Return where a frame's `image_2` or `velodyne` lies."""
        place, suffix = _FOLDERS[kind]
        return self.folder / place / f"{frame_id}{suffix}"

    def read_frame(self, frame_id: str, *, has_extras: bool = True) -> Frame:
        """Read a frame; it has no labels and no plane.

        Raises:
            MissingFileError: one of its files is missing.
            KittiFormatError: one is damaged.
        """
        image, scan = (self._read(self.path(kind, check_id(frame_id))) for kind in _FOLDERS)
        names = (f"{place}/{frame_id}{suffix}" for place, suffix in _FOLDERS.values())
        return Frame(decode_image(image, next(names)), points_from_bytes(scan, next(names)), (), self.calib)

    def read_labels(self, frame_id: str) -> tuple[Label, ...]:
        """Refuse to: raw drives have tracklets, which are not read.

        Raises:
            MissingFileError: always.
        """
        raise MissingFileError(
            f"{self.folder}: frame {frame_id}: a raw drive has no labels; its tracklets are not read"
        )

    @cached_property
    def calib(self) -> Calibration:
        """The calibration of the drive's day.

        Raises:
            MissingFileError: one of its files is missing.
            KittiFormatError: one lacks a key, or has malformed numbers.
        """
        cameras, velo, imu = (self._calibration(name) for name in (_CAMERAS, _VELO, _IMU))
        p0, p1, p2, p3 = (_matrix(cameras, f"P_rect_{k:02d}", (3, 4), _CAMERAS) for k in range(4))
        return Calibration(
            P0=p0,
            P1=p1,
            P2=p2,
            P3=p3,
            R0_rect=_matrix(cameras, "R_rect_00", (3, 3), _CAMERAS),
            Tr_velo_to_cam=_rigid(velo, _VELO),
            Tr_imu_to_velo=_rigid(imu, _IMU),
        )

    def _calibration(self, name: str) -> Mapping[str, list[str]]:
        places = (self.folder / name, self.folder.parent / name)
        path = next((path for path in places if path.is_file()), places[1])
        lines = content_lines(text_from_bytes(self._read(path), name), name)
        return {key.strip(): values.split() for key, _, values in (line.partition(":") for _, line in lines)}

    def _read(self, path: Path) -> bytes:
        if not path.is_file():
            raise MissingFileError(f"{path}: no such file")
        with names_file(path):
            return path.read_bytes()


def _rigid(values: Mapping[str, list[str]], file: str) -> NDArray[np.float64]:
    return np.hstack([_matrix(values, "R", (3, 3), file), _matrix(values, "T", (3, 1), file)])


def _matrix(values: Mapping[str, list[str]], key: str, shape: tuple[int, int], file: str) -> NDArray[np.float64]:
    if key not in values:
        raise KittiFormatError(f"missing key {key!r}", file)
    try:
        numbers = np.array([number_from_text(value) for value in values[key]])
    except ValueError as error:
        raise KittiFormatError(f"{key}: {error}", file) from None
    if len(numbers) != shape[0] * shape[1]:
        raise KittiFormatError(f"{key}: expected {shape[0] * shape[1]} numbers, got {len(numbers)}", file)
    return numbers.reshape(shape)
