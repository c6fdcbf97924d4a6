"""Average precision of detectors and of a training's checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from avod.detector import Detector
from avod.predict import predict
from cadet import kitti
from cadet.errors import CadetError
from cadet.evaluation import Report, evaluate
from cadet.evaluation.limits import MinOverlap
from cadet.kitti import labels_from_text, text_from_labels


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


def evaluate_detector(
    detector: Detector,
    root: str | Path,
    ids: tuple[str, ...],
    *,
    levels: str = "kitti",
    min_overlap: MinOverlap = "strict",
    workers: int = 0,
    on_frame: Callable[[], None] = lambda: None,
) -> Report:
    """Run a detector over frames and compute KITTI's AP of what it would write.

    All frames count, those without an object too; AVOD's own evaluation leaves those out for cars.

    Args:
        detector: the detector.
        root: a KITTI folder with labels.
        ids: of the frames.
        levels: "kitti" or "large_small".
        min_overlap: as for `cadet.evaluate`.
        workers: processes that prepare frames.
        on_frame: hears of each frame that is done.
    """
    found = {}
    for frame_id, labels in predict(detector, root, ids, workers=workers):
        # Through text, so that the numbers are those of the files.
        found[frame_id] = labels_from_text(text_from_labels(labels))
        on_frame()
    truths = {frame_id: kitti.read_labels(root, frame_id) for frame_id in ids}
    return evaluate(truths, found, classes=detector.config.class_names, levels=levels, min_overlap=min_overlap)


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


def table(report: Report, class_names: tuple[str, ...]) -> list[list[str]]:
    """Return the paper's rows: for each class and recall rule, AP 3D and AP BEV by level; the header first."""
    names = [level.name for level in report.levels]
    rows = [["Class", "Recall", *(f"AP 3D {name}" for name in names), *(f"AP BEV {name}" for name in names)]]
    for class_name in class_names:
        metrics = report.curves.get(class_name, {})
        for rule in ("r11", "r40"):
            cells = [class_name, rule.upper()]
            for metric in ("3d", "bev"):
                curves = metrics.get(metric, {})
                cells += [f"{getattr(curves[name], rule):.2f}" if name in curves else "-" for name in names]
            rows.append(cells)
    return rows
