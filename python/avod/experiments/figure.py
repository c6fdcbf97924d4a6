"""Figures of the experiments: the matrix as bars, the number of real frames as lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from avod.experiments.cells import REAL, SIM, TUNED
from avod.experiments.chart import Chart, place, sheet
from avod.experiments.means import Group
from avod.experiments.outcome import METRICS
from avod.experiments.published import RULE
from avod.experiments.scales import CLASSES, MAPS
from avod.experiments.statistics import Mean
from avod.experiments.table import FEW_RULE, TRAINED_TITLES, few_frame_groups, published
from cadet._util import style
from cadet.evaluation.curve import METRIC_TITLES

_LEVEL: Final = "Moderate"
_COLORS: Final[dict[str, style.Color]] = {REAL: (64, 200, 255), SIM: (255, 170, 40), TUNED: (74, 222, 94)}
_SCRATCH, _TUNED, _ALONE = _COLORS[REAL], _COLORS[TUNED], _COLORS[SIM]
# At the axes' ends: what lies on the first and on the last number of frames is seen whole.
_MARGIN: Final = 0.06


def matrix_figure(groups: Sequence[Group]) -> style.Image | None:
    """Draw AP Moderate on real frames as bars, a row for each class; the paper's as lines across them.

    Returns:
        (H, W, 3) uint8 RGB; None where no whole training was tested on real frames.
    """
    mine = [g for g in groups if g.frames is None and g.tested == REAL and g.trained in _COLORS]
    names = [name for name in CLASSES if any(group.class_name == name for group in mine)]
    if not names:
        return None
    legend = [*((TRAINED_TITLES[trained], color) for trained, color in _COLORS.items()), ("the paper", style.TEXT)]
    title = f"AP {RULE.upper()} {_LEVEL} on real frames in percent, by what was trained on"
    image = sheet(len(names), len(METRICS), title, legend)
    for row, name in enumerate(names):
        for column, metric in enumerate(METRICS):
            own = [group for group in mine if group.class_name == name]
            _bars(place(image, row, column), own, f"{name}, {METRIC_TITLES[metric]}", metric)
    return image


def few_frames_figure(groups: Sequence[Group]) -> style.Image | None:
    """Draw AP Moderate over the number of real frames, from scratch and tuned, and pre-trained alone.

    Returns:
        (H, W, 3) uint8 RGB; None where nothing was trained on a few frames.
    """
    pairs = [(name, maps) for name in CLASSES for maps in MAPS if few_frame_groups(groups, name, maps)]
    if not pairs:
        return None
    legend = [("from scratch", _SCRATCH), ("pre-trained, tuned", _TUNED), ("pre-trained alone (dashed)", _ALONE)]
    title = f"AP {FEW_RULE.upper()} {_LEVEL} in percent, by the number of real frames learned from"
    image = sheet(len(pairs), len(METRICS), title, legend)
    for row, (name, maps) in enumerate(pairs):
        for column, metric in enumerate(METRICS):
            title = f"{name}, {maps}, {METRIC_TITLES[metric]}"
            _lines(place(image, row, column), few_frame_groups(groups, name, maps), title, metric)
    return image


def _bars(canvas: style.Image, groups: Sequence[Group], title: str, metric: str) -> None:
    bars = {(group.maps, group.trained): (group.ap(metric, _LEVEL, RULE), _paper(group, metric)) for group in groups}
    chart = Chart(canvas, title, max(max(_top(ap), paper or 0.0) for ap, paper in bars.values()))
    names = [maps for maps in MAPS if any(group.maps == maps for group in groups)]
    for number, maps in enumerate(names):
        chart.label((number + 0.5) / len(names), maps)
        for index, (trained, color) in enumerate(_COLORS.items()):
            if (maps, trained) in bars:
                low = (number + 0.38 + 0.27 * (index - 1)) / len(names)
                chart.bar(low, low + 0.24 / len(names), bars[maps, trained][0], color, bars[maps, trained][1])


def _paper(group: Group, metric: str) -> float | None:
    return published(group, metric, _LEVEL)


def _lines(canvas: style.Image, groups: Sequence[Group], title: str, metric: str) -> None:
    aps = [(group, group.ap(metric, _LEVEL, FEW_RULE)) for group in groups]
    chart = Chart(canvas, title, max(_top(ap) for _, ap in aps))
    counts = sorted({group.frames for group in groups if group.frames is not None})
    for count in counts:
        chart.label(_share(count, counts), str(count))
    chart.label(0.5, "real frames", line=1)
    for trained, color in ((REAL, _SCRATCH), (TUNED, _TUNED)):
        points = [(_share(g.frames, counts), ap) for g, ap in aps if g.frames is not None and g.trained == trained]
        if points:
            chart.line(sorted(points, key=lambda point: point[0]), color)
    for group, ap in aps:
        if group.frames is None:
            chart.dashed(ap, _ALONE)


def _share(count: int, counts: Sequence[int]) -> float:
    """Place a number of frames on a logarithmic axis; a lone one in the middle."""
    if counts[0] == counts[-1]:
        return 0.5
    share = math.log(count / counts[0]) / math.log(counts[-1] / counts[0])
    return _MARGIN + (1.0 - 2.0 * _MARGIN) * share


def _top(ap: Mean) -> float:
    return ap.value + (ap.half_width or 0.0)
