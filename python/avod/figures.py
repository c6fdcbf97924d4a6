"""Figures: detections beside labels, and the curves of a training."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from avod.train.log import TOTAL, terms_of
from cadet._util import style
from cadet.errors import CadetError
from cadet.formats.kitti import Label
from cadet.formats.kitti.drawing import bev_figure, boxes_figure
from cadet.formats.kitti.frame import Frame

_MARGIN: Final = 12
_TITLE: Final = 26
_FEW_ROWS: Final = 10
_LEAST: Final = 1e-6
_AP_COLOR: Final = style.VISIBLE
_CURVE_COLORS: Final = tuple(style.CLASS_COLORS.values())


def detection_figure(frame: Frame, found: tuple[Label, ...]) -> style.Image:
    """Draw labels to the left, detections to the right: in the image, and from above.

    Args:
        frame: with its labels.
        found: detections of the frame.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    columns = []
    for title, labels in (("labels", frame.labels), ("detections", found)):
        shown = replace(frame, labels=labels)
        image = boxes_figure(shown)
        width = image.shape[1]
        count = sum(not label.is_dont_care for label in labels)
        columns.append(np.concatenate([_title(f"{title}: {count}", width), image, bev_figure(shown, width)]))
    gap = style.filled(columns[0].shape[0], _MARGIN)
    return np.concatenate([columns[0], gap, columns[1]], axis=1)


def film_picture(frame: Frame, found: tuple[Label, ...]) -> style.Image:
    """Draw detections in the image (H, W), and from above beside it: (H, W + H, 3) uint8 RGB."""
    shown = replace(frame, labels=found)
    height, width = frame.image.shape[:2]
    picture = style.filled(height, width + height)
    picture[:, :width] = boxes_figure(shown)
    above = bev_figure(shown, height, has_text=False)
    picture[: len(above), width:] = above
    return picture


def loss_figure(
    rows: Sequence[dict[str, float]],
    validations: Sequence[dict[str, float]] = (),
    size: tuple[int, int] = (960, 480),
) -> style.Image:
    """Draw the losses of a training over its steps, on a logarithmic scale, each a running mean over the rows around.

    Validations are marked where they are: their total loss on the same scale, and AP from 0 at the bottom to 100 % at
    the top.

    Args:
        rows: of `log.csv`.
        validations: rows of `val.csv`.
        size: width and height in pixels.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        CadetError: there are no rows.
    """
    if not rows:
        raise CadetError("the log has no rows to draw")
    curves = {name: np.maximum(_running_mean([row[name] for row in rows]), _LEAST) for name in terms_of(rows[0])}
    plot = _Plot(
        np.array([row["step"] for row in [*rows, *validations]]),
        np.concatenate([*curves.values(), [max(row["total"], _LEAST) for row in validations]]),
        size,
    )
    steps = [row["step"] for row in rows]
    for index, (name, values) in enumerate(curves.items()):
        color = style.TEXT if name == TOTAL else _CURVE_COLORS[index]
        has_dots = len(rows) < _FEW_ROWS
        plot.curve(steps, plot.loss_y(values), color, width=2 if name == TOTAL else 1, has_dots=has_dots)
        plot.legend(f"{name} {values[-1]:.3g}", color)
    if validations:
        steps = [row["step"] for row in validations]
        totals = np.maximum([row["total"] for row in validations], _LEAST)
        plot.curve(steps, plot.loss_y(totals), style.FAINT_TEXT, has_dots=True)
        plot.legend(f"val total {totals[-1]:.3g}", style.FAINT_TEXT)
        shares = np.array([row["ap"] for row in validations]) / 100.0
        best = validations[int(np.flatnonzero(shares == shares.max())[-1])]
        plot.curve(steps, plot.bottom - shares * (plot.bottom - plot.top), _AP_COLOR, width=2, has_dots=True)
        plot.legend(f"val AP {validations[-1]['ap']:.1f} %", _AP_COLOR)
        plot.legend(f"best {best['ap']:.1f} % at {best['step']:.0f}", _AP_COLOR)
        plot.percents()
    return plot.canvas


class _Plot:
    """Axes of steps and of losses, and what is drawn between them.

    Args:
        steps: all that are to be seen.
        losses: likewise, positive.
        size: width and height in pixels.
    """

    def __init__(self, steps: NDArray[np.float64], losses: NDArray[np.float64], size: tuple[int, int]) -> None:
        self.canvas = style.filled(size[1], size[0])
        self.left, self.right, self.top, self.bottom = 60, size[0] - 150, 20, size[1] - 40
        self._first, self._span = float(steps.min()), max(float(steps.max() - steps.min()), 1.0)
        self._low = float(np.floor(np.log10(losses.min())))
        self._high = max(float(np.ceil(np.log10(losses.max()))), self._low + 1.0)
        self._num_lines = 0
        for decade in np.arange(self._low, self._high + 1.0):
            y = float(self.loss_y(np.array([10.0**decade]))[0])
            style.stroke(self.canvas, (self.left, y), (self.right, y), style.GRID)
            style.write(self.canvas, f"{10.0**decade:g}", 8, y + 4, 0.4, style.FAINT_TEXT)
        for text, x in ((f"step {steps.min():.0f}", self.left), (f"{steps.max():.0f}", self.right - 40)):
            style.write(self.canvas, text, x, size[1] - 16, 0.4, style.FAINT_TEXT)

    def loss_y(self, losses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the rows of losses on the logarithmic axis."""
        share = (np.log10(losses) - self._low) / (self._high - self._low)
        rows: NDArray[np.float64] = self.bottom - share * (self.bottom - self.top)
        return rows

    def curve(
        self,
        steps: Sequence[float],
        rows: NDArray[np.float64],
        color: style.Color,
        *,
        width: int = 1,
        has_dots: bool = False,
    ) -> None:
        """Draw a curve through points of steps and rows."""
        x = self.left + (np.array(steps) - self._first) / self._span * (self.right - self.left)
        points = np.stack([x, rows], axis=1)
        style.polyline(self.canvas, points, color, width, is_closed=False)
        for point in points if has_dots else ():
            style.dot(self.canvas, point, 3.0, color)

    def legend(self, text: str, color: style.Color) -> None:
        """Write a further line to the right of the plot."""
        style.write(self.canvas, text, self.right + 30, self.top + 14 + 20 * self._num_lines, 0.4, color)
        self._num_lines += 1

    def percents(self) -> None:
        """Write a second axis, of shares, along the right side."""
        for share in (0.0, 0.5, 1.0):
            y = self.bottom - share * (self.bottom - self.top)
            style.write(self.canvas, f"{100.0 * share:.0f}", self.right + 4, y + 4, 0.35, _AP_COLOR)


def _running_mean(values: Sequence[float]) -> NDArray[np.float64]:
    """Average every value with its neighbors, a thirtieth of all, fewer at the ends."""
    reach = len(values) // 60
    sums = np.cumsum([0.0, *values])
    first = np.maximum(np.arange(len(values)) - reach, 0)
    end = np.minimum(np.arange(len(values)) + reach + 1, len(values))
    mean: NDArray[np.float64] = (sums[end] - sums[first]) / (end - first)
    return mean


def _title(text: str, width: int) -> style.Image:
    canvas = style.filled(_TITLE, width)
    style.write(canvas, text, 8, _TITLE - 8, 0.5)
    return canvas
