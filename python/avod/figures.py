"""Figures: detections beside labels, and the curves of a training."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from avod.train.log import TERMS
from cadet.errors import CadetError
from cadet.kitti import Label
from cadet.kitti.frame import Frame
from cadet.view import bev_figure, boxes_figure, style

_MARGIN: Final = 12
_TITLE: Final = 26
_FEW_ROWS: Final = 10
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


def loss_figure(rows: Sequence[dict[str, float]], size: tuple[int, int] = (960, 480)) -> style.Image:
    """Draw the losses of a training over its steps, on a logarithmic scale, each a running mean over the rows around.

    Args:
        rows: of `log.csv`.
        size: width and height in pixels.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        CadetError: there are no rows.
    """
    if not rows:
        raise CadetError("the log has no rows to draw")
    canvas = style.filled(size[1], size[0])
    steps = np.array([row["step"] for row in rows])
    curves = {name: np.maximum(_running_mean([row[name] for row in rows]), 1e-6) for name in TERMS}
    low = np.floor(np.log10(min(values.min() for values in curves.values())))
    high = np.ceil(np.log10(max(values.max() for values in curves.values())))
    high = max(high, low + 1.0)
    left, right, top, bottom = 60, size[0] - 150, 20, size[1] - 40
    span = max(float(steps[-1] - steps[0]), 1.0)
    for decade in np.arange(low, high + 1.0):
        y = bottom - (decade - low) / (high - low) * (bottom - top)
        style.stroke(canvas, (left, y), (right, y), style.GRID)
        style.write(canvas, f"{10.0**decade:g}", 8, y + 4, 0.4, style.FAINT_TEXT)
    for text, x in ((f"step {steps[0]:.0f}", left), (f"{steps[-1]:.0f}", right - 40)):
        style.write(canvas, text, x, size[1] - 16, 0.4, style.FAINT_TEXT)
    for index, (name, values) in enumerate(curves.items()):
        color = style.TEXT if name == "total" else _CURVE_COLORS[index]
        points = np.stack(
            [
                left + (steps - steps[0]) / span * (right - left),
                bottom - (np.log10(values) - low) / (high - low) * (bottom - top),
            ],
            axis=1,
        )
        style.polyline(canvas, points, color, 2 if name == "total" else 1, is_closed=False)
        if len(points) < _FEW_ROWS:
            for point in points:
                style.dot(canvas, point, 3.0, color)
        style.write(canvas, f"{name} {values[-1]:.3g}", right + 10, top + 14 + 20 * index, 0.4, color)
    return canvas


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
