"""Figures as inline SVG. Colors are the style sheet's, so that a figure follows the page into the dark."""

from __future__ import annotations

from html import escape
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.datasets.report.quantities import Quantity
from cadet.datasets.report.statistics import shares

_WIDTH: Final = 340
_HEIGHT: Final = 200
_LEFT, _RIGHT, _TOP, _BOTTOM = 40, 14, 8, 34
_MOST_TICKS: Final = 7


def histogram(quantity: Quantity, ours: NDArray[np.int64], kitti: NDArray[np.int64]) -> str:
    """Draw a histogram as bars, and KITTI's as a line over it: shares of all objects in percent.

    Args:
        quantity: what the bins mean.
        ours: (num_bins,) counts of the dataset.
        kitti: (num_bins,) counts of KITTI.
    """
    first, last = _used_bins(ours, kitti)
    own, real = (100.0 * shares(counts)[first:last] for counts in (ours, kitti))
    top = _round_up(float(max(own.max(), real.max(), 1e-9)))
    num_bins = last - first
    step = (_WIDTH - _LEFT - _RIGHT) / num_bins
    parts = [_percent_axis(top)]
    for index, share in enumerate(own):
        if share > 0.0:
            y = _y(share, top)
            what = escape(f"{_bin_name(quantity, first + index)}: {share:.1f} %, KITTI {real[index]:.1f} %")
            parts.append(
                f'<rect class="ours" x="{_LEFT + index * step + 0.5:.1f}" y="{y:.1f}" width="{max(step - 1, 0.5):.1f}" '
                f'height="{_HEIGHT - _BOTTOM - y:.1f}"><title>{what}</title></rect>'
            )
    if kitti.any():
        line = [(_LEFT + (index + side) * step, _y(real[index], top)) for index in range(num_bins) for side in (0, 1)]
        path = "".join(f"{'L' if at else 'M'}{x:.1f} {y:.1f}" for at, (x, y) in enumerate(line))
        parts.append(f'<path class="kitti" d="{path}"/>')
    parts += _bin_axis(quantity, first, last, step)
    label = escape(f"{quantity.title}: histogram of the dataset, with KITTI's as a line")
    return f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{label}">{"".join(parts)}</svg>'


def distance(ours: NDArray[np.int64], kitti: NDArray[np.int64]) -> float | None:
    """Return Jensen and Shannon's distance of two histograms: 0 for the same shares, 1 for none in common.

    None where either is empty.
    """
    if not (ours.any() and kitti.any()):
        return None
    p, q = shares(ours), shares(kitti)
    middle = 0.5 * (p + q)
    divergence = 0.0
    for one in (p, q):
        is_there = one > 0.0
        divergence += 0.5 * float(np.sum(one[is_there] * np.log2(one[is_there] / middle[is_there])))
    return float(np.sqrt(max(divergence, 0.0)))


def _used_bins(ours: NDArray[np.int64], kitti: NDArray[np.int64]) -> tuple[int, int]:
    """Leave out bins at both ends that hold next to nothing in either: the rest is easier to see."""
    share = np.maximum(shares(ours), shares(kitti))
    used = np.flatnonzero(share >= 0.001)
    if not len(used):
        return 0, len(share)
    first, last = int(used[0]), int(used[-1]) + 1
    # A few bins alone would be drawn as blocks.
    return (first, last) if last - first >= 4 else (max(0, first - 2), min(len(share), last + 2))


def _percent_axis(top: float) -> str:
    lines = []
    for share in (0.0, 0.5 * top, top):
        y = _y(share, top)
        lines.append(f'<path class="grid" d="M{_LEFT} {y:.1f}H{_WIDTH - _RIGHT}"/>')
        sign = " %" if share == top else ""
        lines.append(f'<text class="tick" x="{_LEFT - 4}" y="{y + 3.5:.1f}" text-anchor="end">{share:g}{sign}</text>')
    return "".join(lines)


def _bin_axis(quantity: Quantity, first: int, last: int, step: float) -> list[str]:
    """Name bins in their middle where they have names, else their edges."""
    y = _HEIGHT - _BOTTOM + 13
    num = last - first + (0 if quantity.names else 1)
    every = -(-num // _MOST_TICKS)
    names = (
        quantity.names[first:last] if quantity.names else [f"{edge:.4g}" for edge in quantity.edges[first : last + 1]]
    )
    shift = 0.5 if quantity.names else 0.0
    ticks = [
        f'<text class="tick" x="{_LEFT + (index + shift) * step:.1f}" y="{y}" text-anchor="middle">'
        f"{escape(name)}</text>"
        for index, name in enumerate(names)
        if index % every == 0
    ]
    if quantity.unit:
        x = (_LEFT + _WIDTH - _RIGHT) / 2
        ticks.append(
            f'<text class="tick" x="{x}" y="{_HEIGHT - 5}" text-anchor="middle">{escape(quantity.unit)}</text>'
        )
    return ticks


def _bin_name(quantity: Quantity, index: int) -> str:
    if quantity.names:
        return quantity.names[index]
    return f"{quantity.edges[index]:.4g} to {quantity.edges[index + 1]:.4g} {quantity.unit}".rstrip()


def _y(share: float, top: float) -> float:
    return _TOP + (_HEIGHT - _BOTTOM - _TOP) * (1.0 - share / top)


def _round_up(value: float) -> float:
    """Return the next of 1, 2, 4, 5, 6, 8 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(power * head for head in (1, 2, 4, 5, 6, 8, 10) if power * head >= value * 0.999999))
