"""Overlaps and suppression as Python sees them; `crates/cadet_core/tests/box_iou.rs` holds the properties."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cadet import CadetError, NonFiniteError, ShapeError, box_iou_3d, box_iou_bev, nms_bev


def draw_boxes(count: int, seed: int) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    places = rng.uniform([-6, 1, 10], [6, 2, 22], (count, 3))
    return np.hstack([places, rng.uniform(0.5, 5.0, (count, 3)), rng.uniform(-4, 4, (count, 1))])


def opencv_intersection(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    # From above, rotation_y turns x toward -z; OpenCV turns its first axis toward its second.
    first, second = (((x, z), (length, width), -np.degrees(yaw)) for x, _, z, length, width, _, yaw in (a, b))
    _, points = cv2.rotatedRectangleIntersection(first, second)
    return 0.0 if points is None else cv2.contourArea(cv2.convexHull(points))


def test_it_agrees_with_opencv() -> None:
    a, b = draw_boxes(40, 1), draw_boxes(30, 2)
    bev, volume = box_iou_bev(a, b), box_iou_3d(a, b)
    assert bev.shape == volume.shape == (40, 30)
    assert (bev > 0.05).sum() > 100
    for i, j in np.ndindex(40, 30):
        shared = opencv_intersection(a[i], b[j])
        areas = [box[3] * box[4] for box in (a[i], b[j])]
        # OpenCV computes in single precision.
        assert bev[i, j] == pytest.approx(shared / (sum(areas) - shared), abs=2e-4)
        height = max(0.0, min(a[i, 1], b[j, 1]) - max(a[i, 1] - a[i, 5], b[j, 1] - b[j, 5]))
        volumes = [area * box[5] for area, box in zip(areas, (a[i], b[j]), strict=True)]
        assert volume[i, j] == pytest.approx(shared * height / (sum(volumes) - shared * height), abs=2e-4)


def test_equal_boxes_give_1() -> None:
    boxes = draw_boxes(500, 3)
    assert (np.diagonal(box_iou_bev(boxes, boxes)) == 1.0).all()
    assert (np.diagonal(box_iou_3d(boxes, boxes)) == 1.0).all()
    assert (box_iou_bev(boxes, boxes) == box_iou_bev(boxes, boxes).T).all()


def test_suppression_keeps_the_best_of_those_that_overlap() -> None:
    boxes = draw_boxes(300, 4)
    scores = np.round(np.random.default_rng(5).uniform(size=300), 1)
    kept = nms_bev(boxes, scores, 0.1)
    assert kept.dtype == np.int64
    assert 3 < len(kept) < 200
    order = np.argsort(-scores, kind="stable")
    expected: list[int] = []
    overlaps = box_iou_bev(boxes, boxes)
    for index in order:
        if all(overlaps[index, other] <= 0.1 for other in expected):
            expected.append(int(index))
    assert kept.tolist() == expected


def test_empty_and_single_precision_arrays_are_fine() -> None:
    none, some = np.zeros((0, 7)), draw_boxes(3, 6)
    assert box_iou_bev(none, some).shape == (0, 3)
    assert box_iou_3d(some, none).shape == (3, 0)
    assert nms_bev(none, np.zeros(0), 0.5).shape == (0,)
    single = some.astype(np.float32)
    assert (box_iou_bev(single, single) == box_iou_bev(single.astype(np.float64), single)).all()
    assert (box_iou_3d(some.tolist(), list(some)) == box_iou_3d(some, some)).all()
    scores = [0.1, 0.9, 0.5]
    assert nms_bev(some.tolist(), scores, 0.1).tolist() == nms_bev(some, np.array(scores), 0.1).tolist()
    assert (box_iou_bev(np.asfortranarray(some), some[::-1]) == box_iou_bev(some, some)[:, ::-1]).all()


def test_bad_input_is_refused() -> None:
    boxes = draw_boxes(4, 7)
    with pytest.raises(ShapeError, match=r"b: expected \(n, 7\)"):
        box_iou_bev(boxes, boxes[:, :6])
    with pytest.raises(NonFiniteError, match=r"a: not finite at \[2, 6\]"):
        box_iou_3d(np.where(np.arange(28).reshape(4, 7) == 20, np.nan, boxes), boxes)
    with pytest.raises(CadetError, match=r"boxes\[1\]"):
        nms_bev(np.where(np.arange(28).reshape(4, 7) == 10, -1.0, boxes), np.zeros(4), 0.5)
    with pytest.raises(ShapeError, match="scores"):
        nms_bev(boxes, np.zeros(3), 0.5)
    with pytest.raises(CadetError, match="threshold"):
        nms_bev(boxes, np.zeros(4), 1.5)
