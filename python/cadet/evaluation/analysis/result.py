"""What an analysis finds: the report of AP, and all that was asked for besides."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

from cadet._util.summary import summary
from cadet.evaluation.analysis.bins import BinAp
from cadet.evaluation.analysis.bootstrap import Bootstrap
from cadet.evaluation.analysis.centers import CenterAp
from cadet.evaluation.analysis.class_errors import ClassErrors
from cadet.evaluation.analysis.comparison import Comparison, main_level
from cadet.evaluation.analysis.confusion import Confusion
from cadet.evaluation.analysis.operating import OperatingPoint
from cadet.evaluation.analysis.tables import (
    Section,
    bins_table,
    boxes_table,
    centers_table,
    comparison_table,
    confusion_table,
    intervals_table,
    mended_table,
    operating_table,
)
from cadet.evaluation.curve import ByLevel
from cadet.evaluation.report import Report

PARTS: Final = ("operating", "errors", "confusion", "centers")
"""What can be asked for by name, in the order of reports."""


@dataclass(frozen=True)
class Analysis:
    """AP, and its diagnosis. What was not asked for is None.

    Attributes:
        report: AP by KITTI's rules.
        operating_points: thresholds of the best F1 by class, metric and level; one where nothing was found has no key.
        errors: by class; one without detections has no key.
        by: AP bin by bin, by "distance", "points" or "occlusion"; empty if none was asked for.
        confusion: which class is taken for which.
        centers: nuScenes' AP and errors by class; one without objects within range has no key.
        bootstrap: intervals of AP.
        comparison: with a second set of detections.
        notes: what a reader should know.
    """

    report: Report
    operating_points: ByLevel[OperatingPoint] | None
    errors: Mapping[str, ClassErrors] | None
    by: Mapping[str, tuple[BinAp, ...]]
    confusion: Confusion | None
    centers: Mapping[str, CenterAp] | None
    bootstrap: Bootstrap | None
    comparison: Comparison | None
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return summary(self, ", ".join(self.report.ap), f"{self.report.num_frames} frames", parts=self.parts())

    def __str__(self) -> str:
        """Return the report, all tables and the notes as text."""
        return self.to_text()

    def parts(self) -> list[str]:
        """Name what was asked for."""
        names = ("operating_points", "errors", "by", "confusion", "centers", "bootstrap", "comparison")
        return [name for name in names if getattr(self, name)]

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain values: the report's, and a key for each part that was asked for."""
        values = asdict(self.report)
        for name in self.parts():
            values[name] = _plain(getattr(self, name))
        if self.notes:
            values["notes"] = list(self.notes)
        return values

    def to_json(self) -> str:
        """Return everything as JSON. Without a part it is the report's."""
        return json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"

    def sections(self) -> Iterator[Section]:
        """Yield the tables of what was asked for."""
        level = main_level(self.report)
        if self.operating_points is not None:
            yield operating_table(self.operating_points, level)
        for name, errors in (self.errors or {}).items():
            yield mended_table(name, errors, self.report, level)
            if errors.boxes:
                yield boxes_table(name, errors)
        for by, bins in self.by.items():
            yield bins_table(by, bins, self.report, level)
        if self.confusion is not None:
            yield confusion_table(self.confusion)
        if self.centers is not None:
            yield centers_table(self.centers)
        if self.bootstrap is not None:
            yield intervals_table(self.bootstrap)
        if self.comparison is not None:
            yield comparison_table(self.comparison)

    def to_text(self) -> str:
        """Return the report, all tables and the notes as text."""
        sections = (f"\n{section.to_text()}" for section in self.sections())
        return "\n".join([str(self.report), *sections, *(f"Note: {note}" for note in self.notes)])

    def to_markdown(self) -> str:
        """Return the report, all tables and the notes as Markdown."""
        sections = (section.to_markdown() for section in self.sections())
        return "\n".join([self.report.to_markdown(), *sections, *(f"* {note}\n" for note in self.notes)])


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    return asdict(value) if hasattr(value, "__dataclass_fields__") else value
