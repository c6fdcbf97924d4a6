"""Scans of a LIDAR with no help of the core: beams against the ground and the walls of a yard, in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cadet import BeamTable, EncoderFiring, Laser, UniformFiring

VLP16 = BeamTable(
    name="vlp16",
    rings=tuple(Laser(elevation_deg=float(elevation)) for elevation in range(15, -16, -2)),
    firing=UniformFiring(columns=1808),
)


def azimuths_deg(table: BeamTable) -> NDArray[np.float64]:
    """Return the azimuths at which columns are reported, from the definitions of the patterns."""
    firing = table.firing
    if isinstance(firing, UniformFiring):
        return np.arange(firing.columns, dtype=np.float64) * (360.0 / firing.columns)
    assert isinstance(firing, EncoderFiring)
    ticks = np.floor(firing.ticks_per_firing * np.arange(firing.firings) + firing.phase_ticks + 0.5)
    return np.asarray(ticks * (360.0 / firing.ticks_per_turn), np.float64)


def yard_scan(table: BeamTable, seed: int) -> NDArray[np.float32]:
    """Return a ring-major scan, rounded to millimeters: ground, walls, boxes; a tenth is lost."""
    generator = np.random.Generator(np.random.PCG64(seed))
    walls_m = generator.uniform(8.0, 30.0, 4)
    pillar = generator.uniform(0.0, 360.0, 25), generator.uniform(1.0, 6.0, 25), generator.uniform(3.0, 15.0, 25)
    rings = []
    for laser in table.rings:
        azimuth = np.radians(azimuths_deg(table) + laser.azimuth_offset_deg)
        cos, sin = np.cos(azimuth), np.sin(azimuth)
        with np.errstate(divide="ignore"):
            rho = np.min(
                [np.where(c > 0.0, w / c, np.inf) for c, w in zip((cos, sin, -cos, -sin), walls_m, strict=True)], axis=0
            )
        for middle, width, distance in zip(*pillar, strict=True):
            is_in = np.abs((np.degrees(azimuth) - middle + 180.0) % 360.0 - 180.0) < 0.5 * width
            rho = np.where(is_in, np.minimum(rho, distance), rho)
        tangent = np.tan(np.radians(laser.elevation_deg))
        # Ground that rises a little to one side, as streets do.
        fall = 0.02 * cos - tangent
        rho = np.where(fall * rho > 1.7 + laser.height_m, (1.7 + laser.height_m) / np.maximum(fall, 1e-9), rho)
        range_m = rho / np.cos(np.radians(laser.elevation_deg)) + generator.normal(laser.range_offset_m, 0.01, len(rho))
        rho = range_m * np.cos(np.radians(laser.elevation_deg))
        xyz = np.round(np.stack([rho * cos, rho * sin, laser.height_m + tangent * rho], axis=1), 3)
        intensity = np.where(generator.random(len(rho)) < 0.1, 0.0, 0.3)
        points = np.column_stack([xyz, intensity])
        rings.append(points[generator.random(len(rho)) > 0.1])
    return np.concatenate(rings).astype(np.float32)


def ring_of(points: NDArray[np.generic]) -> NDArray[np.intp]:
    """Return the ring of each point of a ring-major scan."""
    azimuth = np.arctan2(points[:, 1], points[:, 0]) % (2.0 * np.pi)
    return np.concatenate([[0], np.cumsum(np.diff(azimuth) < -np.pi)])


def write_scan(path: Path, points: NDArray[np.float32]) -> Path:
    """Write a `.bin` file."""
    path.write_bytes(points.astype("<f4").tobytes())
    return path
