"""Axes of AP for the figures of experiments."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from avod.experiments.statistics import Mean
from cadet._util import style

WIDTH: Final = 560
HEIGHT: Final = 360
_LEFT, _TOP, _RIGHT, _BOTTOM = 52, 44, 540, 316
_HEADER: Final = 62
_STEP: Final = 20.0


class Chart:
    """One pair of axes: AP upward, and what the caller places across.

    Args:
        canvas: `HEIGHT` x `WIDTH` pixels to draw on.
        title: above the axes.
        highest: the largest AP in percent to be seen.
    """

    def __init__(self, canvas: style.Image, title: str, highest: float) -> None:
        self.canvas = canvas
        self._top = min(100.0, _STEP * max(1.0, math.ceil(highest / _STEP)))
        canvas[_TOP:_BOTTOM, _LEFT:_RIGHT] = style.PANEL
        style.write(canvas, title, _LEFT, _TOP - 12, 0.5)
        for tick in np.arange(0.0, self._top + 1.0, _STEP / 2.0 if self._top <= 2.0 * _STEP else _STEP):
            y = self.y(float(tick))
            style.stroke(canvas, (_LEFT, y), (_RIGHT, y), style.GRID)
            width, height = style.text_size(f"{tick:.0f}", 0.38)
            style.write(canvas, f"{tick:.0f}", _LEFT - 8 - width, y + height / 2, 0.38, style.FAINT_TEXT)

    def x(self, share: float) -> float:
        """Return the column of a share of the width, 0 to 1."""
        return _LEFT + share * (_RIGHT - _LEFT)

    def y(self, ap: float) -> float:
        """Return the row of an AP in percent."""
        return _BOTTOM - min(max(ap, 0.0), self._top) / self._top * (_BOTTOM - _TOP)

    def label(self, share: float, text: str, line: int = 0) -> None:
        """Write a text below the axes, in the middle of a share of the width."""
        width, _ = style.text_size(text, 0.4)
        style.write(self.canvas, text, self.x(share) - width / 2, _BOTTOM + 18 + 16 * line, 0.4, style.FAINT_TEXT)

    def bar(self, low: float, high: float, ap: Mean, color: style.Color, paper: float | None) -> None:
        """Draw a bar between two shares of the width, its interval, and a line across where the paper has it."""
        left, right, top = self.x(low), self.x(high), self.y(ap.value)
        corners = np.array([(left, top), (right, top), (right, _BOTTOM), (left, _BOTTOM)])
        style.polygon(self.canvas, corners, color, 0.8)
        self._interval((left + right) / 2, ap, style.TEXT)
        if paper is not None:
            y = self.y(paper)
            style.stroke(self.canvas, (left - 2, y), (right + 2, y), style.TEXT, 2)

    def line(self, points: Sequence[tuple[float, Mean]], color: style.Color) -> None:
        """Draw a line through means at shares of the width, with their intervals."""
        places = np.array([(self.x(share), self.y(ap.value)) for share, ap in points])
        style.polyline(self.canvas, places, color, 2, is_closed=False)
        for (x, y), (_, ap) in zip(places, points, strict=True):
            style.dot(self.canvas, (x, y), 4.0, color)
            self._interval(x, ap, color)

    def dashed(self, ap: Mean, color: style.Color) -> None:
        """Draw a dashed line across at a mean, its interval at the right."""
        left, right = (np.array([self.x(share), self.y(ap.value)]) for share in (0.0, 1.0))
        for start, end in style.dashes(left, right, 7.0):
            style.stroke(self.canvas, start, end, color, 2)
        self._interval(self.x(0.985), ap, color)

    def _interval(self, x: float, ap: Mean, color: style.Color) -> None:
        if ap.half_width is None:
            return
        low, high = self.y(ap.value - ap.half_width), self.y(ap.value + ap.half_width)
        style.stroke(self.canvas, (x, low), (x, high), color)
        for y in (low, high):
            style.stroke(self.canvas, (x - 4, y), (x + 4, y), color)


def sheet(num_rows: int, num_columns: int, title: str, legend: Iterable[tuple[str, style.Color]]) -> style.Image:
    """Make an empty sheet for charts, with a title and a legend above them."""
    image = style.filled(_HEADER + HEIGHT * num_rows, WIDTH * num_columns)
    style.write(image, title, 16, 26, 0.6)
    left = 16.0
    for text, color in legend:
        style.stroke(image, (left, 46), (left + 22, 46), color, 4)
        style.write(image, text, left + 30, 50, 0.42)
        left += 56 + style.text_size(text, 0.42)[0]
    return image


def place(image: style.Image, row: int, column: int) -> style.Image:
    """Return the part of a sheet that a chart is drawn on."""
    top = _HEADER + row * HEIGHT
    return image[top : top + HEIGHT, column * WIDTH : (column + 1) * WIDTH]
