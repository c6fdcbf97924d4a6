"""The lint of labels: each field against its definition.

KITTI's own labels were drawn by people and only roughly obey them; ours must obey them to the rounding of two decimals.
The lint therefore knows two measures. Loosely, a breach of the geometry is a warning, and these tolerances hold for
nearly all of KITTI's labels: overlap of `bbox` with the projected box 0.6 (KITTI's median is 0.97, 2 % lie below 0.6),
truncation 0.05 (its largest deviation but one is 0.03), alpha 0.1 rad (its largest is 0.08). Strictly, it is an error,
and the tolerance is what rounding every field to 0.01 can do to the projection of that very box.

A number of a damaged file may be anything finite. Every tolerance is therefore asked for as `not deviation <= limit`,
which is true of NaN.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from cadet.formats.kitti import boxes
from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.files.text import content_lines
from cadet.formats.kitti.label import Label
from cadet.formats.kitti.lint.finding import Problem, Severity

ROUNDING: Final = 0.0051
"""How far two decimals may be from the number."""

_LOOSE_IOU: Final = 0.6
_LOOSE_TRUNCATION: Final = 0.05
_LOOSE_ALPHA_RAD: Final = 0.1
_MAX_ROTATION_RAD: Final = 3.145
_MAX_SIZE_M: Final = 100.0
_MAX_PLACE_M: Final = 1000.0
_UNKNOWN_OCCLUSION: Final = 3
_DONT_CARE: Final = Label.in_image("DontCare", (0, 0, 0, 0))


def lint_labels(
    text: str, labels: tuple[Label, ...], calib: Calibration, image_size: tuple[int, int], *, strict: bool
) -> Iterator[Problem]:
    """Yield what is wrong with the lines of a label file.

    Args:
        text: the file's text.
        labels: its lines, read.
        calib: the frame's calibration.
        image_size: width and height of its image in pixels.
        strict: tight tolerances, and errors instead of warnings.
    """
    soft: Severity = "error" if strict else "warning"
    lines = [line for line, _ in content_lines(text)]
    scored = [line for line, label in zip(lines, labels, strict=True) if label.score is not None]
    if scored:
        message = f"{len(scored)} of {len(lines)} lines have a 16th field, a score: expected 15"
        yield Problem(scored[0], "dialect", message, soft)
    for line, label in zip(lines, labels, strict=True):
        bbox_problems = list(_lint_bbox(line, label, image_size, soft))
        yield from bbox_problems
        if label.is_dont_care:
            yield from _lint_dont_care(line, label)
            continue
        field_problems = list(_lint_fields(line, label, strict))
        yield from field_problems
        # What follows from a wrong field is not said again.
        if not field_problems and has_sensible_box(label):
            problems = _lint_geometry(line, label, calib, image_size, strict)
            yield from (one for one in problems if not (bbox_problems and one.rule == "label-projection"))


def _lint_bbox(line: int, label: Label, image_size: tuple[int, int], soft: Severity) -> Iterator[Problem]:
    left, top, right, bottom = label.bbox
    if left >= right or top >= bottom:
        yield Problem(line, "label-bbox", f"bbox {label.bbox} is empty", soft)
    elif min(left, top) < 0.0 or right > image_size[0] - 1 or bottom > image_size[1] - 1:
        limit = f"[0, {image_size[0] - 1}] x [0, {image_size[1] - 1}]"
        yield Problem(line, "label-bbox", f"bbox {label.bbox} leaves {limit}", soft)


def _lint_dont_care(line: int, label: Label) -> Iterator[Problem]:
    for name in ("truncated", "occluded", "alpha", "dimensions_hwl", "location_cam", "rotation_y"):
        value, wanted = getattr(label, name), getattr(_DONT_CARE, name)
        if value != wanted:
            yield Problem(line, "dont-care", f"DontCare: {name} is {value}, expected {wanted}")


def _lint_fields(line: int, label: Label, strict: bool) -> Iterator[Problem]:
    if not 0.0 <= label.truncated <= 1.0:
        yield Problem(line, "label-field", f"truncated {label.truncated}, expected 0..1")
    if label.occluded < 0:
        yield Problem(line, "label-field", f"occluded {label.occluded}, expected 0..3")
    elif strict and label.occluded == _UNKNOWN_OCCLUSION:
        yield Problem(line, "label-field", "occluded 3 (unknown), expected 0..2")
    height, width, length = label.dimensions_hwl
    if min(label.dimensions_hwl) <= 0.0:
        yield Problem(line, "label-field", f"dimensions h w l {label.dimensions_hwl} are not positive")
    elif max(label.dimensions_hwl) > _MAX_SIZE_M:
        yield Problem(
            line, "label-field", f"dimensions h w l {label.dimensions_hwl}, expected up to {_MAX_SIZE_M:.0f} m"
        )
    elif label.type == "Car" and length <= width:
        yield Problem(
            line, "label-field", f"a car {length} m long and {width} m wide: expected h w l, got {height} first"
        )
    if max(map(abs, label.location_cam)) >= _MAX_PLACE_M:
        yield Problem(line, "label-field", f"location {label.location_cam}, expected less than {_MAX_PLACE_M:.0f} m")
    for name in ("alpha", "rotation_y"):
        if abs(getattr(label, name)) > _MAX_ROTATION_RAD:
            yield Problem(line, "label-field", f"{name} {getattr(label, name)}, expected -pi..pi")


def has_sensible_box(label: Label) -> bool:
    """Tell whether box and angles are such that the geometry can be checked."""
    return (
        min(label.dimensions_hwl) > 0.0
        and max(label.dimensions_hwl) <= _MAX_SIZE_M
        and max(map(abs, label.location_cam)) < _MAX_PLACE_M
        and max(abs(label.alpha), abs(label.rotation_y)) <= _MAX_ROTATION_RAD
    )


def _lint_geometry(
    line: int, label: Label, calib: Calibration, image_size: tuple[int, int], strict: bool
) -> Iterator[Problem]:
    soft: Severity = "error" if strict else "warning"
    box_cam = label.box_cam[None]
    whole = boxes.project_boxes(box_cam, calib)
    if np.isnan(whole).any():
        yield Problem(line, "label-projection", f"the box at {label.location_cam} lies behind the camera", soft)
        return
    width_px, height_px = float(whole[0, 2] - whole[0, 0]), float(whole[0, 3] - whole[0, 1])
    if not (np.isfinite(whole).all() and width_px > 0.0 and height_px > 0.0):
        yield Problem(
            line, "label-projection", f"the box at {label.location_cam} has no image: is the calibration right?", soft
        )
        return
    expected = boxes.clip_boxes_img(whole, image_size)[0]
    rounding_px = _rounding_px(label, calib)
    deviation_px = float(np.abs(expected - label.bbox).max())
    iou = float(boxes.iou_img(expected[None], np.array([label.bbox], np.float64))[0])
    if not (deviation_px <= rounding_px if strict else iou >= _LOOSE_IOU):
        projected = ", ".join(f"{x:.2f}" for x in expected)
        message = f"bbox {label.bbox} is off the projected box ({projected}) by {deviation_px:.2f} px, IoU {iou:.2f}"
        yield Problem(line, "label-projection", message, soft)

    truncated = float(boxes.truncation(box_cam, calib, image_size)[0])
    border_px = float(min(*whole[0, :2], image_size[0] - 1 - whole[0, 2], image_size[1] - 1 - whole[0, 3]))
    is_whole = border_px > rounding_px
    rounding = ROUNDING + (0.0 if is_whole else 2.0 * rounding_px * (1.0 / width_px + 1.0 / height_px))
    if not abs(truncated - label.truncated) <= (rounding if strict else _LOOSE_TRUNCATION):
        yield Problem(line, "label-truncation", f"truncated {label.truncated}, expected {truncated:.2f}", soft)

    alpha = float(boxes.alpha_from_boxes(box_cam)[0])
    x, _, z = label.location_cam
    rounding = 2.0 * ROUNDING + 1.5 * ROUNDING / max(float(np.hypot(x, z)), boxes.NEAR_M)
    if not abs(float(boxes.wrap_angle(alpha - label.alpha))) <= (rounding if strict else _LOOSE_ALPHA_RAD):
        yield Problem(
            line, "label-alpha", f"alpha {label.alpha}, expected rotation_y - atan2(x, z) = {alpha:.2f}", soft
        )


def _rounding_px(label: Label, calib: Calibration) -> float:
    """Bound how far rounding every field of a label to 0.01 moves its projected box, in pixels."""
    _, width, length = label.dimensions_hwl
    turned = 0.5 * float(np.hypot(length, width))
    moved_m = ROUNDING * (float(np.sqrt(3.0)) + float(np.sqrt(1.5)) + turned)
    corners = boxes.corners_cam(label.box_cam[None])[0]
    near = np.maximum(corners[:, 2] - moved_m, boxes.NEAR_M)
    slope = np.linalg.norm(corners[:, :2], axis=1) / near
    focal = float(max(calib.P2[0, 0], calib.P2[1, 1]))
    return float((focal * moved_m / near * np.sqrt(1.0 + slope**2)).max()) + ROUNDING
