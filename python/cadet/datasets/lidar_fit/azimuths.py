"""When the lasers fire, told from the azimuths of far points.

A grid of azimuths with N steps a turn shows as the N-th Fourier coefficient of their histogram: its phase, ring by
ring, is the ring's offset. Lost returns leave coefficients where they are. How many of an encoder's ticks fire shows
roughly in stretches where no return is missing, and sharply in the coefficient of the firings themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.datasets.lidar_fit.rings import Rings
from cadet.datasets.lidar_fit.scans import Points
from cadet.sensors.firing import EncoderFiring, Firing, UniformFiring

_BINS: Final = 1 << 17
_FAR_M: Final = 8.0
"""Nearer points' azimuths are blurred by millimeters and by what the lasers stand beside the axis; rings that see
nothing farther are told by their farther half."""
_FEWEST_STEPS, _MOST_STEPS = 90, 20_000
_COHERENT: Final = 0.25
_AS_GOOD: Final = 0.8
_STRETCH: Final = 24
_CLEAN_SHARE: Final = 0.03
_UNIFORM_BELOW: Final = 1.02
_MANY_LOST: Final = 1.3
_SAME_OFFSET: Final = 0.02
"""Of a step."""


@dataclass(frozen=True)
class FiringFit:
    """A firing pattern and how well it shows."""

    firing: Firing
    offsets_deg: list[float]
    """Of each ring, counter-clockwise, below one step."""
    coherence: float
    """How sharply azimuths fall on the grid: 1 for exactly."""
    on_grid: bool
    """False where no grid shows and the columns are only counted."""


def fit_firing(scans: Sequence[Points], rings: Rings) -> FiringFit:
    """Fit the firing pattern."""
    steps, spectrum, counts = _strongest(scans, rings)
    coherence = float(np.abs(spectrum[:, steps]).sum() / max(counts.sum(), 1))
    if coherence < _COHERENT:
        step_deg = _clean_step(scans, rings, None)
        columns = min(max(round(360.0 / step_deg), 1), 65535)
        return FiringFit(UniformFiring(columns=columns), [0.0] * len(rings.lines), coherence, on_grid=False)
    step_deg = 360.0 / steps
    roughly = _clean_step(scans, rings, step_deg) / step_deg
    firings = _firings(steps, roughly, np.abs(spectrum).sum(axis=0) / max(counts.sum(), 1))
    if roughly < _UNIFORM_BELOW or (firings is None and roughly < _MANY_LOST):
        offsets = -np.angle(spectrum[:, steps]) / (2.0 * np.pi)
        return FiringFit(
            UniformFiring(columns=steps), [step_deg * part for part in _parts(offsets, counts)], coherence, on_grid=True
        )
    # Each ring's own corrections blur the ticks of an encoder too much for offsets.
    ticks = round(roughly if firings is None else steps / firings, 4)
    columns = int(np.ceil(steps / ticks))
    while np.floor(ticks * (columns - 1) + 0.5) >= steps:
        columns -= 1
    firing = EncoderFiring(ticks_per_turn=steps, ticks_per_firing=ticks, firings=columns)
    return FiringFit(firing, [0.0] * len(rings.lines), coherence, on_grid=True)


def _firings(steps: int, roughly: float, strength: NDArray[np.float64]) -> int | None:
    """Return the number of firings a turn if it shows: even firings that are told to a tick leave theirs.

    Stretches with lost returns have wider steps, so that there are rather more firings than they say.
    """
    low, high = int(0.97 * steps / roughly), min(int(1.25 * steps / roughly), steps - 2)
    if low >= high:
        return None
    best = low + int(np.argmax(strength[low : high + 1]))
    # Told beside where it was by an even share of a tick: the coefficient is that of a box of one tick's width.
    expected = float(np.sinc(best / steps)) * float(strength[steps])
    return best if strength[best] > 0.5 * expected and strength[best] > 4.0 * np.median(strength[low:high]) else None


def _parts(offsets: NDArray[np.float64], counts: NDArray[np.intp]) -> list[float]:
    """Return offsets in steps, in [0, 1); one that all share within their blur is none."""
    parts = offsets % 1.0
    parts = np.where(counts > 0, parts, 0.0)
    parts[np.minimum(parts, 1.0 - parts) < _SAME_OFFSET] = 0.0
    return [float(part) for part in parts]


def _strongest(scans: Sequence[Points], rings: Rings) -> tuple[int, NDArray[np.complex128], NDArray[np.intp]]:
    """Return the steps a turn whose coefficient is largest over all rings, every ring's spectrum, its points.

    Multiples of the true number are as large on a sharp grid: the smallest of the large ones is meant.
    """
    spectrum = np.zeros((len(rings.lines), _MOST_STEPS + 1), np.complex128)
    strength = np.zeros(_MOST_STEPS + 1)
    counts = np.zeros(len(rings.lines), np.intp)
    for scan, ring_of_point in zip(scans, rings.ring_of_point, strict=True):
        for ring in range(len(rings.lines)):
            points = scan[ring_of_point == ring]
            if len(points) == 0:
                continue
            azimuth = points.azimuth_deg[points.rho_m >= min(_FAR_M, float(np.median(points.rho_m)))]
            histogram = np.bincount((azimuth / 360.0 * _BINS).astype(np.intp) % _BINS, minlength=_BINS)
            found = np.fft.rfft(histogram)[: _MOST_STEPS + 1]
            # A bin's points lie half a bin behind its edge on average.
            found = found * np.exp(-1j * np.pi * np.arange(_MOST_STEPS + 1) / _BINS)
            spectrum[ring] += found
            strength += np.abs(found)
            counts[ring] += len(azimuth)
    strength[:_FEWEST_STEPS] = 0.0
    best = int(np.argmax(strength))
    for divisor in range(min(best // _FEWEST_STEPS, 64), 1, -1):
        if best % divisor == 0 and strength[best // divisor] >= _AS_GOOD * strength[best]:
            best //= divisor
            break
    return best, spectrum, counts


def _clean_step(scans: Sequence[Points], rings: Rings, tick_deg: float | None) -> float:
    """Return the mean step from firing to firing, in degrees, where no return is missing.

    Stretches of returns are clean if their steps have as few ticks as a fair share of all stretches do.
    """
    steps: list[NDArray[np.float64]] = []
    for scan, ring_of_point in zip(scans, rings.ring_of_point, strict=True):
        for ring in range(len(rings.lines)):
            azimuth = np.sort(scan.azimuth_deg[ring_of_point == ring])
            if len(azimuth) > 4 * _STRETCH:
                steps.append(np.diff(azimuth))
    if not steps:
        return 360.0 / 2000.0
    every = np.concatenate(steps)
    unit = tick_deg if tick_deg is not None else float(np.median(every))
    stretches = np.concatenate([s[: len(s) // _STRETCH * _STRETCH].reshape(-1, _STRETCH) for s in steps])
    widest = np.rint(stretches.max(axis=1) / unit)
    for limit in range(1, 64):
        clean = widest <= limit
        if clean.mean() >= _CLEAN_SHARE:
            return float(stretches[clean].mean())
    return unit
