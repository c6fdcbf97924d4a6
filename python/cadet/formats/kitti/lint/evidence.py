"""The lint of what supports labels: the scan, the image's maps, and how these lie on each other.

A scan or a calibration of another frame shows in all of a frame's boxes at once. KITTI's own labels have boxes without
a return (2 % of those of 200 frames), but never a frame whose near, unhidden objects have none between them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti.boxes import points_in_boxes
from cadet.formats.kitti.calib import points_in_image
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.lint.finding import Problem, Severity
from cadet.formats.kitti.lint.labels import has_sensible_box
from cadet.formats.kitti.lint.lists import is_number

_MARGIN_M: Final = 0.2
"""Bumpers and mirrors stick out of annotators' boxes."""
_ROAD_M: Final = 0.3
"""Height of a box's lower end that is left out, less the margin: what lies there may be a return of the road."""
_NEAR_M: Final = 20.0
_MOST_TRUNCATED: Final = 0.3
_DEPTH_RATIO: Final = 1.1
"""Of the medians of depth map and scan. Parallax and the gaps of fences change single pixels alone."""
_FEWEST_POINTS: Final = 100

KindOfProblem = tuple[str, Problem]
"""The folder of the file, and what is wrong with it."""


def lint_evidence(frame: Frame, soft: Severity) -> Iterator[KindOfProblem]:
    """Yield what says that scan, labels, calibration, and maps of a frame do not belong together.

    Args:
        frame: the frame.
        soft: the severity of an object that nothing shows.
    """
    if not len(frame.points_velo):
        return
    points_cam = frame.calib.points_cam_from_velo(frame.points_velo)
    # Points of a damaged calibration: the calibration's own lint has found it.
    if not np.isfinite(points_cam).all():
        return
    is_in_image = points_in_image(points_cam, frame.calib, frame.image_size)
    if not is_in_image.any():
        message = f"none of {len(points_cam)} points falls into the image: is the calibration right?"
        yield "velodyne", Problem(None, "scan-off-image", message)
        return
    if frame.depth is not None:
        yield from _lint_depth_map(frame, frame.depth, points_cam[is_in_image])
    yield from _lint_objects(frame, points_cam, soft)


def _lint_objects(frame: Frame, points_cam: NDArray[np.float64], soft: Severity) -> Iterator[KindOfProblem]:
    places = [index for index, label in enumerate(frame.labels) if not label.is_dont_care and has_sensible_box(label)]
    if not places:
        return
    boxes_cam = np.stack([frame.labels[index].box_cam for index in places])
    boxes_cam[:, 1] -= _ROAD_M
    boxes_cam[:, 5] = np.maximum(boxes_cam[:, 5] - _ROAD_M, 0.0)
    num_points = points_in_boxes(points_cam, boxes_cam, _MARGIN_M).sum(axis=0)
    near = [n for index, n in zip(places, num_points, strict=True) if _must_have_points(frame, index)]
    if len(near) > 1 and not any(near):
        message = (
            f"no return in any of the {len(near)} unhidden boxes nearer than {_NEAR_M:.0f} m: another frame's scan?"
        )
        yield "velodyne", Problem(None, "scan-off-labels", message)
        return
    for index, number in zip(places, num_points, strict=True):
        if number == 0 and not _is_seen(frame, index):
            label = frame.labels[index]
            message = f"{label.type} at {label.location_cam}: no LIDAR return in the box"
            if frame.instance is not None or _record(frame, index) is not None:
                message += ", and no pixel of it in the image"
            yield "label_2", Problem(index + 1, "label-evidence", message, soft)


def _must_have_points(frame: Frame, index: int) -> bool:
    label = frame.labels[index]
    return (
        # A LIDAR that sees less far or less wide than KITTI's is no error where `meta` has counted so.
        (_record(frame, index) or {}).get("num_points") != 0
        and label.occluded == 0
        and 0.0 <= label.truncated <= _MOST_TRUNCATED
        and float(np.hypot(label.location_cam[0], label.location_cam[2])) < _NEAR_M
    )


def _is_seen(frame: Frame, index: int) -> bool:
    """Tell whether the instance map, or what `meta` says of the image, has a pixel of an object."""
    record = _record(frame, index)
    if record is None:
        return False
    actor_id = record.get("actor_id")
    if frame.instance is not None and isinstance(actor_id, int):
        left, top, right, bottom = frame.labels[index].bbox
        window = frame.instance[max(int(top), 0) : int(bottom) + 2, max(int(left), 0) : int(right) + 2]
        return bool((window == actor_id).any())
    visible = record.get("visible_pixels")
    return isinstance(visible, (int, float)) and is_number(visible) and visible > 0


def _record(frame: Frame, index: int) -> dict[str, Any] | None:
    """Return what `meta` says of a label's object; None where it says nothing."""
    objects = (frame.meta or {}).get("objects")
    if not isinstance(objects, list) or len(objects) != len(frame.labels):
        return None
    record = objects[index]
    return record if isinstance(record, dict) else None


def _lint_depth_map(
    frame: Frame, depth: NDArray[np.float32], points_cam: NDArray[np.float64]
) -> Iterator[KindOfProblem]:
    """Compare each return's depth with its pixel's."""
    columns, rows = np.rint(frame.calib.project(points_cam)).astype(np.intp).T
    depth_m = depth[np.clip(rows, 0, depth.shape[0] - 1), np.clip(columns, 0, depth.shape[1] - 1)]
    is_known = np.isfinite(depth_m) & (points_cam[:, 2] > 0.0)
    if is_known.sum() < _FEWEST_POINTS:
        return
    ratio = float(np.median(depth_m[is_known] / points_cam[is_known, 2]))
    if not 1.0 / _DEPTH_RATIO <= ratio <= _DEPTH_RATIO:
        message = f"depth is {ratio:.2f} times the scan's in the median of {int(is_known.sum())} pixels"
        yield "depth", Problem(None, "depth-off-scan", message)
