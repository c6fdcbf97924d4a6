from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cadet.boxes import project_boxes
from cadet.errors import KittiFormatError, NonFiniteError, ShapeError
from cadet.kitti import Calibration, points_in_image
from synthetic import make_calib

SHAPES = {"P0": (3, 4), "P1": (3, 4), "P2": (3, 4), "P3": (3, 4), "R0_rect": (3, 3)} | {
    "Tr_velo_to_cam": (3, 4),
    "Tr_imu_to_velo": (3, 4),
}


@given(
    st.fixed_dictionaries(
        {name: arrays(np.float64, shape, elements=st.floats(-1e6, 1e6)) for name, shape in SHAPES.items()}
    ),
    st.booleans(),
)
def test_matrices_come_back_from_text_to_the_last_bit(matrices: dict[str, np.ndarray], has_blank_line: bool) -> None:
    calib = Calibration(**matrices, has_blank_line=has_blank_line)
    text = calib.to_text()
    back = Calibration.from_text(text)
    assert back == calib
    assert back.to_text() == text
    assert hash(back) == hash(calib)


def test_text_has_kittis_form() -> None:
    lines = make_calib().to_text().split("\n")
    assert lines[0].startswith("P0: 3.600000000000e+02 0.000000000000e+00 3.095000000000e+02 ")
    assert [line.split(":")[0] for line in lines] == [*SHAPES, ""]


def test_the_order_of_keys_does_not_matter() -> None:
    text = make_calib().to_text()
    assert Calibration.from_text("\n".join(reversed(text.split("\n")))) == make_calib()


@pytest.mark.parametrize("key", SHAPES)
def test_a_missing_key_is_named(key: str) -> None:
    text = "".join(f"{line}\n" for line in make_calib().to_text().split("\n") if not line.startswith(f"{key}:"))
    with pytest.raises(KittiFormatError) as caught:
        Calibration.from_text(text, "calib/000007.txt")
    assert str(caught.value) == f"calib/000007.txt: missing key '{key}'"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("R0_rect: ", "R0_rect: 1 ", "c.txt:5: R0_rect: expected 9 numbers, got 10"),
        ("P1: 3.6", "P1: x3.6", "c.txt:2: P1: could not convert string to float: 'x3.600000000000e+02'"),
        ("P1: 3.600000000000e+02", "P1: nan", "c.txt:2: P1: expected finite numbers"),
        ("P1: ", "P0: ", "c.txt:2: key 'P0' appears twice"),
        (
            "P1: ",
            "Q1: ",
            "c.txt:2: unknown key 'Q1', expected P0, P1, P2, P3, R0_rect, Tr_velo_to_cam, Tr_imu_to_velo",
        ),
        ("P1: ", "P1 ", "c.txt:2: unknown key 'P1', expected P0, P1, P2, P3, R0_rect, Tr_velo_to_cam, Tr_imu_to_velo"),
    ],
)
def test_a_malformed_line_is_named_with_file_line_and_reason(old: str, new: str, message: str) -> None:
    with pytest.raises(KittiFormatError) as caught:
        Calibration.from_text(make_calib().to_text().replace(old, new, 1), "c.txt")
    assert str(caught.value) == message


def test_matrices_of_the_wrong_kind_are_refused() -> None:
    fields: dict[str, Any] = {name: np.zeros(shape) for name, shape in SHAPES.items()}
    with pytest.raises(ShapeError) as caught:
        Calibration(**fields | {"P2": np.zeros((3, 3))})
    assert str(caught.value) == "P2: expected (3, 4) float64, got (3, 3) float64"
    with pytest.raises(ShapeError) as caught:
        Calibration(**fields | {"P2": np.zeros((3, 4), np.float32)})
    assert str(caught.value) == "P2: expected (3, 4) float64, got (3, 4) float32; convert with .astype(np.float64)"
    with pytest.raises(NonFiniteError) as infinite:
        Calibration(**fields | {"P2": np.full((3, 4), np.inf)})
    assert str(infinite.value) == "P2: not finite at [0, 0]"


def test_a_calibration_cannot_be_changed() -> None:
    matrix = np.zeros((3, 4))
    fields: dict[str, Any] = {name: np.zeros(shape) for name, shape in SHAPES.items()}
    calib = Calibration(**fields | {"P0": matrix})
    matrix[:] = 7.0
    assert not calib.P0.any()
    for array in (calib.P2, make_calib().cam_from_velo, make_calib().velo_from_cam):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0


def test_velo_to_cam_rectifies_after_moving() -> None:
    calib = make_calib()
    point = np.array([12.0, -3.0, 0.5])
    moved = [
        sum(calib.Tr_velo_to_cam[row, k] * point[k] for k in range(3)) + calib.Tr_velo_to_cam[row, 3]
        for row in range(3)
    ]
    expected = [sum(calib.R0_rect[row, k] * moved[k] for k in range(3)) for row in range(3)]
    points_velo = np.array([[*point, 0.4]], np.float64)
    assert calib.points_cam_from_velo(points_velo)[0] == pytest.approx(expected, abs=1e-12)
    assert calib.points_velo_from_cam(calib.points_cam_from_velo(points_velo))[0] == pytest.approx(point, abs=1e-12)


def test_project_uses_the_fourth_column_and_has_no_image_of_what_is_behind() -> None:
    calib = make_calib()
    points_img = calib.project(np.array([[1.0, 0.5, 10.0], [0.0, 0.0, -5.0]]))
    depth = 10.0 + 0.003
    assert points_img[0] == pytest.approx([(360.0 + 3095.0 + 23.0) / depth, (180.0 + 900.0 + 0.1) / depth])
    assert np.isnan(points_img[1]).all()


def test_points_too_far_away_for_a_number_have_no_image_and_no_warning() -> None:
    far = np.array([[-1000.0, -1000.0, 1e308], [1e308, 0.0, 1e308], [1e308, 1e308, 1.0]])
    assert not np.isfinite(make_calib().project(far)[1:]).all(axis=1).any()
    assert not points_in_image(far[1:], make_calib(), (1242, 375)).any()
    boxes_cam = np.array([[-1000.0, -1000.0, 1e308, 3.9, 1.6, 1.5, 0.0]])
    assert project_boxes(boxes_cam, make_calib()).shape == (1, 4)


def test_points_need_three_columns() -> None:
    with pytest.raises(ShapeError, match=r"^points_velo: expected \(N, 3\) or wider, got \(4, 2\)$"):
        make_calib().points_cam_from_velo(np.zeros((4, 2)))


def test_points_in_image_agrees_with_the_filter_written_out_point_by_point() -> None:
    calib, (width, height) = make_calib(), (620, 190)
    points_cam = np.random.default_rng(0).uniform([-30, -5, -10], [30, 5, 60], (3000, 3))
    expected = []
    for x, y, z in points_cam:
        a, b, c = (row[0] * x + row[1] * y + row[2] * z + row[3] for row in calib.P2)
        expected.append(bool(z > 0 and 0 < a / c < width and 0 < b / c < height))
    assert 300 < sum(expected) < 2700
    assert points_in_image(points_cam, calib, (width, height)).tolist() == expected


def test_the_images_borders_are_outside() -> None:
    projection = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0]])
    fields: dict[str, Any] = dict.fromkeys(SHAPES, projection)
    calib = Calibration(**fields | {"R0_rect": np.eye(3)})
    points_cam = np.array(
        [[0, 2, 1], [4, 2, 1], [2, 0, 1], [2, 3, 1], [2, 2, 0], [2, 2, -1], [1e-9, 1e-9, 1], [3.99, 2.99, 1]]
    )
    assert points_in_image(points_cam, calib, (4, 3)).tolist() == [False] * 6 + [True] * 2
    assert points_in_image(np.zeros((0, 3)), calib, (4, 3)).shape == (0,)


def test_old_names_of_the_transforms_warn_and_work() -> None:
    calib = make_calib()
    points = np.array([[10.0, 1.0, -1.0], [25.0, -3.0, 0.5]])
    with pytest.warns(DeprecationWarning, match=r"^Calibration\.velo_to_cam is now Calibration\.points_cam_from_velo"):
        points_cam = calib.velo_to_cam(points)
    with pytest.warns(DeprecationWarning, match=r"^Calibration\.cam_to_velo is now Calibration\.points_velo_from_cam"):
        points_velo = calib.cam_to_velo(points_cam)
    np.testing.assert_array_equal(points_cam, calib.points_cam_from_velo(points))
    np.testing.assert_allclose(points_velo, points, atol=1e-9)
