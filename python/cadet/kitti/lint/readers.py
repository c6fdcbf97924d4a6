"""What other programs' readers rely on beyond the format itself.

OpenPCDet and MMDetection3D count a frame's objects and take that many lines from the top of the label file, so a
DontCare region before an object takes its place. Both find a calibration's matrices by the number of their lines and
split lines at every single blank. MMDetection3D reads `occluded` as a whole number. OpenPCDet cannot read a label file
without a line, and divides by the camera frame's z.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.kitti.calib import KEYS, ZERO_DEPTH_M, Calibration, is_at_zero_depth
from cadet.kitti.label import Label
from cadet.kitti.lint.finding import Problem, Severity

_RULE: Final = "other-readers"


def lint_label_lines(text: str, labels: tuple[Label, ...], soft: Severity) -> Iterator[Problem]:
    """Yield what makes other readers take the lines of a label file for others, or stop at them."""
    if not labels:
        yield Problem(None, _RULE, "no line: OpenPCDet cannot read an empty label file", soft)
    for line, content in enumerate(text.split("\n")[: len(labels)], start=1):
        fields = content.strip().split(" ")
        if "" in fields or len(fields) != len(content.split()):
            yield Problem(line, _RULE, "expected one blank between fields, as MMDetection3D does")
        elif not fields[2].lstrip("-").isdigit():
            yield Problem(line, _RULE, f"occluded {fields[2]}: MMDetection3D expects a whole number without a point")
    first = next((line for line, label in enumerate(labels, start=1) if label.is_dont_care), len(labels) + 1)
    for line, label in enumerate(labels, start=1):
        if line > first and not label.is_dont_care:
            message = f"{label.type} after the DontCare of line {first}: objects must stand first, as in KITTI"
            yield Problem(line, _RULE, f"{message}; OpenPCDet and MMDetection3D take the DontCare for an object", soft)


def lint_calib_lines(text: str) -> Iterator[Problem]:
    """Yield the lines of a calibration file that readers who count lines take for others."""
    lines = text.split("\n")
    for line, key in enumerate(KEYS, start=1):
        content = lines[line - 1].rstrip() if line <= len(lines) else ""
        if content.split(" ")[0] != f"{key}:":
            message = f"expected {key!r} here, as in KITTI: OpenPCDet and MMDetection3D find matrices by their line"
            yield Problem(line, _RULE, message)
            return
        if "" in content.split(" ") or len(content.split(" ")) != len(content.split()):
            yield Problem(line, _RULE, "expected one blank between numbers, as OpenPCDet does")


def lint_depths(points_velo: NDArray[np.float32], calib: Calibration, soft: Severity) -> Iterator[Problem]:
    """Yield a problem if a point's depth is 0."""
    num_zero = int(is_at_zero_depth(points_velo, calib).sum())
    if num_zero:
        limit = f"within {ZERO_DEPTH_M * 1e6:g} micrometers"
        yield Problem(
            None, _RULE, f"{num_zero} points with z = 0 in the cam frame ({limit}): OpenPCDet divides by it", soft
        )
