"""Lasers as lines: a point of a laser at (0, 0, h) with elevation e lies on z = h + tan(e) * hypot(x, y)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.datasets.lidar_fit.scans import Points

_TRIALS: Final = 96
_SUBSAMPLE: Final = 500
_LEAST_SCALE_M: Final = 0.0005
"""Files with whole millimeters are no sharper."""
OUTLIER_M: Final = 0.005


@dataclass(frozen=True)
class Line:
    """A fitted laser."""

    tangent: float
    height_m: float
    tangent_sd: float
    """Standard error of `tangent`; infinite where the points do not determine it."""
    height_sd_m: float

    @property
    def elevation_deg(self) -> float:
        """Elevation over the horizon."""
        return float(np.degrees(np.arctan(self.tangent)))

    def residual_m(self, points: Points) -> NDArray[np.float64]:
        """Return how far points lie above the line."""
        residual: NDArray[np.float64] = points.z_m - self.height_m - self.tangent * points.rho_m
        return residual


def fit_line(points: Points) -> Line:
    """Fit a line to points most of which lie on one: least median of squares, then least squares among what is near."""
    generator = np.random.Generator(np.random.PCG64(0))
    order = np.argsort(points.rho_m, kind="stable")
    third = max(1, len(order) // 3)
    low = order[generator.integers(0, third, _TRIALS)]
    high = order[len(order) - 1 - generator.integers(0, third, _TRIALS)]
    apart = points.rho_m[high] - points.rho_m[low]
    tangent = np.where(apart > 1e-6, (points.z_m[high] - points.z_m[low]) / np.maximum(apart, 1e-6), 0.0)
    height = points.z_m[low] - tangent * points.rho_m[low]
    some = points[order[:: max(1, len(order) // _SUBSAMPLE)]]
    residual = np.abs(some.z_m - height[:, None] - tangent[:, None] * some.rho_m)
    best = int(np.argmin(np.median(residual, axis=1)))
    line = Line(float(tangent[best]), float(height[best]), np.inf, np.inf)
    return refine(line, points)


def refine(line: Line, points: Points) -> Line:
    """Return the least-squares line of the points near a line, iterated until nearness is of their own scatter."""
    for _ in range(6):
        residual = np.abs(line.residual_m(points))
        scale = max(1.4826 * float(np.median(residual)), _LEAST_SCALE_M)
        inliers = points[residual < min(3.0 * scale, 10.0 * OUTLIER_M)]
        if len(inliers) < 3:
            return line
        mean_rho, mean_z = inliers.rho_m.mean(), inliers.z_m.mean()
        spread = float(((inliers.rho_m - mean_rho) ** 2).sum())
        if spread < 1e-6:
            return line
        tangent = float(((inliers.rho_m - mean_rho) * (inliers.z_m - mean_z)).sum()) / spread
        line = Line(tangent, float(mean_z - tangent * mean_rho), np.inf, np.inf)
        sd = max(float(line.residual_m(inliers).std()), 1e-6)
        tangent_sd = sd / spread**0.5
        line = Line(
            line.tangent, line.height_m, tangent_sd, float(sd * (1.0 / len(inliers) + mean_rho**2 / spread) ** 0.5)
        )
    return line


def split_mixed(points: Points, start: int) -> list[slice]:
    """Cut a piece of a scan into pieces of one laser each; indices count from `start`.

    Where a laser returned nothing on one side, the next one's azimuths may go on where its own ended.
    """
    whole = [slice(start, start + len(points))]
    if len(points) < 40:
        return whole
    is_outlier = np.abs(fit_line(points).residual_m(points)) > OUTLIER_M
    if is_outlier.mean() < 0.03 or is_outlier.sum() < 20:
        return whole
    inside = np.concatenate([[0], np.cumsum(~is_outlier)])
    outside = np.concatenate([[0], np.cumsum(is_outlier)])
    # Inliers before a cut and outliers behind it, or the other way round.
    scores = np.stack([inside + outside[-1] - outside, outside + inside[-1] - inside])
    cut = int(np.argmax(scores.max(axis=0)))
    if scores[:, cut].max() < 0.95 * len(points) or not 10 <= cut <= len(points) - 10:
        return whole
    return split_mixed(points[:cut], start) + split_mixed(points[cut:], start + cut)
