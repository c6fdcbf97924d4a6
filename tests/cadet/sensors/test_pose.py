from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest

from cadet import CadetError, Pose
from cadet.sensors.pose import angle_of, angles_of_rotation, inverse, product, quaternion_of, rotation_of_angles

IDENTITY = (1.0, 0.0, 0.0, 0.0)


def test_a_camera_ahead_looks_along_the_egos_x_axis_with_its_rows_down() -> None:
    pose = Pose.of_camera((1.5, 0.2, 1.6)).matrix()
    np.testing.assert_allclose(pose @ [0.0, 0.0, 10.0, 1.0], [11.5, 0.2, 1.6, 1.0], atol=1e-12)
    np.testing.assert_allclose(pose @ [1.0, 0.0, 0.0, 1.0], [1.5, -0.8, 1.6, 1.0], atol=1e-12)
    np.testing.assert_allclose(pose @ [0.0, 1.0, 0.0, 1.0], [1.5, 0.2, 0.6, 1.0], atol=1e-12)
    left = Pose.of_camera((0.0, 0.0, 0.0), yaw_deg=90).matrix()
    np.testing.assert_allclose(left @ [0.0, 0.0, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0], atol=1e-12)


def test_angles_have_the_signs_of_the_docstring() -> None:
    down = Pose.of_angles((0.0, 0.0, 1.7), pitch_deg=10).matrix()
    assert (down @ [1.0, 0.0, 0.0, 0.0])[2] == pytest.approx(-np.sin(np.radians(10)))
    left_up = Pose.of_angles((0.0, 0.0, 1.7), roll_deg=10).matrix()
    assert (left_up @ [0.0, 1.0, 0.0, 0.0])[2] == pytest.approx(np.sin(np.radians(10)))


def test_quaternions_and_matrices_say_the_same_for_any_rotation() -> None:
    """Against Rodrigues' formula: half turns, where the real part is 0, too."""
    rng = np.random.default_rng(0)
    for angle in (*rng.uniform(-np.pi, np.pi, 50), np.pi, 1e-9):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        expected = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        w, x, y, z = quaternion_of(expected)
        assert w >= 0.0
        np.testing.assert_allclose(Pose(quaternion_wxyz=(w, x, y, z)).matrix()[:3, :3], expected, atol=1e-12)


def test_carriers_come_first() -> None:
    carrier = Pose.of_angles((1.0, 0.0, 0.0), yaw_deg=90).matrix()
    carried = Pose(position_m=(2.0, 0.0, 0.5)).carried_by(carrier)
    assert carried.position_m == pytest.approx((1.0, 2.0, 0.5))
    np.testing.assert_allclose(carried.matrix()[:3, :3], rotation_of_angles(0, 0, 90), atol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Pose(quaternion_wxyz=(1.0, 0.1, 0.0, 0.0)), "expected a length of 1, got 1.00499"),
        (lambda: Pose(quaternion_wxyz=cast(Any, (1.0, 0.0))), "expected four numbers"),
        (lambda: Pose(position_m=(float("nan"), 0.0, 0.0)), "Pose.position_m"),
        (lambda: Pose.of_angles((0.0, 0.0, 0.0), yaw_deg=181), "expected a number from -180 to 180"),
        (lambda: Pose.from_matrix(np.diag([1.0, 1.0, -1.0, 1.0])), "expected a rotation"),
    ],
)
def test_nonsense_is_refused(make: Any, message: str) -> None:
    with pytest.raises(CadetError, match=message):
        make()


def test_angles_agree_with_the_standard_librarys_and_take_rotations_apart() -> None:
    rng = np.random.default_rng(1)
    places = [
        *rng.normal(size=(200, 2)),
        *rng.normal(size=(50, 2)) * [1e-9, 1.0],
        (1, 0),
        (0, 1),
        (-1, 0),
        (0, -1),
        (0, 0),
    ]
    for x, y in places:
        assert angle_of(float(x), float(y)) == pytest.approx(math.atan2(y, x), abs=2e-15)
    for roll, yaw in rng.uniform(-180.0, 180.0, (50, 2)):
        pitch = rng.uniform(-89.0, 89.0)
        found = angles_of_rotation(rotation_of_angles(roll, pitch, yaw))
        np.testing.assert_allclose(np.degrees(found), [roll, pitch, yaw], atol=1e-10)


def test_products_inverses_and_rotations_agree_with_numpys() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        roll, pitch, yaw = rng.uniform(-180.0, 180.0, 3)
        (cr, cp, cy), (sr, sp, sy) = (f(np.radians([roll, pitch, yaw])) for f in (np.cos, np.sin))
        about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        np.testing.assert_allclose(rotation_of_angles(roll, pitch, yaw), about_z @ about_y @ about_x, atol=1e-15)
        matrix = np.eye(4)
        matrix[:3] = rng.normal(size=(3, 4))
        np.testing.assert_allclose(product(matrix, inverse(matrix)), np.eye(4), atol=1e-10)
        np.testing.assert_allclose(product(matrix[:3], matrix), matrix[:3] @ matrix, atol=1e-13)
    for quarters in range(-2, 3):
        turned = rotation_of_angles(0.0, 0.0, 90.0 * quarters)
        assert set(np.abs(turned).ravel().tolist()) == {0.0, 1.0}, "right angles are exact"
