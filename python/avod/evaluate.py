"""Average precision of detectors and of a training's checkpoints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from avod.config import PathDropConfig
from avod.data.frames import Data, open_frames
from avod.detector import Detector
from avod.predict import predict_all
from cadet.errors import CadetError
from cadet.evaluation import Report
from cadet.evaluation.analysis import Analysis, analyze
from cadet.evaluation.analysis.tables import Section
from cadet.evaluation.limits import MinOverlap
from cadet.formats.kitti import Label, labels_from_text, text_from_labels
from cadet.formats.kitti.files.unreadable import Unreadable


@dataclass(frozen=True)
class Scored:
    """A checkpoint and how well it does.

    Attributes:
        path: its folder.
        report: of the evaluation.
        value: AP 3D of the second level (Moderate, or Small), R40, averaged over the classes; 0 for a class that was
            never found.
    """

    path: Path
    report: Report
    value: float


def evaluate_detector(detector: Detector, data: Data, ids: tuple[str, ...], **settings: Any) -> Report:
    """Run a detector over frames and compute KITTI's AP of what it would write; settings as for `analyze_detectors`."""
    return analyze_detector(detector, data, ids, **settings).report


def analyze_detector(detector: Detector, data: Data, ids: tuple[str, ...], **settings: Any) -> Analysis:
    """Run a detector over frames and analyze what it would write; settings as for `analyze_detectors`."""
    (analysis,) = analyze_detectors([detector], data, ids, **settings)
    return analysis


def analyze_detectors(
    detectors: Sequence[Detector],
    data: Data,
    ids: tuple[str, ...],
    *,
    parts: tuple[str, ...] = (),
    by: tuple[str, ...] = (),
    levels: str = "kitti",
    min_overlap: MinOverlap = "strict",
    recall: str = "r40",
    bootstrap: int = 0,
    workers: int = 0,
    on_frame: Callable[[], None] = lambda: None,
) -> list[Analysis]:
    """Run detectors over frames, each of which is read once, and analyze what they would write.

    Frames that cannot be read are left out with a warning, unless they are more than half.

    All frames count, those without an object too; AVOD's own evaluation leaves those out for cars.

    Args:
        detectors: one or more, whose inputs are the same.
        data: a KITTI folder with labels, shards, or "sim:" and a simulation's TOML file; open or not.
        ids: of the frames.
        parts: as for `cadet.analyze`.
        by: as for `cadet.analyze`, without points.
        levels: "kitti" or "large_small".
        min_overlap: as for `cadet.evaluate`.
        recall: as for `cadet.evaluate`.
        bootstrap: as for `cadet.analyze`.
        workers: processes that prepare frames.
        on_frame: called after each frame.
    """
    found: list[dict[str, tuple[Label, ...]]] = [{} for _ in detectors]
    frames = open_frames(data)
    unreadable = Unreadable(frames.folder)
    for frame_id, by_detector in predict_all(detectors, frames, ids, workers=workers, unreadable=unreadable):
        for results, labels in zip(found, by_detector, strict=True):
            # Through text, so that the numbers are those of the files.
            results[frame_id] = labels_from_text(text_from_labels(labels))
        on_frame()
    unreadable.say(len(ids))
    truths = {frame_id: frames.read_labels(frame_id) for frame_id in found[0]}
    names = detectors[0].config.class_names
    return [
        analyze(
            truths,
            results,
            parts=parts,
            by=by,
            classes=names,
            levels=levels,
            min_overlap=min_overlap,
            recall=recall,
            bootstrap=bootstrap,
        )
        for results in found
    ]


_METRICS: Final = {"3d": "AP 3D", "bev": "AP BEV"}
ABLATIONS: Final[Mapping[str, tuple[bool, bool]]] = {"image masked": (False, True), "LIDAR masked": (True, False)}
"""Whether (image, LIDAR) are left, by name."""


def without(detector: Detector, *, has_image: bool, has_lidar: bool) -> Detector:
    """Return a detector with the same network that one sensor's feature maps are hidden from.

    Both stages then see the other's crops alone, as path drop shows them in training, and points correct no boxes
    without the LIDAR. They still choose the anchors that are looked at, and the ground plane.

    Raises:
        CadetError: both sensors are left out, or the detector has no camera.
    """
    if not has_image and not has_lidar:
        raise CadetError("without image and LIDAR there is nothing to detect in")
    config = detector.config
    if not config.has_camera:
        raise CadetError("a center detector sees the LIDAR alone: there is no sensor to leave out")
    masked = copy(detector)
    # A modality that training never kept is not seen in detection.
    path_drop = PathDropConfig(keep_image=float(has_image), keep_bev=float(has_lidar))
    passes = config.refinement.passes if has_lidar else 0
    masked.config = replace(config, path_drop=path_drop, refinement=replace(config.refinement, passes=passes))
    return masked


def ablation(detector: Detector, data: Data, ids: tuple[str, ...], **settings: Any) -> dict[str, Analysis]:
    """Evaluate a detector again without each sensor.

    Args:
        detector: the detector.
        data: a KITTI folder with labels, shards, or "sim:" and a simulation's TOML file; open or not.
        ids: of the frames.
        settings: as for `analyze_detector`.

    Returns:
        Analyses by what was masked, with nuScenes' AP, which boxes of the wrong size or a little off have too.
    """
    analyses = {}
    for name, (has_image, has_lidar) in ABLATIONS.items():
        masked = without(detector, has_image=has_image, has_lidar=has_lidar)
        analyses[name] = analyze_detector(masked, data, ids, **{**settings, "parts": ("centers",), "by": ()})
    return analyses


def ablation_table(analyses: Mapping[str, Analysis], class_names: tuple[str, ...]) -> Section:
    """Tabulate AP 3D and BEV and nuScenes' mean AP by distance of centers, by what was masked."""
    levels = [level.name for level in next(iter(analyses.values())).report.levels]
    rows = [("Sensors", "Class", *(f"{what} {name}" for what in _METRICS.values() for name in levels), "AP centers")]
    for name, analysis in analyses.items():
        for class_name in class_names:
            found = analysis.report.ap.get(class_name, {})
            values = [found.get(metric, {}).get(level) for metric in _METRICS for level in levels]
            centers = (analysis.centers or {}).get(class_name)
            values.append(None if centers is None else centers.mean_ap)
            rows.append((name, class_name, *("-" if value is None else f"{value:.2f}" for value in values)))
    return Section("AP without a sensor", tuple(rows), num_left=2)


def score(report: Report, class_names: tuple[str, ...]) -> float:
    """Give a report the one number that checkpoints are chosen by (see `Scored.value`)."""
    level = report.levels[min(1, len(report.levels) - 1)].name
    curves = [report.curves.get(name, {}).get("3d", {}).get(level) for name in class_names]
    return sum(0.0 if curve is None else curve.r40 for curve in curves) / len(class_names)


def best(scored: list[Scored]) -> Scored:
    """Choose the checkpoint of the highest value; of equal ones the last, which has trained the longest.

    Raises:
        CadetError: there is none.
    """
    if not scored:
        raise CadetError("no checkpoint to choose from")
    return max(enumerate(scored), key=lambda item: (item[1].value, item[0]))[1]
