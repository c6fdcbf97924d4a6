"""Which point is whose: the lasers of all scans together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.datasets.lidar_fit.lines import OUTLIER_M, Line, fit_line, refine, split_mixed
from cadet.datasets.lidar_fit.scans import Points, join, ring_segments
from cadet.datasets.lidar_fit.unordered import find_lines
from cadet.errors import CadetError

_MIN_RING_POINTS: Final = 60
_SURE_POINTS: Final = 30
_PURE: Final = 0.97
_MOSTLY: Final = 0.6
_MIN_FITTING: Final = 0.8
_UNORDERED_FITTING: Final = 0.995
_MAX_SD_DEG: Final = 0.05


@dataclass(frozen=True)
class Rings:
    """The lasers of a sensor, from the top down, and whose each point is."""

    lines: list[Line]
    ring_of_point: list[NDArray[np.intp]]
    """Of each scan: the ring of each point, -1 for none."""
    ordered: bool
    """The files are in the order of the rings, or have their numbers."""


@dataclass(frozen=True)
class _Piece:
    scan: int
    where: slice

    def __len__(self) -> int:
        return int(self.where.stop - self.where.start)


def find_rings(scans: Sequence[Points], names: Sequence[str]) -> Rings:
    """Find the lasers of scans without their numbers.

    Raises:
        CadetError: the points lie on no such lines.
    """
    cuts = [ring_segments(scan) for scan in scans]
    rings = None
    if all(cut is not None for cut in cuts):
        rings = _of_ordered(scans, [cut for cut in cuts if cut is not None])
    if rings is None or _fitting(rings) < _MIN_FITTING:
        lines = sorted(find_lines(join(scans)), key=lambda line: -line.tangent)
        rings = Rings(lines, [_nearest(lines, scan) for scan in scans], ordered=False)
    _check(rings, names)
    return rings


def rings_of_numbers(scans: Sequence[Points], numbers: Sequence[NDArray[np.int64]]) -> Rings | None:
    """Fit the lasers of scans whose points have their numbers, in whatever order; None where they lie on no cones."""
    every, whose = join(scans), np.concatenate(numbers)
    laser, counts = np.unique(whose, return_counts=True)
    found = [(fit_line(every[whose == number]), number) for number in laser[counts >= _MIN_RING_POINTS]]
    found.sort(key=lambda pair: -pair[0].tangent)
    ring_of_point = np.full(len(every), -1, np.intp)
    for ring, (line, number) in enumerate(found):
        its = whose == number
        ring_of_point[its] = np.where(np.abs(line.residual_m(every[its])) < OUTLIER_M, ring, -1)
    ends = np.cumsum([len(scan) for scan in scans])[:-1]
    rings = Rings([line for line, _ in found], np.split(ring_of_point, ends), ordered=True)
    return None if _is_vague(rings) else rings


def _of_ordered(scans: Sequence[Points], cuts: Sequence[list[slice]]) -> Rings:
    pieces = [_Piece(index, segment) for index, cut in enumerate(cuts) for segment in cut]
    # Long pieces determine a laser, short ones are told whose they are.
    pieces.sort(key=lambda piece: (-len(piece), piece.scan, piece.where.start))
    groups: list[list[_Piece]] = []
    lines: list[Line] = []
    for mixed in pieces:
        points = scans[mixed.scan][mixed.where]
        ring = _whose(lines, points, _PURE)
        if ring is not None:
            groups[ring].append(mixed)
            continue
        for where in split_mixed(points, mixed.where.start):
            piece = _Piece(mixed.scan, where)
            points = scans[piece.scan][where]
            ring = _whose(lines, points, _MOSTLY)
            if ring is not None:
                groups[ring].append(piece)
            elif len(points) >= _SURE_POINTS:
                line = fit_line(points)
                if _share(line, points) >= _MOSTLY:
                    groups.append([piece])
                    lines.append(line)
    fitted = []
    for group, line in zip(groups, lines, strict=True):
        if sum(map(len, group)) >= _MIN_RING_POINTS:
            fitted.append((refine(line, join([scans[piece.scan][piece.where] for piece in group])), group))
    fitted.sort(key=lambda pair: -pair[0].tangent)
    ring_of_point = [np.full(len(scan), -1, np.intp) for scan in scans]
    for ring, (_, group) in enumerate(fitted):
        for piece in group:
            ring_of_point[piece.scan][piece.where] = ring
    return Rings([line for line, _ in fitted], ring_of_point, ordered=True)


def _share(line: Line, points: Points) -> float:
    return float((np.abs(line.residual_m(points)) < OUTLIER_M).mean())


def _whose(lines: Sequence[Line], points: Points, least_share: float) -> int | None:
    """Return the line on which at least that share of the points lie, and the most; None if there is none."""
    if not lines:
        return None
    some = points[:: max(1, len(points) // 200)]
    tangents = np.array([line.tangent for line in lines])
    heights = np.array([line.height_m for line in lines])
    shares = (np.abs(some.z_m - heights[:, None] - tangents[:, None] * some.rho_m) < OUTLIER_M).mean(axis=1)
    best = int(np.argmax(shares))
    return best if shares[best] >= least_share else None


def _nearest(lines: Sequence[Line], points: Points) -> NDArray[np.intp]:
    """Return the ring of each point that lies within `OUTLIER_M` of a line."""
    best = np.full(len(points), OUTLIER_M)
    ring = np.full(len(points), -1, np.intp)
    for index, line in enumerate(lines):
        off = np.abs(line.residual_m(points))
        nearer = off < best
        best[nearer], ring[nearer] = off[nearer], index
    return ring


def _fitting(rings: Rings) -> float:
    """Return the share of points that some laser has."""
    return float((np.concatenate(rings.ring_of_point) >= 0).mean())


def _is_vague(rings: Rings) -> bool:
    """Tell whether too few points lie on cones, or no cone is known well."""
    unknown = all(np.degrees(line.tangent_sd) > _MAX_SD_DEG for line in rings.lines)
    return unknown or _fitting(rings) < _MIN_FITTING


def _check(rings: Rings, names: Sequence[str]) -> None:
    fitting = _fitting(rings)
    name = names[0] if len(names) == 1 else f"{len(names)} scans"
    if _is_vague(rings):
        raise CadetError(
            f"{name}: only {100.0 * fitting:.0f} % of the points lie on the cones of lasers on the z axis: expected "
            "scans of one turn in the sensor's own frame, z up; points that a driver moved for the vehicle's motion "
            "need their lasers' numbers (a fifth column, or a field ring) and the order of firing or times"
        )
    if rings.ordered:
        return
    vague = [k for k, line in enumerate(rings.lines) if np.degrees(line.tangent_sd) > _MAX_SD_DEG]
    if vague or fitting < _UNORDERED_FITTING:
        reason = (
            f"the elevation of ring {vague[0]} shows in too few of them"
            if vague
            else f"{100.0 * (1.0 - fitting):.1f} % of them lie on no cone that could be found"
        )
        raise CadetError(
            f"{name}: the points come in no order of rings, and {reason}: write the rings one after the other, or give "
            "more scans with walls in them"
        )
