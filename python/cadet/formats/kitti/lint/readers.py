"""What other programs' readers rely on beyond the format itself.

OpenPCDet and MMDetection3D count a frame's objects and take that many lines from the top of the label file, so a
DontCare region before an object takes its place. Both find a calibration's matrices by the number of their lines and
split lines at every single blank. OpenPCDet cannot read a label file
without a line, and divides by the camera frame's z.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti.calib import KEYS, ZERO_DEPTH_M, Calibration, is_at_zero_depth
from cadet.formats.kitti.files.calib_text import key_of_line
from cadet.formats.kitti.files.text import content_lines
from cadet.formats.kitti.label import Label
from cadet.formats.kitti.lint.finding import Problem, Severity

_RULE: Final = "other-readers"


def lint_label_lines(text: str, labels: tuple[Label, ...], soft: Severity) -> Iterator[Problem]:
    """Yield what makes other readers take the lines of a label file for others, or stop at them."""
    if not labels:
        yield Problem(None, _RULE, "no line: OpenPCDet cannot read an empty label file", soft)
        return
    yield from _blank_lines(text, soft)
    numbered = [(line, content, label) for (line, content), label in zip(content_lines(text), labels, strict=True)]
    first = next((line for line, _, label in numbered if label.is_dont_care), len(text))
    for line, content, label in numbered:
        if len(content.split(" ")) != len(content.split()):
            yield Problem(line, _RULE, "expected one blank between fields, as MMDetection3D does", soft)
        if line > first and not label.is_dont_care:
            message = f"{label.type} after the DontCare of line {first}: objects must come first, as in KITTI"
            yield Problem(line, _RULE, f"{message}; OpenPCDet and MMDetection3D take the DontCare for an object", soft)


def lint_calib_lines(text: str, soft: Severity) -> Iterator[Problem]:
    """Yield the lines of a calibration file that readers who count lines take for others."""
    lines = text.split("\n")
    keys = [key_of_line(line.strip()) for line in lines]
    for line, key in enumerate(KEYS, start=1):
        found = keys[line - 1] if line <= len(keys) else ""
        # A key that comes again is named wrong, but has the numbers that belong here.
        if found != key and keys.count(found) < 2:
            message = f"expected {key!r} here, as in KITTI: OpenPCDet and MMDetection3D find matrices by their line"
            yield Problem(line, _RULE, message, soft)
            return
        content = lines[line - 1].rstrip()
        if len(content.split(" ")) != len(content.split()):
            yield Problem(line, _RULE, "expected one blank between numbers, as OpenPCDet does", soft)


def _blank_lines(text: str, soft: Severity) -> Iterator[Problem]:
    lines = text.removesuffix("\n").split("\n")
    blank = next((line for line, content in enumerate(lines, start=1) if not content.strip()), None)
    if blank is not None:
        yield Problem(blank, _RULE, "a blank line: OpenPCDet and MMDetection3D stop at it", soft)


def lint_depths(points_velo: NDArray[np.float32], calib: Calibration, soft: Severity) -> Iterator[Problem]:
    """Yield a problem if a point's depth is 0."""
    num_zero = int(is_at_zero_depth(points_velo, calib).sum())
    if num_zero:
        limit = f"within {ZERO_DEPTH_M * 1e6:g} micrometers"
        yield Problem(
            None, _RULE, f"{num_zero} points with z = 0 in the cam frame ({limit}): OpenPCDet divides by it", soft
        )
