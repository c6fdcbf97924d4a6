"""Lasers of points in no order: line after line is looked for among the points that are left.

What tells a laser from a patch of ground is its reach: near and far, its points lie within a millimeter of one line.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.datasets.lidar_fit.lines import OUTLIER_M, Line, refine
from cadet.datasets.lidar_fit.scans import Points

_MAX_LINES: Final = 300
_SUBSAMPLE: Final = 16_000
_TRIALS: Final = 1200
_NEAR_M: Final = 0.0015
_CELL: Final = 0.01
"""Of the logarithm of the distance."""
_SHARP: Final = 0.75
_LEAST_CELLS: Final = 3
_HIGHEST_M: Final = 0.6
_HEIGHT_MARGIN_M: Final = 0.12


def find_lines(points: Points) -> list[Line]:
    """Find lasers, the ones that show best first."""
    generator = np.random.Generator(np.random.PCG64(1))
    left = points[points.rho_m > 0.5]
    left = left[generator.permutation(len(left))[: 6 * _SUBSAMPLE]]
    left = left[np.argsort(left.rho_m, kind="stable")]
    lines: list[Line] = []
    sizes: list[int] = []
    failures = 0
    while len(lines) < _MAX_LINES and failures < 8:
        usual = float(np.median(sizes)) if sizes else 60.0
        if len(left) < max(30.0, 0.2 * usual):
            break
        line = _best_of_many(left, lines, generator)
        if line is not None:
            line = refine(line, left[np.abs(line.residual_m(left)) < OUTLIER_M])
        if line is None or not _is_laser(line, left, lines):
            failures += 1
            continue
        is_its = np.abs(line.residual_m(left)) < OUTLIER_M
        lines.append(line)
        sizes.append(int(is_its.sum()))
        left = left[~is_its]
        failures = 0
    return lines


def _cells(points: Points) -> NDArray[np.intp]:
    """Return where each cell of distance begins; the points are sorted by distance."""
    cell = np.floor(np.log(points.rho_m) / _CELL)
    return np.concatenate([[0], np.flatnonzero(np.diff(cell)) + 1])


def _best_of_many(left: Points, lines: list[Line], generator: np.random.Generator) -> Line | None:
    """Return the line through two points near which most cells of distance have some."""
    few = left[np.sort(generator.permutation(len(left))[:_SUBSAMPLE])]
    heights = [line.height_m for line in lines] or [0.0]
    middle = float(np.median(heights))
    order = np.argsort((few.z_m - middle) / few.rho_m, kind="stable")
    reach = np.maximum(200, (len(order) * generator.choice([0.002, 0.01, 0.04], _TRIALS)).astype(np.intp))
    first = generator.integers(0, len(order), _TRIALS)
    second = np.clip(first + generator.integers(-reach, reach + 1), 0, len(order) - 1)
    a, b = order[first], order[second]
    low, high = _height_limits(lines)
    apart = few.rho_m[b] - few.rho_m[a]
    usable = np.abs(apart) > 0.04 * np.minimum(few.rho_m[a], few.rho_m[b])
    tangents = np.where(usable, (few.z_m[b] - few.z_m[a]) / np.where(usable, apart, 1.0), 0.0)
    starts = few.z_m[a] - tangents * few.rho_m[a]
    usable &= (starts > low) & (starts < high)
    tangents, starts = tangents[usable].astype(np.float32), starts[usable].astype(np.float32)
    rho, z, cells = few.rho_m.astype(np.float32), few.z_m.astype(np.float32), _cells(few)
    best, most = None, 0.0
    for begin in range(0, len(tangents), 100):
        t, h = tangents[begin : begin + 100, None], starts[begin : begin + 100, None]
        is_near = np.abs(z - h - t * rho) < _NEAR_M
        counts = np.add.reduceat(is_near, cells, axis=1, dtype=np.intp)
        scores = np.sqrt(counts).sum(axis=1)
        index = int(np.argmax(scores))
        if scores[index] > most:
            most = float(scores[index])
            best = Line(float(t[index, 0]), float(h[index, 0]), np.inf, np.inf)
    return best


def _height_limits(lines: list[Line]) -> tuple[float, float]:
    """Lasers of one sensor leave its axis within some centimeters."""
    if len(lines) < 3:
        return -_HIGHEST_M, _HIGHEST_M
    heights = sorted(line.height_m for line in lines)
    return heights[0] - _HEIGHT_MARGIN_M, heights[-1] + _HEIGHT_MARGIN_M


def _is_laser(line: Line, left: Points, lines: list[Line]) -> bool:
    residual = np.abs(line.residual_m(left))
    its = left[residual < OUTLIER_M]
    if len(its) < 12:
        return False
    is_sharp = float((residual[residual < OUTLIER_M] < _NEAR_M).mean()) > _SHARP
    reach = len(_cells(its))
    # Lasers side by side do not cross where they return points.
    near, far = float(its.rho_m[len(its) // 20]), float(its.rho_m[-1 - len(its) // 20])
    crosses = any(
        (line.height_m + line.tangent * near - other.height_m - other.tangent * near)
        * (line.height_m + line.tangent * far - other.height_m - other.tangent * far)
        <= 0.0
        for other in lines
    )
    return is_sharp and reach >= _LEAST_CELLS and not crosses
