"""Encodings, projections and headings: round trips, hand-made cases, exhaustive angles."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from avod.geometry.encoding import (
    MIN_SIZE_M,
    anchors_from_boxes,
    anchors_from_offsets,
    boxes_4c_from_anchors,
    boxes_4c_from_boxes,
    boxes_from_4c,
    offsets_from_anchors,
)
from avod.geometry.orientation import angle_vectors, fix_up, wrap_angle
from avod.geometry.projection import bev_boxes, image_boxes
from cadet.bev import BevConfig
from cadet.evaluation import box_iou_3d
from cadet.formats.kitti import boxes as cadet_boxes
from synthetic import IMAGE_SIZE, make_calib

PLANE = torch.tensor([0.03, -0.998, 0.02, 1.7], dtype=torch.float64)


def some_boxes(seed: int, count: int = 400) -> torch.Tensor:
    rng = np.random.default_rng(seed)
    width = rng.uniform(0.4, 2.0, count)
    columns = [rng.uniform(-30, 30, count), rng.uniform(1, 2, count), rng.uniform(3, 60, count)]
    columns += [width + rng.uniform(0.05, 3, count), width, rng.uniform(1, 2.5, count)]
    columns.append(
        np.concatenate([np.arange(-180, 180, 15) * math.pi / 180, rng.uniform(-math.pi, math.pi, count - 24)])
    )
    return torch.from_numpy(np.column_stack(columns))


def test_boxes_come_back_from_corners_up_to_half_a_turn() -> None:
    boxes = some_boxes(0)
    back = boxes_from_4c(boxes_4c_from_boxes(boxes, PLANE), PLANE)
    torch.testing.assert_close(back[:, :6], boxes[:, :6], atol=1e-9, rtol=0)
    turn = wrap_angle(2.0 * (back[:, 6] - boxes[:, 6]))
    torch.testing.assert_close(turn, torch.zeros_like(turn), atol=1e-9, rtol=0)


def test_corners_are_those_of_the_box() -> None:
    boxes = some_boxes(1)
    encoded = boxes_4c_from_boxes(boxes, PLANE).numpy()
    expected = cadet_boxes.corners_cam(boxes.numpy())[:, :4, [0, 2]]
    for row, corners in zip(encoded, expected, strict=True):
        found = np.stack([row[:4], row[4:8]], axis=1)
        distance = np.linalg.norm(found[:, None] - corners[None], axis=2)
        assert (distance.min(axis=1) < 1e-9).all() and (distance.min(axis=0) < 1e-9).all()


def test_each_corner_is_nearest_to_its_fellow_of_the_box_turned_to_the_axes() -> None:
    boxes = some_boxes(2)
    boxes[:, 3] = boxes[:, 4] * 1.2  # nearly square, so that a turn of the order would show
    rest = boxes[:, 6] - torch.round(boxes[:, 6] / (math.pi / 2)) * (math.pi / 2)
    boxes = boxes[rest.abs() < math.radians(40)]
    turned = boxes_4c_from_boxes(boxes, PLANE)[:, :8].reshape(-1, 2, 4)
    upright = boxes_4c_from_anchors(anchors_from_boxes(boxes), PLANE)[:, :8].reshape(-1, 2, 4)
    total = (turned - upright).norm(dim=1).sum(dim=1)
    for shift in (1, 2, 3):
        assert (total <= (turned - upright.roll(shift, dims=2)).norm(dim=1).sum(dim=1) + 1e-9).all()


def test_an_anchors_heights_are_over_the_ground() -> None:
    flat = torch.tensor([0.0, -1.0, 0.0, 1.65])
    encoded = boxes_4c_from_anchors(torch.tensor([[2.0, 1.45, 10.0, 4.0, 1.5, 1.6]]), flat)
    expected = [4.0, 4.0, 0.0, 0.0, 10.8, 9.2, 9.2, 10.8, 0.2, 1.7]
    torch.testing.assert_close(encoded[0], torch.tensor(expected))


@pytest.mark.parametrize(
    ("degrees", "dx", "dz"), [(0, 4, 2), (44, 4, 2), (46, 2, 4), (-91, 2, 4), (136, 4, 2), (180, 4, 2)]
)
def test_boxes_turn_to_the_nearest_axis(degrees: float, dx: float, dz: float) -> None:
    box = torch.tensor([[1.0, 1.5, 20.0, 4.0, 2.0, 1.6, math.radians(degrees)]])
    torch.testing.assert_close(anchors_from_boxes(box), torch.tensor([[1.0, 1.5, 20.0, dx, 1.6, dz]]))


def test_anchor_offsets_come_back() -> None:
    generator = torch.Generator().manual_seed(0)
    anchors, targets = (torch.rand((50, 6), generator=generator, dtype=torch.float64) * 4 + 0.5 for _ in range(2))
    offsets = offsets_from_anchors(anchors, targets)
    torch.testing.assert_close(anchors_from_offsets(anchors, offsets), targets)
    assert torch.isfinite(anchors_from_offsets(anchors, offsets + 1e6)[:, 3:]).all()


def test_a_box_that_is_no_box_decodes_to_a_small_one() -> None:
    zero = boxes_from_4c(torch.zeros((1, 10)), torch.tensor([0.0, -1.0, 0.0, 1.65]))
    assert torch.isfinite(zero).all()
    assert zero[0, 3:6].tolist() == pytest.approx([MIN_SIZE_M] * 3)


def test_headings_end_within_45_degrees_of_the_angle_vector() -> None:
    degrees = torch.arange(-180.0, 180.0, 7.0, dtype=torch.float64)
    box, predicted = (grid.flatten().deg2rad() for grid in torch.meshgrid(degrees, degrees, indexing="ij"))
    boxes = torch.tensor([1.0, 1.6, 20.0, 4.0, 1.7, 1.5, 0.0], dtype=torch.float64).repeat(len(box), 1)
    boxes[:, 6] = box
    vectors = 0.3 * torch.stack([predicted.cos(), predicted.sin()], dim=1)
    fixed = fix_up(boxes, vectors)
    error = wrap_angle(fixed[:, 6] - predicted).abs().rad2deg()
    assert error.max() < 45.001
    assert (fixed[:, 6] >= -math.pi).all() and (fixed[:, 6] < math.pi).all()
    overlap = [
        box_iou_3d(a[None].numpy(), b[None].numpy())[0, 0] for a, b in zip(boxes[::17], fixed[::17], strict=True)
    ]
    np.testing.assert_allclose(overlap, 1.0, atol=1e-9)
    reference = wrap_angle(fix_up(boxes, vectors, is_reference=True)[:, 6] - predicted).abs().rad2deg()
    is_across = (wrap_angle(box - predicted).abs().rad2deg() - 90).abs() < 45
    assert (reference[is_across] > 135 - 1e-6).all(), "the original reverses headings there"
    torch.testing.assert_close(reference[~is_across], error[~is_across])


def test_angle_vectors_are_cosine_and_sine() -> None:
    boxes = torch.zeros((1, 7))
    boxes[0, 6] = 2.0
    torch.testing.assert_close(angle_vectors(boxes), torch.tensor([[math.cos(2.0), math.sin(2.0)]]))


def test_bev_boxes_are_fractions_from_the_far_left() -> None:
    found = bev_boxes(torch.tensor([[-40.0, 1.6, 70.0, 8.0, 1.5, 7.0]]), BevConfig())
    torch.testing.assert_close(found, torch.tensor([[-0.05, -0.05, 0.05, 0.05]]))


def test_image_boxes_bound_the_corners() -> None:
    calib = make_calib()
    rng = np.random.default_rng(0)
    anchors = np.column_stack(
        [rng.uniform(-20, 20, 50), rng.uniform(1, 2, 50), rng.uniform(6, 60, 50), rng.uniform(1, 5, (50, 3))]
    )
    found = image_boxes(torch.from_numpy(anchors), torch.from_numpy(calib.P2.copy()), IMAGE_SIZE)
    boxes_cam = np.column_stack([anchors[:, :3], anchors[:, 3], anchors[:, 5], anchors[:, 4], np.zeros(50)])
    left, top, right, bottom = cadet_boxes.project_boxes(boxes_cam, calib).T
    expected = np.stack(
        [top / IMAGE_SIZE[1], left / IMAGE_SIZE[0], bottom / IMAGE_SIZE[1], right / IMAGE_SIZE[0]], axis=1
    )
    np.testing.assert_allclose(found.numpy(), expected, atol=1e-12)


def test_image_boxes_behind_the_camera_are_finite_and_the_right_way_round() -> None:
    projection = torch.from_numpy(make_calib().P2.copy()).float().requires_grad_(False)
    anchors = torch.tensor([[1.0, 1.6, 0.25, 4.0, 1.5, 1.6], [0.0, 1.6, -3.0, 1.0, 1.5, 1.0]]).requires_grad_()
    found = image_boxes(anchors, projection, IMAGE_SIZE)
    assert torch.isfinite(found).all()
    assert (found[:, 2:] >= found[:, :2]).all()
    found.sum().backward()  # type: ignore[no-untyped-call]
    assert anchors.grad is not None and torch.isfinite(anchors.grad).all()
