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
from cadet.kitti.velodyne import points_from_bytes

_MIN_POINTS: Final = 1000
_BACKWARD_DEG: Final = 1.0
"""Azimuths of one ring fall back by less, whatever rounding and the lasers' own corrections do."""
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


def find_scans(paths: Sequence[str | Path]) -> list[Path]:
    """List the `.bin` files that files and folders name; of a dataset's folder those of its scans.

    Raises:
        MissingFileError: a path is missing, or a folder holds no `.bin` file.
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
            raise MissingFileError(f"{str(path)!r}: no .bin files in it, nor in {', '.join(_SCAN_FOLDERS)}")
        found += files
    if not found:
        raise CadetError("no scans given")
    return found


def _scans_in(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.bin"))


def read_scan(path: Path) -> Points:
    """Read a scan of float32 x, y, z, intensity.

    Raises:
        CadetError: the file is cut off, holds NaN, infinity or places beyond 10 km, or too few points to tell anything.
    """
    points = points_from_bytes(path.read_bytes(), path.name).astype(np.float64)
    is_near = np.abs(points[:, :3]).max(axis=1, initial=0.0) <= _MAX_PLACE_M
    if not is_near.all():
        raise CadetError(f"{path.name}: point {int(np.argmin(is_near))} is farther away than {_MAX_PLACE_M:g} m")
    points = points[np.linalg.norm(points[:, :3], axis=1) > 0.0]
    if len(points) < _MIN_POINTS:
        raise CadetError(f"{path.name}: {len(points)} points, at least {_MIN_POINTS} are needed")
    x, y, z, intensity = points.T
    return Points(
        rho_m=np.hypot(x, y),
        z_m=z,
        range_m=np.linalg.norm(points[:, :3], axis=1),
        azimuth_deg=np.degrees(np.arctan2(y, x)) % 360.0,
        intensity=intensity,
    )


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
