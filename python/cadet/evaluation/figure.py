"""Plots of precision over recall: a row for each class, a column for each metric, a line for each level."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util import style
from cadet.errors import CadetError
from cadet.evaluation.curve import ByLevel, Curve
from cadet.evaluation.limits import HEADING, METRICS
from cadet.figures.picture import check_picture_path, write_picture

_WIDTH: Final = 520
_LEFT, _TOP, _RIGHT, _BOTTOM = 58, 52, 502, 336
_BELOW: Final = 60
_HEADER: Final = 70
_TICKS: Final = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
_COLORS: Final[tuple[style.Color, ...]] = (
    (74, 222, 94),
    (64, 200, 255),
    (255, 170, 40),
    (255, 110, 200),
    (170, 140, 255),
    (240, 230, 120),
)
_TITLES: Final = {"2d": "2D", "bev": "bird's-eye view", "3d": "3D"}
_HEADING_TITLES: Final = {"2d": "AOS", "bev": "AHS", "3d": "AHS"}
_LEGEND_STEP: Final = 22


def write_figure(
    path: Path,
    heading: tuple[str, str],
    curves: ByLevel[Curve],
    num_levels: int,
    recall: str,
    min_overlap: Mapping[str, Mapping[str, float]],
) -> Path:
    """Draw the curves of a report into a PNG or JPEG file, as :func:`figure` does.

    Raises:
        CadetError: no class was evaluated, or the path names no picture in a folder that is there.
    """
    return write_picture(check_picture_path(path), figure(heading, curves, num_levels, recall, min_overlap))


def figure(
    heading: tuple[str, str],
    curves: ByLevel[Curve],
    num_levels: int,
    recall: str,
    min_overlap: Mapping[str, Mapping[str, float]],
) -> style.Image:
    """Draw the curves of a report.

    Args:
        heading: title and subtitle.
        curves: by class, metric and level.
        num_levels: the most levels of a panel, each a line of its legend.
        recall: "r40" or "r11", the mean that is written.
        min_overlap: the limits by class and metric.

    Returns:
        (70 + 462 x classes, 1560, 3) uint8 RGB with three levels.

    Raises:
        CadetError: no class was evaluated.
    """
    if not curves:
        raise CadetError("nothing to plot: no class was evaluated")
    height = _BOTTOM + _BELOW + _LEGEND_STEP * num_levels
    image = style.filled(_HEADER + height * len(curves), _WIDTH * len(METRICS))
    title, subtitle = heading
    style.write(image, title, 22, 32, 0.7)
    style.write(image, subtitle, 22, 56, 0.45, style.FAINT_TEXT)
    for row, (name, metrics) in enumerate(curves.items()):
        for column, metric in enumerate(METRICS):
            top = _HEADER + row * height
            panel = image[top : top + height, column * _WIDTH : (column + 1) * _WIDTH]
            style.write(panel, f"{name}, {_TITLES[metric]}", _LEFT, _TOP - 14, 0.52)
            _draw_axes(panel, f"overlap > {min_overlap[name][metric]:.2f}")
            if metric in metrics:
                _draw_curves(panel, metrics[metric], metrics.get(HEADING[metric], {}), metric, recall)
            else:
                style.write(panel, "not evaluated: no usable detection", _LEFT + 70, (_TOP + _BOTTOM) / 2, 0.45)
    return image


def _draw_axes(panel: style.Image, note: str) -> None:
    panel[_TOP:_BOTTOM, _LEFT:_RIGHT] = style.PANEL
    style.write(panel, note, _RIGHT - style.text_size(note, 0.4)[0], _TOP - 14, 0.4, style.FAINT_TEXT)
    for tick in _TICKS:
        (x, y), text = _place(tick, tick), f"{tick:.1f}"
        style.stroke(panel, (x, _TOP), (x, _BOTTOM), style.GRID)
        style.stroke(panel, (_LEFT, y), (_RIGHT, y), style.GRID)
        width, height = style.text_size(text, 0.36)
        style.write(panel, text, _LEFT - width - 7, y + height / 2, 0.36, style.FAINT_TEXT)
        style.write(panel, text, x - width / 2, _BOTTOM + 16, 0.36, style.FAINT_TEXT)
    style.write(panel, "recall", (_LEFT + _RIGHT) / 2 - 18, _BOTTOM + 33, 0.4, style.FAINT_TEXT)
    style.write(panel, "precision", 6, _TOP - 14, 0.4, style.FAINT_TEXT)


def _draw_curves(
    panel: style.Image, curves: Mapping[str, Curve], heading: Mapping[str, Curve], metric: str, recall: str
) -> None:
    """Draw a metric's curves and, dashed, those of its heading, with a legend."""
    legend_x = _LEFT + 44 + max(72, *(style.text_size(level, 0.42)[0] for level in curves))
    for index, (level, curve) in enumerate(curves.items()):
        color = _COLORS[index % len(_COLORS)]
        base = _BOTTOM + _BELOW - 4 + index * _LEGEND_STEP
        style.stroke(panel, (_LEFT, base - 5), (_LEFT + 24, base - 5), color, 2)
        style.write(panel, level, _LEFT + 32, base, 0.42)
        style.write(panel, f"AP {getattr(curve, recall):.2f}", legend_x, base, 0.42)
        if level in heading:
            _draw_dashed(panel, _points(heading[level]), color)
            text = f"{_HEADING_TITLES[metric]} {getattr(heading[level], recall):.2f} (dashed)"
            style.write(panel, text, legend_x + 90, base, 0.42, style.FAINT_TEXT)
        style.polyline(panel, _points(curve), color, 2, is_closed=False)


def _draw_dashed(panel: style.Image, points: NDArray[np.float64], color: style.Color) -> None:
    faint: style.Color = (color[0] * 3 // 4, color[1] * 3 // 4, color[2] * 3 // 4)
    # Dashes go on round corners: the line is cut by its whole length, not piece by piece.
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    for start in np.arange(0.0, lengths[-1], 9.0):
        ends = [[np.interp(at, lengths, points[:, axis]) for axis in (0, 1)] for at in (start, start + 5.0)]
        style.stroke(panel, ends[0], ends[1], faint)


def _points(curve: Curve) -> NDArray[np.float64]:
    """Place the samples that are reached; the line then falls to 0."""
    count = max(len(curve.scores), 1)
    points = [_place(index / 40.0, curve.precision[index]) for index in range(count)]
    if count < len(curve.precision):
        points.append(_place((count - 1) / 40.0, 0.0))
    return np.array(points)


def _place(recall: float, precision: float) -> tuple[float, float]:
    return _LEFT + recall * (_RIGHT - _LEFT), _TOP + (1.0 - precision) * (_BOTTOM - _TOP)
