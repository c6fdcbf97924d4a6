"""Objects as the LIDAR sees them: what they hide, and what hides them.

Directions are (x / z, y / z) from the LIDAR, in axes of the cam frame, so that outlines of straight edges are straight.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

HALF_BEAM: Final = 0.0035
"""A fifth of a degree: half the angle between two beams of KITTI's LIDAR, by which an outline is wider than points."""
BEHIND_M: Final = 0.5
"""A point is hidden if it is this much farther than another in its direction."""
_CELL: Final = (0.004, 0.008)
"""Of directions in which one thing hides another: two beams across and one down."""


@dataclass(frozen=True, eq=False)
class Outline:
    """An object as the LIDAR sees it.

    Attributes:
        directions: (K, 2) of its points.
        range_m: (K,) of its points.
        edges: (E, 3) [a, b, c] of the convex hull: a x + b y <= c inside.
    """

    directions: NDArray[np.float64]
    range_m: NDArray[np.float64]
    edges: NDArray[np.float64]

    @classmethod
    def of(cls, points_scan: NDArray[np.float64]) -> Outline:
        """Outline an object's points (K, 3), all ahead of the LIDAR, which is in their origin."""
        directions = points_scan[:, :2] / points_scan[:, 2:]
        hull = np.asarray(cv2.convexHull(directions.astype(np.float32)), np.float64)[:, 0]
        middle = hull.mean(axis=0)
        along = np.roll(hull, -1, axis=0) - hull
        lengths = np.linalg.norm(along, axis=1)
        hull, along, lengths = hull[lengths > 0.0], along[lengths > 0.0], lengths[lengths > 0.0]
        normals = np.column_stack([along[:, 1], -along[:, 0]]) / lengths[:, None]
        offsets = (normals * hull).sum(axis=1)
        # Outward, whichever way the hull turns.
        sign = np.where(normals @ middle > offsets, -1.0, 1.0)
        edges = np.column_stack([normals * sign[:, None], offsets * sign + HALF_BEAM])
        return cls(directions, np.linalg.norm(points_scan, axis=1), edges)

    def before_and_behind(self, points_scan: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the indices of points (N, 3) within the outline: of nearer ones, and of those beyond its front."""
        low, high = self.directions[:, 1].min() - HALF_BEAM, self.directions[:, 1].max() + HALF_BEAM
        y, z = points_scan[:, 1], points_scan[:, 2]
        at = np.flatnonzero((z > 0.0) & (y >= low * z) & (y <= high * z))
        inside = points_scan[at]
        directions = inside[:, :2] / inside[:, 2:]
        is_within = (directions @ self.edges[:, :2].T <= self.edges[:, 2]).all(axis=1)
        range_m, front_m = np.linalg.norm(inside, axis=1), self.range_m.min()
        return at[is_within & (range_m < front_m - BEHIND_M)], at[is_within & (range_m > front_m)]

    def is_hidden_by(self, points_scan: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which of the object's points (K,) lie behind points (N, 3) of its outline in the same direction."""
        low, cell = self.directions.min(axis=0), np.array(_CELL)
        columns, rows = (np.floor((self.directions.max(axis=0) - low) / cell).astype(np.intp) + 1).tolist()
        nearest = np.full(columns * rows, np.inf)
        directions = points_scan[:, :2] / points_scan[:, 2:]
        np.minimum.at(nearest, _cells(directions, low, columns, rows), np.linalg.norm(points_scan, axis=1))
        hidden: NDArray[np.bool_] = nearest[_cells(self.directions, low, columns, rows)] < self.range_m - BEHIND_M
        return hidden


def _cells(directions: NDArray[np.float64], low: NDArray[np.float64], columns: int, rows: int) -> NDArray[np.intp]:
    column, row = np.floor((directions - low) / np.array(_CELL)).astype(np.intp).T
    cells: NDArray[np.intp] = np.clip(row, 0, rows - 1) * columns + np.clip(column, 0, columns - 1)
    return cells
