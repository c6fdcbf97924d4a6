"""Each laser's own range error, from flat places that several lasers see: walls, sides of vehicles, roads.

A laser whose ranges are off by o puts its points o n.d off a plane of normal n, for beams along d. The planes of all
patches and the lasers' errors are one linear least-squares problem, weighted anew for outliers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.datasets.lidar_fit.rings import Rings
from cadet.datasets.lidar_fit.scans import Points

Array = NDArray[np.float64]

_PATCHES_M: Final = (1.0, 2.0, 4.0)
"""Lasers that stand far apart meet on large ones only."""
_NEAREST_M, _FARTHEST_M = 2.0, 30.0
_LEAST_POINTS: Final = 5
"""Of a laser on a patch."""
_LEAST_LASERS: Final = 4
_THICKEST_M: Final = 0.05
"""Standard deviation of the points of a flat patch, their lasers' errors included."""
_NARROWEST_M: Final = 0.15
_ROUGHEST_M: Final = 0.02
"""Standard deviation of a laser's points about their line on a flat patch, along the beam: hedges have more."""
_UNEVEN_M: Final = 0.004
"""What flat surfaces are uneven by from laser to laser."""
_LEAN: Final = 0.01
"""Standard deviation of walls' slopes from upright, with the sensor's own: it tells a trend of errors downward."""
_UPRIGHT: Final = 0.05
"""Walls' normals rise or fall by less: sides of vehicles, which lean inward, by more."""
_USUAL_M: Final = 0.03
"""Standard deviation of errors before anything is known of them."""
_KNOWN_M: Final = 0.01
"""Larger standard errors make no number."""
_ROUNDS: Final = 6


@dataclass(frozen=True)
class RangeOffsets:
    """By how much each laser measures too far, their mean taken for 0.

    Attributes:
        offset_m: (K,); 0 where too few flat patches tell.
        sd_m: (K,) standard errors.
        num_patches: how many flat patches were found.
    """

    offset_m: Array
    sd_m: Array
    num_patches: int

    @property
    def is_known(self) -> NDArray[np.bool_]:
        """(K,): whether patches tell a laser's error."""
        known: NDArray[np.bool_] = self.sd_m < _KNOWN_M
        return known


@dataclass(frozen=True)
class _Patch:
    """A flat place, and what lasers see of it in the mean of their points: arrays (M,)."""

    laser: NDArray[np.intp]
    height_m: Array
    """Over the patch's first plane."""
    basis: Array
    """(M, 3): 1, and the place in the plane, level and upward."""
    effect: Array
    """n.d: the change of height with the laser's range."""
    variance_m2: Array
    lean: tuple[float, float]
    """The normal's z, and its change with the upward slope; 0 where nothing says how it should be."""


def fit_range_offsets(scans: Sequence[Points], rings: Rings) -> RangeOffsets:
    """Fit the lasers' range errors."""
    tangents = np.array([line.tangent for line in rings.lines])
    patches = [
        patch
        for scan, ring in zip(scans, rings.ring_of_point, strict=True)
        for size_m in _PATCHES_M
        for patch in _patches(scan, ring, tangents, size_m)
    ]
    return _solve(patches, len(tangents))


def _patches(scan: Points, ring: NDArray[np.intp], tangents: Array, size_m: float) -> list[_Patch]:
    """Find the flat places of one scan among the cells of a grid."""
    is_used = (ring >= 0) & (scan.range_m > _NEAREST_M) & (scan.range_m < _FARTHEST_M)
    scan, ring = scan[is_used], ring[is_used]
    azimuth = np.radians(scan.azimuth_deg)
    heading = np.column_stack([np.cos(azimuth), np.sin(azimuth)])
    places = np.column_stack([scan.rho_m[:, None] * heading, scan.z_m])
    tangent = tangents[ring]
    beams = np.column_stack([heading, tangent]) / np.sqrt(1.0 + tangent**2)[:, None]
    # Around the origin lies the middle of a cell, so that cells of different sizes end at different places.
    cell = np.rint(places / size_m).astype(np.int64) @ [1 << 40, 1 << 20, 1]
    order = np.lexsort((ring, cell))
    found = []
    for its in np.split(order, np.flatnonzero(np.diff(cell[order])) + 1):
        if len(its) >= _LEAST_LASERS * _LEAST_POINTS:
            patch = _patch(places[its], beams[its], ring[its])
            if patch is not None:
                found.append(patch)
    return found


def _patch(places: Array, beams: Array, ring: NDArray[np.intp]) -> _Patch | None:
    """Return what points of rising rings make of a place; None where it is no wall or ground, or not flat."""
    lasers, first, counts = np.unique(ring, return_index=True, return_counts=True)
    is_sure = counts >= _LEAST_POINTS
    if is_sure.sum() < _LEAST_LASERS:
        return None
    places = places - places.mean(axis=0)
    spread, axes = np.linalg.eigh(np.cov(places.T))
    normal = axes[:, 0]
    is_wall, is_ground = abs(normal[2]) < 0.25, abs(normal[2]) > 0.95
    if spread[0] > _THICKEST_M**2 or spread[1] < _NARROWEST_M**2 or not (is_wall or is_ground):
        return None
    level = np.array([normal[1], -normal[0], 0.0]) / np.hypot(*normal[:2]) if is_wall else np.array([1.0, 0.0, 0.0])
    upward = np.cross(level, normal)
    values = np.column_stack([places @ normal, places @ level, places @ upward, beams @ normal])
    means = np.add.reduceat(values, first) / counts[:, None]
    height_m, along_m = (values - np.repeat(means, counts, axis=0))[:, :2].T
    rough_m = float(np.std(height_m - along_m * (along_m @ height_m) / max(along_m @ along_m, 1e-9)))
    means, lasers, counts = means[is_sure], lasers[is_sure], counts[is_sure]
    if rough_m > _ROUGHEST_M * np.abs(means[:, 3]).mean():
        return None
    return _Patch(
        laser=lasers,
        height_m=means[:, 0],
        basis=np.column_stack([np.ones(len(lasers)), means[:, 1:3]]),
        effect=means[:, 3],
        variance_m2=_UNEVEN_M**2 + rough_m**2 / counts,
        lean=(float(normal[2]), float(upward[2]) if abs(normal[2]) < _UPRIGHT else 0.0),
    )


def _solve(patches: Sequence[_Patch], num_lasers: int) -> RangeOffsets:
    if not patches:
        return RangeOffsets(np.zeros(num_lasers), np.full(num_lasers, _USUAL_M), 0)
    patch = np.repeat(np.arange(len(patches)), [len(p.laser) for p in patches])
    laser, height_m, basis, effect, variance_m2 = (
        np.concatenate([getattr(p, key) for p in patches])
        for key in ("laser", "height_m", "basis", "effect", "variance_m2")
    )
    normal_z, change = np.array([p.lean for p in patches]).T
    # Hardly anything is known of slopes, but that walls are upright.
    prior, pull = np.zeros((len(patches), 3, 3)), np.zeros((len(patches), 3))
    prior[:, 1, 1] = prior[:, 2, 2] = 1.0
    prior[:, 2, 2] += (change / _LEAN) ** 2
    pull[:, 2] = normal_z * change / _LEAN**2
    weight, offset_m, covariance = np.ones(len(laser)), np.zeros(num_lasers), np.eye(num_lasers)
    for _ in range(_ROUNDS):
        w = weight / variance_m2
        square, right, mixed = prior.copy(), pull.copy(), np.zeros((len(patches), num_lasers, 3))
        np.add.at(square, patch, w[:, None, None] * basis[:, :, None] * basis[:, None, :])
        np.add.at(right, patch, (w * height_m)[:, None] * basis)
        mixed[patch, laser] = (w * effect)[:, None] * basis
        # The planes are eliminated.
        share = np.linalg.solve(square, np.concatenate([mixed.transpose(0, 2, 1), right[:, :, None]], axis=2))
        normal = np.diag(np.bincount(laser, w * effect**2, num_lasers) + _USUAL_M**-2)
        normal -= np.tensordot(mixed, share[:, :, :-1], ([0, 2], [0, 1]))
        vector = np.bincount(laser, w * effect * height_m, num_lasers)
        vector -= np.tensordot(mixed, share[:, :, -1], ([0, 2], [0, 1]))
        covariance = np.linalg.inv(normal)
        offset_m = covariance @ vector
        plane = share[:, :, -1] - share[:, :, :-1] @ offset_m
        left_m = height_m - effect * offset_m[laser] - (basis * plane[patch]).sum(axis=1)
        weight = 1.0 / (1.0 + left_m**2 / (4.0 * variance_m2))
    # What all lasers share is no patch's to tell.
    centering = np.eye(num_lasers) - 1.0 / num_lasers
    found = RangeOffsets(offset_m, np.sqrt(np.diag(centering @ covariance @ centering)), len(patches))
    known = found.is_known
    return replace(found, offset_m=np.where(known, offset_m - (offset_m[known].mean() if known.any() else 0.0), 0.0))
