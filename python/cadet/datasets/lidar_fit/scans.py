"""Scans to fit a sensor to: found, read, and cut into rings."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.errors import CadetError, MissingFileError
from cadet.formats.scan_files import SUFFIXES, read_scan

_MIN_POINTS: Final = 1000
_NO_RETURN_M: Final = 0.1
"""Rows at the origin, or that were moved from there, are what some drivers write for no return."""
_BACKWARD_DEG: Final = 1.0
"""Azimuths of one ring fall back by less, whatever rounding and the lasers' own corrections do."""
_COLUMN_STEP_DEG: Final = 0.3
_SAME_LASER_DEG: Final = 0.1
_FEWEST_LASERS: Final = 8
_MOST_LASERS: Final = 128
_MAX_RINGS: Final = 300
_SCAN_FOLDERS: Final = (
    "velodyne",
    "training/velodyne",
    "object/training/velodyne",
    "training/velodyne/[0-9]*",
    "samples/LIDAR_TOP",
    "velodyne_points/data",
    "*/velodyne_points/data",
    "*/*/velodyne_points/data",
)
"""Where scans lie in KITTI's object, tracking and raw sets, in nuScenes', and in cadet's of these formats."""
_MAX_PLACE_M: Final = 10_000.0
"""No LIDAR sees farther; sums of squares of much larger numbers overflow."""


@dataclass(frozen=True)
class Points:
    """Points of a scan: distance from the vertical axis, height, range, azimuth in degrees, intensity; arrays (N,)."""

    rho_m: NDArray[np.float64]
    z_m: NDArray[np.float64]
    range_m: NDArray[np.float64]
    azimuth_deg: NDArray[np.float64]
    intensity: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.z_m)

    def __getitem__(self, which: slice | NDArray[np.intp] | NDArray[np.bool_]) -> Points:
        return Points(
            self.rho_m[which], self.z_m[which], self.range_m[which], self.azimuth_deg[which], self.intensity[which]
        )


def join(parts: Sequence[Points]) -> Points:
    """Return the points of all parts."""
    keys = ("rho_m", "z_m", "range_m", "azimuth_deg", "intensity")
    return Points(*(np.concatenate([getattr(part, key) for part in parts]) for key in keys))


@dataclass(frozen=True)
class Turn:
    """A scan as its file has it.

    Attributes:
        name: the file's.
        xyz: (N, 3), meters.
        intensity: (N,), as the file has it: only how many are 0 matters.
        ring: (N,) the lasers' numbers; None where neither the file nor the order of its rows tells them.
        time: (N,) in any unit; None where the file has none.
        num_rows: points in the file, with those that stand for no return.
    """

    name: str
    xyz: NDArray[np.float64]
    intensity: NDArray[np.float64]
    ring: NDArray[np.int64] | None
    time: NDArray[np.float64] | None
    num_rows: int

    def points(self) -> tuple[Points, NDArray[np.bool_]]:
        """Return the points that returned, and which those are."""
        range_m = np.linalg.norm(self.xyz, axis=1)
        is_return = range_m > _NO_RETURN_M
        (x, y, z), range_m = self.xyz[is_return].T, range_m[is_return]
        azimuth_deg = np.degrees(np.arctan2(y, x)) % 360.0
        return Points(np.hypot(x, y), z, range_m, azimuth_deg, self.intensity[is_return]), is_return


def find_scans(paths: Sequence[str | Path]) -> list[Path]:
    """List the scans that files and folders name; of a dataset's folder those of `_SCAN_FOLDERS`.

    Raises:
        MissingFileError: a path is missing, or a folder holds no scan.
    """
    found: list[Path] = []
    for path in map(Path, paths):
        if path.is_file():
            found.append(path)
            continue
        if not path.is_dir():
            raise MissingFileError(f"{str(path)!r}: no such file or folder")
        groups = [[path], *(sorted(path.glob(folder)) for folder in _SCAN_FOLDERS)]
        files = next((files for group in groups if (files := [file for one in group for file in _scans_in(one)])), [])
        if not files:
            kinds = ", ".join(SUFFIXES[:-1]) + f" or {SUFFIXES[-1]}"
            raise MissingFileError(f"{str(path)!r}: no {kinds} files in it, nor in {', '.join(_SCAN_FOLDERS)}")
        found += files
    if not found:
        raise CadetError("no scans given")
    return found


def _scans_in(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and path.is_file())


def read_turn(path: Path) -> Turn:
    """Read a scan of one turn.

    Raises:
        CadetError: a file that cannot be read, with places beyond 10 km, or too few points to tell anything.
    """
    scan = read_scan(path)
    xyz = scan.points_velo[:, :3].astype(np.float64)
    is_near = np.abs(xyz).max(axis=1, initial=0.0) <= _MAX_PLACE_M
    if not is_near.all():
        raise CadetError(f"{path.name}: point {int(np.argmin(is_near))} is farther away than {_MAX_PLACE_M:g} m")
    turn = Turn(
        path.name,
        xyz,
        scan.points_velo[:, 3].astype(np.float64),
        rings_in_turn(xyz) if scan.ring is None else scan.ring,
        scan.time,
        len(xyz) + scan.num_left_out,
    )
    num_points = len(turn.points()[0])
    if num_points < _MIN_POINTS:
        raise CadetError(f"{path.name}: {num_points} points, at least {_MIN_POINTS} are needed")
    return turn


def rings_in_turn(xyz: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """Number the lasers of points (N, 3) that fire in turn, where rows for no return are kept; None where none do.

    Elevations change from row to row, and come again with every column of as many rows as there are lasers.
    """
    if len(xyz) < _MIN_POINTS:
        return None
    elevation_deg = np.degrees(np.arctan2(xyz[:, 2], np.hypot(xyz[:, 0], xyz[:, 1])))
    if np.median(np.abs(np.diff(elevation_deg))) < _COLUMN_STEP_DEG:
        return None
    for lasers in range(_FEWEST_LASERS, _MOST_LASERS + 1):
        if len(xyz) % lasers == 0:
            change_deg = np.abs(elevation_deg[lasers:] - elevation_deg[:-lasers])
            if len(change_deg) > lasers and np.median(change_deg) < _SAME_LASER_DEG:
                return np.arange(len(xyz)) % lasers
    return None


def ring_segments(points: Points) -> list[slice] | None:
    """Cut a ring-major scan where the azimuth starts anew; None if its order shows no rings."""
    azimuth = points.azimuth_deg
    step = (np.diff(azimuth) + 180.0) % 360.0 - 180.0
    if np.median(step) < 0.0:
        azimuth = -azimuth % 360.0
    cuts = None
    # A turn may begin anywhere: where it is cut in the right place, fewest pieces come of it.
    for start in (0.0, azimuth[0] - 0.25, 90.0, 180.0, 270.0):
        found = np.flatnonzero(np.diff((azimuth - start) % 360.0) < -_BACKWARD_DEG) + 1
        if cuts is None or len(found) < len(cuts):
            cuts = found
    assert cuts is not None
    if len(cuts) >= _MAX_RINGS:
        return None
    edges = [0, *cuts.tolist(), len(azimuth)]
    return [slice(a, b) for a, b in itertools.pairwise(edges)]
