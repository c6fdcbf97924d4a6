"""The analysis: what was asked for, from folders or memory to a result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from cadet._util.checks import as_seed, as_tuple, check_number, is_one_of, shown
from cadet.errors import CadetError
from cadet.evaluation.analysis.bins import ap_by, check_edges
from cadet.evaluation.analysis.bootstrap import FEW_GROUPS, Bootstrap, draw_frames, drawn_ap, intervals
from cadet.evaluation.analysis.box_errors import box_errors
from cadet.evaluation.analysis.centers import CenterAp, center_ap
from cadet.evaluation.analysis.class_errors import ClassErrors
from cadet.evaluation.analysis.comparison import Comparison, compare_draws
from cadet.evaluation.analysis.confusion import Confusion, confusion
from cadet.evaluation.analysis.groups import GroupSource, find_groups
from cadet.evaluation.analysis.mending import false_alarms_a_frame, mended_ap
from cadet.evaluation.analysis.operating import OperatingPoint, best_by_center, best_of_curve
from cadet.evaluation.analysis.result import PARTS, Analysis
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.curve import ByLevel
from cadet.evaluation.levels import Level
from cadet.evaluation.limits import CLASSES, MinOverlap
from cadet.evaluation.report import Report
from cadet.evaluation.run import EvalSettings, make_settings, report_of
from cadet.evaluation.sources import BOXES_2D, Chosen, DetectionSource, GroundTruthSource, Split, choose

DRAWS: Final = 1000
"""Of a bootstrap that was not given a number."""
MAX_DRAWS: Final = 100_000


def analyze(
    gt: GroundTruthSource,
    det: DetectionSource,
    det_b: DetectionSource | None = None,
    *,
    parts: Sequence[str] = PARTS,
    by: Mapping[str, Sequence[float] | None] | Sequence[str] = (),
    bootstrap: int = 0,
    groups: GroupSource = None,
    seed: int = 0,
    classes: Sequence[str | EvalClass] = CLASSES,
    recall: str = "r40",
    min_overlap: MinOverlap = "strict",
    levels: str | Sequence[Level] = "kitti",
    split: Split | None = None,
    frames: str = "results",
    boxes_2d: str = BOXES_2D[0],
) -> Analysis:
    """Evaluate detections and find out where AP is lost, how sure it is, and whether another detector does better.

    Args:
        gt: as for `evaluate`.
        det: as for `evaluate`.
        det_b: detections of a second detector, B, in the same frames; None for no comparison.
        parts: some of "operating" (the best thresholds), "errors" (AP without one error at a time, and the errors of
            boxes), "confusion" (of classes), and "centers" (nuScenes' AP and errors).
        by: some of "distance", "points" and "occlusion", or a dictionary from these to where bins begin, None for the
            usual ones. Points are counted in the scans beside the labels.
        bootstrap: how many draws of frames intervals are taken from; 0 for none. A comparison without takes 1000.
        groups: what is drawn as a whole: "frames", "episodes" of a generated dataset, a file with lines of an id and a
            group, or a dictionary alike; None for episodes where they are known, else frames.
        seed: of the draws.
        classes: as for `evaluate`.
        recall: as for `evaluate`.
        min_overlap: as for `evaluate`.
        levels: as for `evaluate`.
        split: as for `evaluate`.
        frames: as for `evaluate`.
        boxes_2d: as for `evaluate`.

    Returns:
        The result.

    Raises:
        KittiFormatError: a malformed line.
        MissingFileError: a folder or file that is not there.
        CadetError: an unknown name, a number out of range, or detections for different frames.
    """
    settings = make_settings(classes, recall, min_overlap, levels)
    wanted = as_tuple("", "parts", parts, "names")
    for name in wanted:
        if not is_one_of(name, PARTS):
            raise CadetError(f"parts: unknown {shown(name)}, expected some of {', '.join(PARTS)}")
    edges = _edges(by)
    check_number("", "bootstrap", bootstrap, 0, MAX_DRAWS, whole=True)
    seed = as_seed(seed)
    chosen = choose(gt, det, split, frames, boxes_2d)
    labels = chosen.labels
    report = report_of(chosen, settings, refuses_absent=True)
    if wanted or edges or bootstrap or det_b is not None:
        # From here on everything is computed from the same arrays.
        chosen = _in_memory(chosen)
    other = None if det_b is None else _other(choose(gt, det_b, split, frames, boxes_2d), chosen)
    intervals_of, comparison = _drawn(chosen, other, settings, report, int(bootstrap), groups, seed, labels)
    return Analysis(
        report=report,
        operating_points=_operating_points(report) if "operating" in wanted else None,
        errors=_errors(chosen, settings, report) if "errors" in wanted else None,
        by={name: ap_by(chosen, settings, name, edges[name], _scans(labels)) for name in edges},
        confusion=_confusion(chosen, settings) if "confusion" in wanted else None,
        centers=_centers(chosen, settings) if "centers" in wanted else None,
        bootstrap=intervals_of,
        comparison=comparison,
        notes=_notes(intervals_of, comparison),
    )


def _edges(by: Mapping[str, Sequence[float] | None] | Sequence[str]) -> dict[str, tuple[float, ...]]:
    if isinstance(by, Mapping):
        return {name: check_edges(name, edges) for name, edges in by.items()}
    names = (by,) if isinstance(by, str) else as_tuple("", "by", by, "names")
    return {name: check_edges(name, None) for name in names}


def _in_memory(chosen: Chosen) -> Chosen:
    truths, detections = chosen.loaded()
    return replace(chosen, truths=truths, detections=detections)


def _other(other: Chosen, chosen: Chosen) -> Chosen:
    if other.ids != chosen.ids:
        alone = sorted(set(chosen.ids) ^ set(other.ids))
        raise CadetError(
            f"detections of A and B are for different frames: {len(alone)} have results of only one, such as "
            f'{alone[0]}; count missing files as no detections (frames="all", --all-frames), or choose frames (split)'
        )
    return _in_memory(other)


def _scans(labels: Path | None) -> Path | None:
    return None if labels is None else labels.parent


def _operating_points(report: Report) -> ByLevel[OperatingPoint]:
    points: dict[str, dict[str, dict[str, OperatingPoint]]] = {}
    for name, metrics in report.curves.items():
        for metric in (metric for metric in ("2d", "bev", "3d") if metric in metrics):
            for level, curve in metrics[metric].items():
                best = best_of_curve(curve)
                if best is not None:
                    points.setdefault(name, {}).setdefault(metric, {})[level] = best
    return points


def _errors(chosen: Chosen, settings: EvalSettings, report: Report) -> dict[str, ClassErrors]:
    truths, detections = chosen.loaded()
    errors = {}
    for entry in (entry for entry in settings.classes if entry.name in report.ap):
        point = best_by_center(truths, detections, entry)
        errors[entry.name] = ClassErrors(
            mended=mended_ap(chosen, settings, entry),
            operating_point=point,
            false_alarms_a_frame=None if point is None else false_alarms_a_frame(*chosen.loaded(), entry, point.score),
            boxes=() if point is None else box_errors(truths, detections, entry, point.score),
        )
    return errors


def _confusion(chosen: Chosen, settings: EvalSettings) -> Confusion:
    truths, detections = chosen.loaded()
    points = {entry.name: best_by_center(truths, detections, entry) for entry in settings.classes}
    least = {name: point.score for name, point in points.items() if point is not None}
    return confusion(truths, detections, settings.classes, least)


def _centers(chosen: Chosen, settings: EvalSettings) -> dict[str, CenterAp]:
    found = {entry.name: center_ap(*chosen.loaded(), entry) for entry in settings.classes}
    return {name: result for name, result in found.items() if result is not None}


def _drawn(
    chosen: Chosen,
    other: Chosen | None,
    settings: EvalSettings,
    report: Report,
    num_draws: int,
    source: GroupSource,
    seed: int,
    labels: Path | None,
) -> tuple[Bootstrap | None, Comparison | None]:
    count = num_draws or (0 if other is None else DRAWS)
    if count == 0:
        if source is not None:
            raise CadetError("groups are drawn only by a bootstrap or a comparison; neither was asked for")
        return None, None
    groups = find_groups(source, chosen.ids, labels)
    draws = draw_frames(groups, count, seed)
    drawn = drawn_ap(chosen, settings, draws)
    own = intervals(report, drawn, groups, count, seed) if num_draws else None
    if other is None:
        return own, None
    reports = (report, report_of(other, settings))
    return own, compare_draws(reports, (drawn, drawn_ap(other, settings, draws)), groups, count, seed)


def _notes(intervals_of: Bootstrap | None, comparison: Comparison | None) -> tuple[str, ...]:
    drawn = intervals_of or comparison
    if drawn is None:
        return ()
    notes = []
    if drawn.num_units < FEW_GROUPS:
        notes.append(f"Only {drawn.num_units} {drawn.unit} are drawn from: intervals are too narrow to be trusted.")
    return tuple(notes)
