"""A sensor's beam table fitted to its scans, and how well it fits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.summary import summary
from cadet.datasets.lidar_fit.azimuths import FiringFit, fit_firing
from cadet.datasets.lidar_fit.blind import blind_sectors
from cadet.datasets.lidar_fit.lines import OUTLIER_M
from cadet.datasets.lidar_fit.motion import undone
from cadet.datasets.lidar_fit.offsets import fit_range_offsets
from cadet.datasets.lidar_fit.rings import Rings, find_rings, rings_of_numbers
from cadet.datasets.lidar_fit.scans import Points, Turn, find_scans, join, read_turn
from cadet.errors import CadetError
from cadet.sensors.beam_table import BeamTable, Laser
from cadet.sensors.firing import EncoderFiring, UniformFiring

_NEIGHBOURS: Final = 8
_ZEROS_ANYWAY: Final = 0.03
"""Share of zero intensities that the best receivers report, too."""
_WINDOW: Final = 32
"""Beams in a row of which each window tells the noise of."""


@dataclass(frozen=True)
class RingFit:
    """One laser as its points show it."""

    laser: Laser
    elevation_sd_deg: float
    """Standard error."""
    height_sd_m: float
    """Standard error."""
    range_offset_sd_m: float
    """Standard error, of the laser's error beside the mean of all."""
    num_points: int
    median_residual_m: float
    """Of the points' distances in height from the fitted cone."""
    outlier_share: float
    """Farther from the cone than 5 mm."""
    missing_share: float
    """Of the beams: nothing returned, or nothing in range."""
    zero_share: float
    """Of the returns: intensity 0."""


@dataclass(frozen=True)
class LidarFit:
    """A fitted sensor."""

    table: BeamTable
    rings: tuple[RingFit, ...]
    num_scans: int
    num_points: int
    unassigned_points: int
    """Points that lie on no laser's cone."""
    median_residual_m: float
    in_ring_order: bool
    firing: FiringFit
    num_left_out: int = 0
    """Rows of the files that stand for no return: not finite, or at the origin."""
    num_flat_patches: int = 0
    """Walls, sides of vehicles and pieces of road that told the lasers' range errors."""
    num_offsets_unknown: int = 0
    """Lasers whose range error they did not tell: the table has 0."""
    moved_m: float = 0.0
    """How far drivers had moved points for the vehicle's motion, which was undone; 0 for not."""

    def __repr__(self) -> str:
        return summary(
            self,
            self.table.name,
            f"{len(self.rings)} rings",
            num_scans=self.num_scans,
            num_points=self.num_points,
            median_residual_m=self.median_residual_m,
        )

    def to_toml(self) -> str:
        """Return the table as TOML, with what it was fitted to above."""
        head = [
            f"# Fitted to {self.num_scans} scans, {self.num_points} points: "
            f"median residual {1e3 * self.median_residual_m:.2f} mm.",
            *(f"# {line}" for line in self.remarks()),
        ]
        return "\n".join(head) + "\n" + self.table.to_toml()

    def remarks(self) -> list[str]:
        """Say in sentences what the table cannot."""
        firing = self.table.firing
        lines = []
        if isinstance(firing, EncoderFiring):
            lines.append(
                f"Azimuths fall on {firing.ticks_per_turn} ticks of {360.0 / firing.ticks_per_turn:.6g} degrees "
                f"(coherence {self.firing.coherence:.2f}), {firing.ticks_per_firing:g} from firing to firing."
            )
        elif isinstance(firing, UniformFiring) and self.firing.on_grid:
            lines.append(
                f"Azimuths fall on {firing.columns} equal steps of {360.0 / firing.columns:.6g} degrees "
                f"(coherence {self.firing.coherence:.2f})."
            )
        elif isinstance(firing, UniformFiring):
            lines.append(f"Azimuths show no grid; {firing.columns} columns are counted where no return is missing.")
        if self.num_left_out:
            lines.append(f"{self.num_left_out} more rows mean no return (not finite, or at the origin).")
        if self.moved_m > 0.0:
            lines.append(f"Points were moved by up to {self.moved_m:.2f} m for the vehicle's motion, which is undone.")
        if self.unassigned_points:
            lines.append(f"{self.unassigned_points} points lie on no laser's cone.")
        if not self.in_ring_order:
            lines.append("The points come in no order of rings: each was given to the nearest cone.")
        hidden = sum(b - a for ring in self.rings for a, b in ring.laser.blind_deg) / (3.6 * len(self.rings))
        if hidden > 0.0:
            lines.append(f"What carries the sensor hides {hidden:.1f} % of its beams.")
        if self.num_offsets_unknown == len(self.rings):
            lines.append(
                f"The lasers' range errors are unknown, and 0 here: {self.num_flat_patches} flat patches that four "
                "lasers see tell none of them; scans of walls within some 10 m would."
            )
        else:
            lines.append(
                f"The lasers' range errors, their mean taken for 0, are those of {self.num_flat_patches} flat patches"
                + (f"; {self.num_offsets_unknown} are unknown, and 0 here." if self.num_offsets_unknown else ".")
            )
        lines.append("The gains follow the shares of zero intensities, ring against neighboring rings.")
        return lines


def fit_lidar(paths: Sequence[str | Path], name: str = "fitted") -> LidarFit:
    """Fit lasers, their range errors, firing pattern, ranges, noise and gains to scans of one sensor.

    Args:
        paths: scans of any format that `cadet.formats.scan_files.read_scan` reads, or folders of them, in the
            sensor's own frame, z up, one turn each.
        name: the fitted table's.

    Raises:
        CadetError: a file that cannot be read, too few points, or points that lie on no lasers' cones.
    """
    files = find_scans(paths)
    turns = [read_turn(file) for file in files]
    scans, rings, moved_m = _scans_and_rings(turns)
    firing = fit_firing(scans, rings)
    parts = [
        join([scan[ring_of_point == ring] for scan, ring_of_point in zip(scans, rings.ring_of_point, strict=True)])
        for ring in range(len(rings.lines))
    ]
    zero_shares = np.array([float((points.intensity == 0.0).mean()) if len(points) else 0.0 for points in parts])
    gains = _gains(zero_shares)
    blind = blind_sectors(scans, rings)
    offsets = fit_range_offsets(scans, rings)
    columns = BeamTable(name="columns", rings=(Laser(elevation_deg=0.0),), firing=firing.firing).num_columns
    fitted = []
    for ring, (line, points) in enumerate(zip(rings.lines, parts, strict=True)):
        residual_m = np.abs(line.residual_m(points))
        laser = Laser(
            elevation_deg=round(line.elevation_deg, 4),
            height_m=round(line.height_m, 5),
            azimuth_offset_deg=round(firing.offsets_deg[ring], 4),
            gain=round(float(gains[ring]), 2),
            range_offset_m=round(float(offsets.offset_m[ring]), 4),
            blind_deg=blind[ring],
        )
        cos = math.cos(math.radians(line.elevation_deg))
        fitted.append(
            RingFit(
                laser=laser,
                elevation_sd_deg=math.degrees(line.tangent_sd) * cos * cos,
                height_sd_m=line.height_sd_m,
                range_offset_sd_m=float(offsets.sd_m[ring]),
                num_points=len(points),
                median_residual_m=float(np.median(residual_m)),
                outlier_share=float((residual_m > OUTLIER_M).mean()),
                missing_share=max(0.0, 1.0 - len(points) / (columns * len(scans))),
                zero_share=float(zero_shares[ring]),
            )
        )
    every_range = np.concatenate([scan.range_m for scan in scans])
    residuals = np.concatenate([np.abs(line.residual_m(p)) for line, p in zip(rings.lines, parts, strict=True)])
    try:
        table = BeamTable(
            name=name,
            rings=tuple(ring.laser for ring in fitted),
            firing=firing.firing,
            min_range_m=max(0.0, math.floor(100.0 * float(every_range.min())) / 100.0),
            max_range_m=math.ceil(10.0 * float(every_range.max()) + 1e-6) / 10.0,
            range_noise_m=_range_noise_m(scans, rings),
        )
    except CadetError as error:
        raise CadetError(f"{files[0].name}: the fitted table is not a valid sensor: {error}") from None
    return LidarFit(
        table=table,
        rings=tuple(fitted),
        num_scans=len(scans),
        num_points=len(every_range),
        unassigned_points=int(sum((which < 0).sum() for which in rings.ring_of_point)),
        median_residual_m=float(np.median(residuals)),
        in_ring_order=rings.ordered,
        firing=firing,
        num_left_out=sum(turn.num_rows for turn in turns) - len(every_range),
        num_flat_patches=offsets.num_patches,
        num_offsets_unknown=int((~offsets.is_known).sum()),
        moved_m=moved_m,
    )


def _scans_and_rings(turns: Sequence[Turn]) -> tuple[list[Points], Rings, float]:
    """Return the points, the lasers, and how far points had been moved for the vehicle's motion.

    The lasers' numbers are used where all scans have them and they are right; only then can a motion be undone.
    """
    names = [turn.name for turn in turns]
    for moved in (False, True):
        found = [undone(turn.xyz, turn.ring, turn.time) if moved else turn.xyz for turn in turns]
        stills = [replace(turn, xyz=xyz) for turn, xyz in zip(turns, found, strict=True) if xyz is not None]
        scans = [still.points() for still in stills]
        numbers = [t.ring[is_return] for t, (_, is_return) in zip(stills, scans, strict=True) if t.ring is not None]
        if len(numbers) < len(turns):
            break
        points = [points for points, _ in scans]
        rings = rings_of_numbers(points, numbers)
        if rings is not None:
            far = (np.linalg.norm(s.xyz - t.xyz, axis=1).max() for s, t in zip(stills, turns, strict=True))
            return points, rings, float(max(far))
    points = [turn.points()[0] for turn in turns]
    return points, find_rings(points, names), 0.0


def _gains(zero_shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Guess receivers' gains: the core's odds of a non-zero intensity grow with the square of the gain."""
    odds = (1.0 - zero_shares) / np.maximum(zero_shares - _ZEROS_ANYWAY, 0.02)
    usual = np.array([np.median(odds[max(0, k - _NEIGHBOURS) : k + _NEIGHBOURS + 1]) for k in range(len(odds))])
    if (zero_shares > 0.0).mean() < 0.5:
        return np.ones(len(zero_shares))
    gains: NDArray[np.float64] = np.clip(np.sqrt(odds / np.maximum(usual, 1e-9)), 0.2, 3.0)
    return gains


def _range_noise_m(scans: Sequence[Points], rings: Rings) -> float:
    """Estimate the noise from second differences of ranges along rings, where they are usual for smooth surfaces.

    Windows of neighboring beams on walls and roads agree on the noise; those on grass and foliage show those,
    and scatter over a wide range: so the noise is where the windows lie closest together.
    """
    found = []
    for scan, ring_of_point in zip(scans, rings.ring_of_point, strict=True):
        for ring in range(len(rings.lines)):
            points = scan[ring_of_point == ring]
            if len(points) < 100:
                continue
            points = points[np.argsort(points.azimuth_deg, kind="stable")]
            step = np.diff(points.azimuth_deg)
            # Between equal steps an encoder's rounding cancels.
            is_even = np.maximum(step[1:], step[:-1]) < 1.05 * np.minimum(step[1:], step[:-1])
            second = points.range_m[2:] - 2.0 * points.range_m[1:-1] + points.range_m[:-2]
            used = np.abs(second[is_even & (points.range_m[1:-1] < 25.0)])
            num_windows = len(used) // _WINDOW
            found.append(np.median(used[: num_windows * _WINDOW].reshape(-1, _WINDOW), axis=1))
    windows = np.sort(np.concatenate(found)) if found else np.zeros(0)
    if len(windows) < 20:
        return 0.0
    # The shortest interval that holds a quarter of the windows.
    share = max(2, len(windows) // 4)
    first = int(np.argmin(windows[share - 1 :] - windows[: len(windows) - share + 1]))
    usual = float(np.median(windows[first : first + share]))
    # Half of a normal variable of 6 variances lies within 0.6745 standard deviations.
    return round(usual / (0.6745 * math.sqrt(6.0)), 4)
