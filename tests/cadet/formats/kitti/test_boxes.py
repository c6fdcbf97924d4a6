from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cadet.errors import NonFiniteError, ShapeError
from cadet.formats.kitti import boxes
from synthetic import make_calib

AHEAD = -np.pi / 2
one_box = st.tuples(
    st.floats(-20, 20),
    st.floats(0, 3),
    st.floats(1, 60),
    st.floats(0.3, 15),
    st.floats(0.3, 3),
    st.floats(0.3, 4),
    st.floats(-4, 4),
).map(lambda numbers: np.array([numbers]))


def test_corners_of_a_car_that_drives_ahead() -> None:
    corners = boxes.corners_cam(np.array([[1.0, 1.6, 10.0, 4.0, 2.0, 1.5, AHEAD]]))[0]
    front_left, front_right, rear_right, rear_left = corners[:4]
    assert front_left == pytest.approx([0.0, 1.6, 12.0])
    assert front_right == pytest.approx([2.0, 1.6, 12.0])
    assert rear_right == pytest.approx([2.0, 1.6, 8.0])
    assert rear_left == pytest.approx([0.0, 1.6, 8.0])
    assert corners[4:] == pytest.approx(corners[:4] - [0.0, 1.5, 0.0])


@given(one_box)
def test_edges_have_the_boxs_sizes(box: NDArray[np.float64]) -> None:
    corners = boxes.corners_cam(box)[0]
    lengths = sorted(float(np.linalg.norm(corners[a] - corners[b])) for a, b in boxes.EDGES)
    assert lengths == pytest.approx(sorted([*box[0, 3:6]] * 4), rel=1e-6)


@given(one_box, st.integers(0, 2**32 - 1))
def test_mixtures_of_corners_are_inside_and_what_is_mirrored_out_is_not(box: NDArray[np.float64], seed: int) -> None:
    corners = boxes.corners_cam(box)[0]
    inside = np.random.default_rng(seed).dirichlet(np.ones(8), 50) @ corners
    assert boxes.points_in_boxes(inside, box, margin_m=1e-9).all()
    center = corners.mean(axis=0)
    outside = center + 2.001 * (corners - center)
    assert not boxes.points_in_boxes(outside, box).any()
    assert boxes.points_in_boxes(outside, box, margin_m=15.1).all()


@given(one_box)
def test_boxes_keep_center_size_and_heading_in_the_velo_frame(box: NDArray[np.float64]) -> None:
    calib = make_calib()
    box_velo = boxes.boxes_velo_from_cam(box, calib)[0]
    corners_velo = calib.points_velo_from_cam(boxes.corners_cam(box)[0])
    assert box_velo[:3] == pytest.approx(corners_velo.mean(axis=0), abs=1e-9)
    assert box_velo[3:6] == pytest.approx(box[0, 3:6])
    ahead = corners_velo[:2].sum(axis=0) - corners_velo[2:4].sum(axis=0)
    # The two frames are tilted by a fraction of a degree.
    assert boxes.wrap_angle(box_velo[6] - np.arctan2(ahead[1], ahead[0])) == pytest.approx(0.0, abs=0.02)


def test_a_car_ahead_has_yaw_zero_and_its_center_at_half_height() -> None:
    calib = make_calib()
    box_velo = boxes.boxes_velo_from_cam(np.array([[0.0, 1.65, 20.0, 4.0, 2.0, 1.5, AHEAD]]), calib)[0]
    assert box_velo[6] == pytest.approx(0.0)
    assert calib.points_cam_from_velo(box_velo[None, :3])[0] == pytest.approx([0.0, 0.9, 20.0])


def test_projected_boxes_bound_a_dense_sampling_of_what_lies_before_the_camera() -> None:
    calib = make_calib()
    rng = np.random.default_rng(1)
    share = np.linspace(0.0, 1.0, 8001)[:, None]
    num_cut = 0
    for _ in range(40):
        box = np.array(
            [[rng.uniform(-6, 6), 1.6, rng.uniform(-1, 9), rng.uniform(3, 12), 2.0, 1.6, rng.uniform(-3, 3)]]
        )
        corners = boxes.corners_cam(box)[0]
        edges = np.concatenate([corners[a] + share * (corners[b] - corners[a]) for a, b in boxes.EDGES])
        seen = edges[edges[:, 2] >= boxes.NEAR_M]
        projected = boxes.project_boxes(box, calib)[0]
        if not len(seen):
            assert np.isnan(projected).all()
            continue
        num_cut += len(seen) < len(edges)
        points_img = calib.project(seen)
        sampled = np.concatenate([points_img.min(axis=0), points_img.max(axis=0)])
        size = max(sampled[2] - sampled[0], sampled[3] - sampled[1])
        assert np.abs(projected - sampled).max() < 0.02 * size + 1e-9
        assert (projected[:2] <= sampled[:2] + 1e-9).all()
        assert (projected[2:] >= sampled[2:] - 1e-9).all()
    assert num_cut > 10


def test_truncation_of_a_board_that_the_left_edge_halves() -> None:
    calib = make_calib()
    # A thin board across the view at z = 10 m whose middle projects to u = 0.
    depth = 10.0 + 0.003
    x = (0.0 * depth - 309.5 * 10.0 - 23.0) / 360.0
    box = np.array([[x, 0.5, 10.0, 2.0, 1e-9, 1.0, 0.0]])
    assert boxes.truncation(box, calib, (620, 190)) == pytest.approx(0.5, abs=1e-6)
    assert boxes.truncation(box + [[8.0, 0, 0, 0, 0, 0, 0]], calib, (620, 190)) == pytest.approx(0.0, abs=1e-9)
    assert boxes.truncation(box - [[8.0, 0, 0, 0, 0, 0, 0]], calib, (620, 190)) == pytest.approx(1.0)
    assert np.isnan(boxes.truncation(box * [[1, 1, -1, 1, 1, 1, 1]], calib, (620, 190))).all()


def test_alpha_is_what_the_camera_sees_of_the_heading() -> None:
    seen = np.array(
        [[5.0, 1.6, 5.0, 4, 2, 1.5, 0.0], [0.0, 1.6, 5.0, 4, 2, 1.5, 3.0], [-5.0, 1.6, 5.0, 4, 2, 1.5, 3.0]]
    )
    assert boxes.alpha_from_boxes(seen) == pytest.approx([-np.pi / 4, 3.0, 3.0 + np.pi / 4 - 2 * np.pi])


def test_iou_of_known_rectangles() -> None:
    first = np.array([[0.0, 0, 2, 2], [0, 0, 1, 1], [0, 0, 4, 4]])
    second = np.array([[1.0, 0, 3, 2], [2, 2, 3, 3], [1, 1, 3, 3]])
    assert boxes.iou_img(first, second) == pytest.approx([1 / 3, 0.0, 0.25])


def test_no_boxes_give_empty_answers() -> None:
    none, calib = np.zeros((0, 7)), make_calib()
    assert boxes.corners_cam(none).shape == (0, 8, 3)
    assert boxes.project_boxes(none, calib).shape == (0, 4)
    assert boxes.truncation(none, calib, (620, 190)).shape == (0,)
    assert boxes.points_in_boxes(np.zeros((5, 3)), none).shape == (5, 0)


@pytest.mark.parametrize(
    ("array", "error", "message"),
    [
        (np.zeros((2, 6)), ShapeError, "boxes_cam: expected (M, 7) number, got (2, 6) float64"),
        (np.zeros(7), ShapeError, "boxes_cam: expected (M, 7) number, got (7,) float64"),
        (np.full((2, 7), np.nan), NonFiniteError, "boxes_cam: not finite at [0, 0]"),
        ([[0.0] * 6], ShapeError, "boxes_cam: expected (M, 7) number, got (1, 6) float64"),
        ("box", ShapeError, "boxes_cam: expected an array (M, 7) number, got str"),
    ],
)
def test_what_is_no_box_is_refused(array: NDArray[np.float64], error: type[Exception], message: str) -> None:
    with pytest.raises(error) as caught:
        boxes.corners_cam(array)
    assert str(caught.value) == message
