"""Figures of the experiments: the matrix as bars, the number of real frames as lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from io import BytesIO
from typing import Any, Final

from matplotlib.figure import Figure

from cadet.evaluation.curve import METRIC_TITLES
from tools.experiments.cells import LONGER, MIXED, REAL, SIM, TUNED
from tools.experiments.means import Group, Mean
from tools.experiments.outcome import METRICS
from tools.experiments.published import RULE
from tools.experiments.scales import CLASSES, MAPS
from tools.experiments.table import FEW_RULE, TRAINED_TITLES, few_frame_groups, published

_LEVEL: Final = "Moderate"
_COLORS: Final = {REAL: "tab:blue", SIM: "tab:orange", TUNED: "tab:green"}
_FEW: Final = {
    REAL: ("from scratch", _COLORS[REAL]),
    TUNED: ("pre-trained, then real frames", _COLORS[TUNED]),
    MIXED: ("pre-trained, then both by turns", "tab:red"),
}
_SIZE_INCH: Final = (5.6, 3.6)
_BAR: Final = 0.27


def matrix_figure(groups: Sequence[Group]) -> Figure | None:
    """Draw AP Moderate on real frames as bars, a row for each class; the paper's as lines across them.

    Returns:
        The figure; None where no whole training was tested on real frames.
    """
    mine = [g for g in groups if g.frames is None and g.tested == REAL and g.trained in _COLORS]
    names = [name for name in CLASSES if any(group.class_name == name for group in mine)]
    if not names:
        return None
    figure, axes = _axes(len(names), f"AP {RULE.upper()} {_LEVEL} on real frames in percent, by what was trained on")
    for row, name in enumerate(names):
        for axis, metric in zip(axes[row], METRICS, strict=True):
            _bars(axis, [group for group in mine if group.class_name == name], metric)
            axis.set_title(f"{name}, {METRIC_TITLES[metric]}")
    return _with_legend(figure)


def few_frames_figure(groups: Sequence[Group]) -> Figure | None:
    """Draw AP Moderate over the number of real frames, from scratch, tuned, and mixed, and pre-trained alone.

    Returns:
        The figure; None where nothing was trained on a few frames.
    """
    pairs = [(name, maps) for name in CLASSES for maps in MAPS if few_frame_groups(groups, name, maps)]
    if not pairs:
        return None
    title = f"AP {FEW_RULE.upper()} {_LEVEL} in percent, by the number of real frames learned from"
    figure, axes = _axes(len(pairs), title)
    for row, (name, maps) in enumerate(pairs):
        for axis, metric in zip(axes[row], METRICS, strict=True):
            _lines(axis, few_frame_groups(groups, name, maps), metric)
            axis.set_title(f"{name}, {maps}, {METRIC_TITLES[metric]}")
    return _with_legend(figure)


def png_of(figure: Figure) -> bytes:
    """Return a figure as a PNG file, the same for the same figure."""
    file = BytesIO()
    figure.savefig(file, format="png", dpi=100, metadata={"Software": None})
    return file.getvalue()


def _axes(num_rows: int, title: str) -> tuple[Figure, Any]:
    width, height = _SIZE_INCH
    figure = Figure(figsize=(width * len(METRICS), height * num_rows), layout="constrained")
    figure.suptitle(title)
    axes = figure.subplots(num_rows, len(METRICS), squeeze=False)
    for axis in axes.flat:
        axis.grid(axis="y", alpha=0.3)
        axis.set_axisbelow(True)
    return figure, axes


def _with_legend(figure: Figure) -> Figure:
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize="small")
    return figure


def _bars(axis: Any, groups: Sequence[Group], metric: str) -> None:
    names = [maps for maps in MAPS if any(group.maps == maps for group in groups)]
    for index, (trained, color) in enumerate(_COLORS.items()):
        mine = [group for group in groups if group.trained == trained]
        places = [names.index(group.maps) + _BAR * (index - 1) for group in mine]
        aps = [group.ap(metric, _LEVEL, RULE) for group in mine]
        values, errors = [ap.value for ap in aps], _errors(aps)
        axis.bar(places, values, 0.9 * _BAR, yerr=errors, capsize=4, color=color, label=TRAINED_TITLES[trained])
        for place, group in zip(places, mine, strict=True):
            paper = published(group, metric, _LEVEL)
            if paper is not None:
                axis.hlines(paper, place - _BAR / 2, place + _BAR / 2, colors="black", linewidth=2)
    axis.plot([], [], color="black", linewidth=2, label="the paper")
    axis.set_xticks(range(len(names)), names)


def _lines(axis: Any, groups: Sequence[Group], metric: str) -> None:
    counts = sorted({group.frames for group in groups if group.frames is not None})
    for trained, (label, color) in _FEW.items():
        mine = sorted((g for g in groups if g.frames is not None and g.trained == trained), key=lambda g: g.frames or 0)
        aps = [group.ap(metric, _LEVEL, FEW_RULE) for group in mine]
        places, values = [group.frames for group in mine], [ap.value for ap in aps]
        if mine:
            axis.errorbar(places, values, _errors(aps), marker="o", capsize=4, color=color, label=label)
    for group in groups:
        if group.frames is None:
            ap = group.ap(metric, _LEVEL, FEW_RULE)
            label, style, color = (
                ("pre-trained, then simulated frames", ":", "black")
                if group.trained == LONGER
                else ("pre-trained alone", "--", _COLORS[SIM])
            )
            axis.axhline(ap.value, linestyle=style, color=color, label=label)
            if ap.half_width is not None:
                axis.axhspan(ap.value - ap.half_width, ap.value + ap.half_width, color=color, alpha=0.15)
    axis.use_sticky_edges = False
    axis.set_xscale("log")
    axis.set_xticks(counts, map(str, counts))
    axis.minorticks_off()
    axis.set_xlabel("real frames")
    axis.set_ylim(bottom=0.0)


def _errors(aps: Sequence[Mean]) -> list[float]:
    """Return half widths; NaN, which draws nothing, of a single seed."""
    return [math.nan if ap.half_width is None else ap.half_width for ap in aps]
