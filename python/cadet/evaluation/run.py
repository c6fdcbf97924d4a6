"""The evaluation: from folders or memory to a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cadet import _cadet
from cadet._util.checks import is_one_of, shown
from cadet.errors import CadetError
from cadet.evaluation.classes import EvalClass, resolve_classes
from cadet.evaluation.curve import METRIC_TITLES, ByLevel, Curve, by_level
from cadet.evaluation.levels import Level, resolve_levels
from cadet.evaluation.limits import CLASSES, HEADING, METRICS, MinOverlap
from cadet.evaluation.notes import notes_of
from cadet.evaluation.report import RECALLS, Report
from cadet.evaluation.sources import BOXES_2D, Chosen, DetectionSource, GroundTruthSource, Split, choose
from cadet.formats.kitti.label import TYPES


def evaluate(
    gt: GroundTruthSource,
    det: DetectionSource,
    *,
    classes: Sequence[str | EvalClass] = CLASSES,
    recall: str = "r40",
    min_overlap: MinOverlap = "strict",
    levels: str | Sequence[Level] = "kitti",
    split: Split | None = None,
    frames: str = "results",
    boxes_2d: str = BOXES_2D[0],
) -> Report:
    """Compute KITTI's average precision as the official program does, decision by decision.

    Args:
        gt: a folder of label files, or one that holds `label_2` or `training/label_2` (`testing/label_2` for the split
            "test"); or, in memory, a dictionary from frame ids to `GroundTruth` or labels, or a sequence of them.
        det: a folder of result files, or one that holds `data`; or `Detections` or labels with scores alike.
        classes: types of labels, KITTI's or others, or `EvalClass` objects.
        recall: "r40", the mean over recall 1/40, ..., 1 (KITTI's since October 2019), or "r11" over 0, 0.1, ..., 1.
        min_overlap: "strict" (KITTI's), "loose", or a dictionary that gives a class one limit, three (2D, BEV, 3D), or
            a dictionary by metric. An overlap must exceed it. `EvalClass` objects bring their own.
        levels: "kitti", "large_small", or `Level` objects.
        split: a list of `ImageSets` beside the labels, a file that holds one, or ids; None for every frame.
        frames: "results" evaluates the frames that have a result file, be it empty, as KITTI's offline program does;
            "all" counts a missing result file as a frame without detections.
        boxes_2d: "given", or "project": what a 3D box makes of itself in the image, by the calibrations beside the
            labels, takes the place of each detection's 2D box and alpha, and of an object's 2D box where it has none.

    Returns:
        The report. What KITTI leaves out, it lacks: a class without a detection that is usable in a metric has no such
        key, and AOS is absent for all classes if any detection of any class has alpha -10.

    Raises:
        KittiFormatError: a malformed line, named with file, line and column.
        MissingFileError: a folder, split or label file that is not there; no frame at all.
        CadetError: an unknown set or rule, or a class that is not KITTI's and that nothing there has.
    """
    settings = make_settings(classes, recall, min_overlap, levels)
    return report_of(choose(gt, det, split, frames, boxes_2d), settings, refuses_absent=True)


@dataclass(frozen=True)
class EvalSettings:
    """What to evaluate.

    Attributes:
        classes: the classes.
        recall: "r40" or "r11".
        levels: the levels.
    """

    classes: tuple[EvalClass, ...]
    recall: str
    levels: tuple[Level, ...]

    def core(self) -> dict[str, Any]:
        """Return the settings as the core takes them."""
        return {
            "classes": [entry.core() for entry in self.classes],
            "levels": [level.limits() for level in self.levels],
        }


def make_settings(
    classes: Sequence[str | EvalClass], recall: str, min_overlap: MinOverlap, levels: str | Sequence[Level]
) -> EvalSettings:
    """Check what `evaluate` was given.

    Raises:
        CadetError: an unknown class, set or rule.
    """
    if not is_one_of(recall, RECALLS):
        raise CadetError(f"recall: unknown rule {shown(recall)}, expected one of {', '.join(RECALLS)}")
    return EvalSettings(resolve_classes(classes, min_overlap), recall, resolve_levels(levels))


def report_of(chosen: Chosen, settings: EvalSettings, *, refuses_absent: bool = False) -> Report:
    """Evaluate frames that were chosen.

    Args:
        chosen: the frames.
        settings: what to evaluate.
        refuses_absent: raise an error where neither an object nor a detection has a class that is not KITTI's.
    """
    result = _cadet.evaluate(*chosen.sources(), **settings.core())
    if refuses_absent:
        _refuse_absent(settings.classes, result)
    least_px = min(level.min_height_px for level in settings.levels)
    names, recall, levels = tuple(entry.name for entry in settings.classes), settings.recall, settings.levels
    curves = _curves(result["curves"], names, levels)
    best: dict[str, dict[str, float]] = {}
    for raw in result["curves"]:
        best.setdefault(names[raw["class"]], {})[levels[raw["level"]].name] = raw["perfect"][recall]
    return Report(
        recall=recall,
        classes=settings.classes,
        min_overlap={entry.name: entry.limits() for entry in settings.classes},
        levels=levels,
        frames=chosen.frames,
        num_frames=len(chosen.ids),
        num_missing=chosen.num_missing,
        num_gt=result["num_truths"],
        num_detections=result["num_detections"],
        curves=curves,
        ap=by_level(curves, lambda curve: curve.r40 if recall == "r40" else curve.r11),
        n_gt=by_level(curves, lambda curve: curve.n_gt),
        n_thresholds=by_level(curves, lambda curve: len(curve.scores)),
        best_ap=best,
        warnings=notes_of(names, curves, best, recall, result, num_frames=len(chosen.ids), least_height_px=least_px),
    )


def _curves(raw_curves: list[dict[str, Any]], classes: tuple[str, ...], levels: tuple[Level, ...]) -> ByLevel[Curve]:
    found: dict[str, dict[str, dict[str, Curve]]] = {name: {} for name in classes}
    for raw in raw_curves:
        metrics = found[classes[raw["class"]]]
        metric, level = METRICS[raw["metric"]], levels[raw["level"]].name
        for key, values in ((metric, raw["precision"]), (HEADING[metric], raw["heading"])):
            if values is not None:
                metrics.setdefault(key, {})[level] = Curve(
                    precision=tuple(values["samples"]),
                    scores=tuple(raw["thresholds"]),
                    num_tp=tuple(raw["num_tp"]),
                    num_fp=tuple(raw["num_fp"]),
                    n_gt=raw["num_valid"],
                    r11=values["r11"],
                    r40=values["r40"],
                )
    return {
        name: {metric: metrics[metric] for metric in METRIC_TITLES if metric in metrics}
        for name, metrics in found.items()
        if metrics
    }


def _refuse_absent(classes: Sequence[EvalClass], result: Mapping[str, Any]) -> None:
    for entry in (classes[index] for index in result["absent_classes"]):
        if not set(entry.types) & set(TYPES):
            others = dict.fromkeys(name for name, _ in (*result["other_truths"], *result["other_detections"]))
            found = f"; they have {', '.join(others)}, and KITTI's" if others else "; all that they have is KITTI's"
            wanted = ", ".join(entry.types)
            raise CadetError(f"class {entry.name}: neither labels nor results have the type {wanted}{found}")
