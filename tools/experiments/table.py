"""Tables of AP: as Markdown, and as plain values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from cadet.evaluation.curve import METRIC_TITLES
from tools.experiments.cells import GIVEN, LONGER, MIXED, REAL, SIM, TUNED
from tools.experiments.means import Group
from tools.experiments.outcome import LEVELS, METRICS, RULES
from tools.experiments.published import RULE, published_ap
from tools.experiments.scales import CLASSES, MAPS

TRAINED_TITLES: Final = {
    REAL: "real",
    SIM: "simulated",
    TUNED: "simulated, then real",
    GIVEN: "given weights",
    LONGER: "simulated, longer",
    MIXED: "simulated, then both",
}
"""What the ways of training are called, in the tables' order."""

_LEVELS: Final = {REAL: LEVELS["kitti"], SIM: LEVELS["large_small"]}
_FEW_LEVEL: Final = "Moderate"
FEW_RULE: Final = "r40"
"""The rule of the comparison by number of frames, which the paper does not have: KITTI's own since 2019."""


def tables(groups: Sequence[Group]) -> str:
    """Return all tables that the outcomes fill, as Markdown."""
    parts = [_matrix(groups, tested, rule) for tested in (REAL, SIM) for rule in RULES]
    return "\n".join(part for part in [*parts, _few(groups)] if part) or "No cell is finished.\n"


def plain_rows(groups: Sequence[Group]) -> list[dict[str, Any]]:
    """Return the means over seeds, each seed's own numbers, and the paper's, as plain values."""
    return [
        {
            "trained": group.trained,
            "tested": group.tested,
            "class": group.class_name,
            "maps": group.maps,
            "frames": group.frames,
            "seeds": [outcome.seed for outcome in group.outcomes],
            "steps": [outcome.step for outcome in group.outcomes],
            "num_frames": group.outcomes[0].num_frames,
            "ap": {metric: {level: _plain(group, metric, level) for level in _levels(group)} for metric in METRICS},
        }
        for group in groups
    ]


def published(group: Group, metric: str, level: str) -> float | None:
    """Return the paper's AP beside a group's: None of trainings on a few frames, which it does not have."""
    if group.frames is not None:
        return None
    return published_ap(group.trained, group.tested, group.class_name, group.maps, metric, level)


def few_frame_groups(groups: Sequence[Group], class_name: str, maps: str) -> list[Group]:
    """Return the trainings on a few real frames, and those before them, where there are any."""
    mine = [g for g in groups if (g.class_name, g.maps, g.tested) == (class_name, maps, REAL)]
    few = [group for group in mine if group.frames is not None]
    return [*few, *(g for g in mine if g.frames is None and g.trained in (SIM, GIVEN, LONGER))] if few else []


def _plain(group: Group, metric: str, level: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for rule in RULES:
        mean = group.ap(metric, level, rule)
        by_seed = [outcome.ap[metric][level][rule] for outcome in group.outcomes]
        found[rule] = {"mean": mean.value, "half_width_95": mean.half_width, "by_seed": by_seed}
    return found | {"paper": published(group, metric, level)}


def _levels(group: Group) -> list[str]:
    return [level for level in (*LEVELS["kitti"], *LEVELS["large_small"]) if level in group.has_levels]


def _matrix(groups: Sequence[Group], tested: str, rule: str) -> str:
    levels = _LEVELS[tested]
    rows = [["trained on", "class", "maps", *(f"{METRIC_TITLES[m]} {level}" for m in METRICS for level in levels)]]
    for trained in (REAL, SIM, TUNED):
        for class_name in CLASSES:
            for maps in MAPS:
                key = (trained, class_name, maps, None, tested)
                for group in groups:
                    if (group.trained, group.class_name, group.maps, group.frames, group.tested) == key:
                        cells = [_cell(group, metric, level, rule) for metric in METRICS for level in levels]
                        rows.append([TRAINED_TITLES[trained], class_name, maps, *cells])
    if len(rows) == 1:
        return ""
    where = "real" if tested == REAL else "simulated"
    note = ", the paper's in parentheses" if rule == RULE else ""
    return _markdown(f"AP {rule.upper()} in percent on {where} frames{note}", rows)


def _cell(group: Group, metric: str, level: str, rule: str) -> str:
    paper = published(group, metric, level) if rule == RULE else None
    return f"{group.ap(metric, level, rule)}{'' if paper is None else f' ({paper:.2f})'}"


def _few(groups: Sequence[Group]) -> str:
    titles = [METRIC_TITLES[metric] for metric in METRICS]
    rows = [["class", "maps", "real frames", "trained on", *titles, *(f"{title} gain" for title in titles)]]
    ways = list(TRAINED_TITLES)
    for class_name in CLASSES:
        for maps in MAPS:
            mine = few_frame_groups(groups, class_name, maps)
            for group in sorted(mine, key=lambda g: (g.frames or 0, ways.index(g.trained))):
                aps = [str(group.ap(metric, _FEW_LEVEL, FEW_RULE)) for metric in METRICS]
                # Beside as many steps on simulated frames, which are the same for all.
                bases = [g for g in mine if g.trained == LONGER and group.frames is not None]
                gains = [str(group.gain(g, metric, _FEW_LEVEL, FEW_RULE)) for g in bases for metric in METRICS]
                row = [class_name, maps, str(group.frames or 0), TRAINED_TITLES[group.trained], *aps]
                rows.append([*row, *(gains or [""] * len(METRICS))])
    if len(rows) == 1:
        return ""
    title = (
        f"AP {FEW_RULE.upper()} {_FEW_LEVEL} in percent by number of real frames; gains over {TRAINED_TITLES[LONGER]!r}"
    )
    return _markdown(title, rows)


def _markdown(title: str, rows: list[list[str]]) -> str:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["| " + " | ".join(map(str.ljust, row, widths)) + " |" for row in rows]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join([f"**{title}**", "", *lines, ""])
