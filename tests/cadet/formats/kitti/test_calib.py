from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cadet.errors import CadetError, KittiFormatError, NonFiniteError, ShapeError
from cadet.formats.kitti import Calibration, points_in_image
from cadet.formats.kitti.boxes import project_boxes
from cadet.formats.kitti.files.dialects import collected
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
    with collected():
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


def edited(**lines: str | None) -> str:
    """Put other lines in place of some of a calibration's, by key; None leaves one out."""
    kept = {line.split(":")[0]: line for line in make_calib().to_text().splitlines()} | lines
    return "".join(f"{line}\n" for line in kept.values() if line is not None)


def numbers(key: str) -> str:
    return edited().split(f"{key}: ")[1].split("\n")[0]


def square(key: str) -> str:
    rows = np.eye(4)
    matrix = getattr(make_calib(), key)
    rows[: matrix.shape[0], : matrix.shape[1]] = matrix
    return " ".join(map(repr, rows.ravel().tolist()))


P2, TR, IMU, R0 = (numbers(key) for key in ("P2", "Tr_velo_to_cam", "Tr_imu_to_velo", "R0_rect"))
ODOMETRY = edited(R0_rect=None, Tr_imu_to_velo=None, Tr_velo_to_cam=f"Tr: {TR}")
BY_PLACE = edited(P0=f"P2: {P2}", P1=f"P2: {P2}", P3=f"P2: {P2}", Tr_imu_to_velo=f"Tr_velo_to_cam: {TR}")


@pytest.mark.parametrize(
    ("text", "unknown", "kinds"),
    [
        (edited(Tr_imu_to_velo=f"TR_imu_to_velo: {IMU}"), (), ["calib-key-Tr_imu_to_velo"]),
        (edited(Tr_imu_to_velo=None), ("Tr_imu_to_velo",), ["calib-missing-keys"]),
        (edited(Tr_imu_to_velo=f"Tr_imu_to_velo: {'0 ' * 12}"), ("Tr_imu_to_velo",), ["calib-zeros"]),
        (edited(P0=None, P1=None, P3=None), ("P0", "P1", "P3"), ["calib-missing-keys"]),
        (
            edited(R0_rect=f"R_rect {R0}", Tr_velo_to_cam=f"Tr_velo_cam {TR}", Tr_imu_to_velo=f"Tr_imu_velo {IMU}"),
            (),
            ["calib-key-R0_rect", "calib-key-Tr_velo_to_cam", "calib-key-Tr_imu_to_velo"],
        ),
        (edited(P2=f"p2 : {P2}", R0_rect=f"r0_rect={R0}"), (), ["calib-key-P2", "calib-key-R0_rect"]),
        (edited(Tr_velo_to_cam=f"tr_velodyne_to_cam:{TR}"), (), ["calib-key-Tr_velo_to_cam"]),
        (edited(P2=f"P2 {P2}"), (), []),
        (BY_PLACE, ("P0", "P1", "P3", "Tr_imu_to_velo"), ["calib-repeated-key"] * 2 + ["calib-missing-keys"]),
        (edited() + "calib_time: 09-Jan-2012 13:57:47\nP4: 1 2\n", (), ["calib-other-key"] * 2),
        (edited(P2=f"P2: {square('P2')}", R0_rect=f"R0_rect: {square('R0_rect')}"), (), ["calib-shape"] * 2),
        (edited(R0_rect=f"R0_rect: {' '.join(square('R0_rect').split()[:12])}"), (), ["calib-shape"]),
        ("\ufeff\n" + edited().replace(" ", "\t  ").replace("\n", " \r\n\r\n"), (), []),
        (edited().replace("\n", "\r"), (), []),
    ],
)
def test_dialects_are_read_and_said(text: str, unknown: tuple[str, ...], kinds: list[str]) -> None:
    with collected() as found:
        calib = Calibration.from_text(text, "c.txt")
    assert [one.kind for one in found] == kinds
    for key in SHAPES:
        expected = np.zeros(SHAPES[key]) if key in unknown else getattr(make_calib(), key)
        np.testing.assert_array_equal(getattr(calib, key), expected)
    with collected() as again:
        assert Calibration.from_text(calib.to_text()) == calib
    assert [one.kind for one in again] == ["calib-zeros"] * len(unknown)


def test_odometrys_tr_rectifies() -> None:
    with collected() as found:
        calib = Calibration.from_text(ODOMETRY)
    assert [one.kind for one in found] == ["calib-key-Tr_velo_to_cam", "calib-odometry", "calib-missing-keys"]
    np.testing.assert_array_equal(calib.cam_from_velo[:3], make_calib().Tr_velo_to_cam)
    with collected() as found:
        whole = Calibration.from_text(edited(Tr_velo_to_cam=f"Tr: {TR}"))
    assert (whole, [one.kind for one in found]) == (make_calib(), ["calib-key-Tr_velo_to_cam"])


@pytest.mark.parametrize("key", ["P2", "R0_rect", "Tr_velo_to_cam"])
def test_a_missing_matrix_that_is_used_is_named_with_a_remedy(key: str) -> None:
    with pytest.raises(KittiFormatError) as caught:
        Calibration.from_text(edited(**{key: None}), "calib/000007.txt")
    assert str(caught.value).startswith(f"calib/000007.txt: missing key '{key}': ")
    assert "it has P0, P1, " in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (edited(R0_rect="R0_rect: 1 " + R0), "c.txt:5: R0_rect: expected 9 numbers, got 10"),
        (edited(P1=f"P1: x{P2}"), f"c.txt:2: P1: expected a number, got 'x{P2.split()[0]}'"),
        (edited(P1="P1: nan" + " 0" * 11), "c.txt:2: P1: expected a finite number, got 'nan'"),
        (edited(P1=f"P2: 1{P2}"), "c.txt:3: P2 comes twice, with other numbers than in line 2: name lines 1 to 7"),
        (edited(P2=f"P2: {square('P2')[:-3]}7"), "c.txt:3: P2: expected 12 numbers, got 16"),
        (edited(P1=P2), f"c.txt:2: expected a key such as P2 and numbers, got '{P2[:37]}"),
        (
            "calib_time: 09-Jan-2012 13:57:47\nK_02: 1 2 3\nP_rect_02: 1 2 3\n",
            "c.txt: missing key 'P2': a calibration of KITTI's raw data? Write a file with P_rect_02 of",
        ),
        ("R: 1 0 0 0 1 0 0 0 1\nT: 0 0 0\n", "c.txt: missing key 'P2': a calibration of KITTI's raw data?"),
        (edited(Tr_velo_to_cam=f"Tr_cam_to_velo: {TR}"), "c.txt: missing key 'Tr_velo_to_cam': it brings the LIDAR's"),
        ("", "c.txt: missing key 'P2': it projects into image_2"),
    ],
)
def test_what_cannot_be_read_is_named_with_file_line_and_reason(text: str, message: str) -> None:
    with pytest.raises(KittiFormatError) as caught, collected():
        Calibration.from_text(text, "c.txt")
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("text", [b"P2: 1", None, 5, ["P2: 1"]])
def test_only_text_is_parsed(text: Any) -> None:
    with pytest.raises(CadetError, match=r"^text: expected a string, got "):
        Calibration.from_text(text)


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


def test_a_pinhole_camera_and_a_lidar_make_a_calibration() -> None:
    turn = np.deg2rad(5.0)
    # x right, y down, z forward of a camera that looks 5 degrees to the left of the LIDAR's x axis.
    rotation = np.array([[np.sin(turn), -np.cos(turn), 0.0], [0.0, 0.0, -1.0], [np.cos(turn), np.sin(turn), 0.0]])
    cam_from_velo = np.eye(4)
    cam_from_velo[:3] = np.column_stack([rotation, [0.1, -0.2, -0.3]])
    intrinsics = [[700.0, 0.0, 320.0], [0.0, 710.0, 240.0], [0.0, 0.0, 1.0]]
    calib = Calibration.from_pinhole(intrinsics, cam_from_velo)
    assert calib == Calibration.from_pinhole(np.array(intrinsics), cam_from_velo[:3].tolist())
    np.testing.assert_array_equal(calib.cam_from_velo, cam_from_velo)
    points_velo = np.random.default_rng(0).uniform([5, -3, -2], [40, 3, 2], (50, 3))
    x, y, z = rotation @ points_velo.T + np.array([[0.1], [-0.2], [-0.3]])
    pixels = calib.project(calib.points_cam_from_velo(points_velo))
    np.testing.assert_allclose(pixels, np.stack([700 * x / z + 320, 710 * y / z + 240], axis=1), rtol=1e-12)
    np.testing.assert_array_equal(calib.eye_cam, np.zeros(3))


@pytest.mark.parametrize(
    ("intrinsics", "pose", "message"),
    [
        (np.eye(4), np.eye(4), r"^K: expected \(3, 3\) number, got \(4, 4\)"),
        (np.eye(3) * 700.0, np.eye(4), r"^K: expected \[\[fx, 0, cx\], .*, got "),
        (np.diag([-700.0, 700.0, 1.0]), np.eye(4), "^K: expected "),
        (np.diag([700.0, 700.0, 1.0]), np.eye(3), r"^cam_from_velo: expected \(3 or 4, 4\) number, got \(3, 3\)"),
        (np.diag([700.0, 700.0, 1.0]), np.zeros((5, 4)), r"^cam_from_velo: expected \(3, 4\), or \(4, 4\) that ends"),
        (np.diag([700.0, 700.0, 1.0]), np.eye(4).T + np.eye(4, k=-3), r"^cam_from_velo: .* ends in 0, 0, 0, 1"),
        (np.diag([700.0, 700.0, 1.0]), np.diag([2.0, 1.0, 1.0, 1.0]), "^cam_from_velo: expected a rotation"),
        (np.diag([700.0, 700.0, 1.0]), np.diag([-1.0, 1.0, 1.0, 1.0]), "^cam_from_velo: expected a rotation"),
    ],
)
def test_what_is_no_pinhole_camera_is_refused(intrinsics: np.ndarray, pose: np.ndarray, message: str) -> None:
    with pytest.raises(CadetError, match=message):
        Calibration.from_pinhole(intrinsics, pose)
