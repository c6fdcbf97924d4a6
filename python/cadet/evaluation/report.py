"""What an evaluation finds."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from cadet._util.summary import summary
from cadet._util.text_tables import aligned, markdown
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.curve import METRIC_TITLES, ByLevel, Curve
from cadet.evaluation.levels import Level

RECALLS: Final[Mapping[str, str]] = {
    "r40": "mean over recall 1/40, 2/40, ..., 1",
    "r11": "mean over recall 0, 0.1, ..., 1",
}
"""How a curve becomes one number."""

_WARNINGS_SHOWN: Final = 5


@dataclass(frozen=True)
class Report:
    """Average precision by class, metric and level, and all that stands behind it.

    Metrics are "2d", "bev", "3d", "aos", "ahs_bev" and "ahs_3d". A class or metric that was not evaluated has no key.

    Attributes:
        ap: AP in percent, by class, metric and level.
        n_gt: objects that must be found, alike.
        n_thresholds: how many of the 41 recall positions are reached, alike.
        curves: whole curves, alike.
        best_ap: what a perfect result would get, by class and level: less than 100 for 40 objects or fewer.
        recall: "r40" or "r11".
        classes: the classes, each with its types, neighbors and limits.
        min_overlap: the limits by class and metric "2d", "bev" and "3d".
        levels: the levels.
        frames: the frame rule, "results" or "all".
        num_frames: frames that were evaluated.
        num_missing: frames without results: left out by the rule "results", without detections by the rule "all".
        num_gt: lines of ground truth in these frames.
        num_detections: detections in these frames.
        warnings: what a reader should know before comparing numbers.
    """

    ap: ByLevel[float]
    n_gt: ByLevel[int]
    n_thresholds: ByLevel[int]
    curves: ByLevel[Curve]
    best_ap: Mapping[str, Mapping[str, float]]
    recall: str
    classes: tuple[EvalClass, ...]
    min_overlap: Mapping[str, Mapping[str, float]]
    levels: tuple[Level, ...]
    frames: str
    num_frames: int
    num_missing: int
    num_gt: int
    num_detections: int
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        return summary(self, ", ".join(self.ap), recall=self.recall, num_frames=self.num_frames, num_gt=self.num_gt)

    def __str__(self) -> str:
        """Return the title, the table of AP and the first warnings."""
        lines = [self.title(), *aligned(self.table(), num_left=3), self.subtitle()]
        lines += [f"Note: {warning}" for warning in self.warnings[:_WARNINGS_SHOWN]]
        num_more = len(self.warnings) - _WARNINGS_SHOWN
        return "\n".join([*lines, f"... and {num_more} more: see warnings"] if num_more > 0 else lines)

    def to_json(self) -> str:
        """Return everything, whole curves too, as JSON; no limit is null."""
        return json.dumps(asdict(self), indent=1, allow_nan=False) + "\n"

    def to_markdown(self) -> str:
        """Return the title, a table and the warnings as Markdown."""
        lines = [f"**{self.title()}**", "", self.subtitle(), "", *markdown(self.table(), num_left=3)]
        lines += ["", *(f"* {warning}" for warning in self.warnings)] if self.warnings else []
        return "\n".join(lines) + "\n"

    def title(self) -> str:
        """Name what the numbers are."""
        return f"KITTI AP|{self.recall.upper()} in percent ({RECALLS[self.recall]})"

    def subtitle(self) -> str:
        """Name the frame rule, and what was compared."""
        if self.frames == "all":
            rule = f'frames="all": {self.num_frames} frames, {self.num_missing} of them without a result file'
        else:
            rule = f'frames="results": the {self.num_frames} frames that have a result file'
            rule += f", {self.num_missing} others left out" if self.num_missing else ""
        return f"{rule}; {self.num_gt} lines of ground truth, {self.num_detections} detections."

    def table(self) -> list[list[str]]:
        """Return the rows of the table of AP, its header first."""
        names = [level.name for level in self.levels]
        rows = [["Class", "Metric", "Overlap >", *names]]
        for name, metrics in self.ap.items():
            for metric, row in metrics.items():
                limit = self.min_overlap[name][_OVERLAP_OF.get(metric, metric)]
                values = [f"{row[level]:.2f}" for level in names]
                rows.append([name, METRIC_TITLES[metric], f"{limit:.2f}", *values])
            counts = next(iter(self.n_gt[name].values()))
            rows.append([name, "objects", "", *(str(counts[level]) for level in names)])
        return rows

    def plot(self, path: str | Path) -> Path:
        """Draw the curves, a row for each class and a column for each metric.

        Args:
            path: a PNG or JPEG file, in a folder that is there.

        Returns:
            The path.

        Raises:
            CadetError: there is nothing to draw, or the path names no picture.
        """
        from cadet.evaluation.figure import write_figure

        heading = (self.title(), self.subtitle())
        return write_figure(Path(path), heading, self.curves, len(self.levels), self.recall, self.min_overlap)


_OVERLAP_OF: Final = {"aos": "2d", "ahs_bev": "bev", "ahs_3d": "3d"}
