"""Where what carries the sensor is in the way: azimuths at which a ring that meets the ground never returns a thing."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Final

import numpy as np

from cadet.datasets.lidar_fit.rings import Rings
from cadet.datasets.lidar_fit.scans import Points

_FEWEST_SCANS: Final = 4
"""Fewer could all have the same car beside them."""
_LOWEST_FAR_DEG: Final = -8.0
"""Rings below it meet the ground within some 12 m of a car's roof: what is lost there is hidden."""
_NARROWEST_DEG: Final = 1.2


def blind_sectors(scans: Sequence[Points], rings: Rings) -> list[tuple[tuple[float, float], ...]]:
    """Return each ring's sectors (from, to) in degrees, to a tenth; a sector across forward is two."""
    if len(scans) < _FEWEST_SCANS:
        return [() for _ in rings.lines]
    found = []
    for ring, line in enumerate(rings.lines):
        azimuths = np.sort(
            np.concatenate(
                [scan.azimuth_deg[which == ring] for scan, which in zip(scans, rings.ring_of_point, strict=True)]
            )
        )
        is_low = line.elevation_deg < _LOWEST_FAR_DEG and len(azimuths) > 0
        found.append(_gaps(azimuths.tolist()) if is_low else ())
    return found


def _gaps(azimuths_deg: list[float]) -> tuple[tuple[float, float], ...]:
    first, last = azimuths_deg[0], azimuths_deg[-1]
    gaps = [
        (round(a + 0.05, 1), round(b - 0.05, 1)) for a, b in itertools.pairwise(azimuths_deg) if b - a > _NARROWEST_DEG
    ]
    if first + 360.0 - last > _NARROWEST_DEG:
        if first > 0.2:
            gaps.insert(0, (0.0, round(first - 0.05, 1)))
        if last < 359.8:
            gaps.append((round(last + 0.05, 1), 360.0))
    return tuple(gaps)
