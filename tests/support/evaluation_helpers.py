"""Small result sets made by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from cadet.formats.kitti import Label, text_from_labels

DONT_CARE = Label("DontCare", -1, -1, -10, (300.0, 80.0, 320.0, 95.0), (-1, -1, -1), (-1000, -1000, -1000), -10)


def make_object(
    kind: str = "Car", column: int = 0, *, height_px: float = 60.0, occluded: int = 0, truncated: float = 0.0
) -> Label:
    """Make an object that overlaps none in another column."""
    left, x = 20.0 + 100.0 * column, -20.0 + 5.0 * column
    return Label(
        type=kind,
        truncated=truncated,
        occluded=occluded,
        alpha=0.25,
        bbox=(left, 100.0, left + 80.0, 100.0 + height_px),
        dimensions_hwl=(1.5, 1.75, 4.0),
        location_cam=(x, 1.5, 20.0),
        rotation_y=0.5,
    )


def detected(label: Label, score: float = 0.9, **changes: object) -> Label:
    """Detect an object, by default exactly."""
    return replace(label, score=score, **changes)  # type: ignore[arg-type]


def write(folder: Path, frames: Sequence[Sequence[Label]]) -> Path:
    """Write frames 000000, 000001, ... into a folder."""
    folder.mkdir(parents=True)
    for index, labels in enumerate(frames):
        (folder / f"{index:06d}.txt").write_text(text_from_labels(labels))
    return folder
