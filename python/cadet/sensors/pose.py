"""Poses: where a thing stands and how it is turned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import check_array
from cadet._util.checks import check_number, check_three, make_plain, shown
from cadet.errors import CadetError

Row3: TypeAlias = tuple[float, float, float]
Row4: TypeAlias = tuple[float, float, float, float]

# x right, y down, z forward, in a frame of x forward, y left, z up.
_CAMERA_AXES = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
# Published quaternions carry a dozen digits; a typing error shows in the first few.
_UNIT_TOLERANCE = 1e-4
_FARTHEST_M = 1000.0


@dataclass(frozen=True, kw_only=True)
class Pose:
    """A place and a rotation in the frame of what carries it: all six degrees of freedom.

    Raises:
        CadetError: numbers out of range, or a quaternion that is not of length 1.
    """

    position_m: Row3 = (0.0, 0.0, 0.0)
    """The origin, meters."""
    quaternion_wxyz: Row4 = (1.0, 0.0, 0.0, 0.0)
    """The rotation: a unit quaternion, the real part first."""

    def __post_init__(self) -> None:
        check_three("Pose", "position_m", self.position_m, _FARTHEST_M)
        quaternion = self.quaternion_wxyz
        if not isinstance(quaternion, tuple) or len(quaternion) != 4:
            raise CadetError(f"Pose.quaternion_wxyz: expected four numbers, got {shown(quaternion)}")
        for number in quaternion:
            check_number("Pose", "quaternion_wxyz", number, -1.001, 1.001)
        if abs(math.hypot(*quaternion) - 1.0) > _UNIT_TOLERANCE:
            raise CadetError(f"Pose.quaternion_wxyz: expected a length of 1, got {math.hypot(*quaternion):.6g}")
        make_plain(self)

    @classmethod
    def of_angles(
        cls, position_m: Row3, *, roll_deg: float = 0.0, pitch_deg: float = 0.0, yaw_deg: float = 0.0
    ) -> Pose:
        """Return the pose of a sensor whose axes are x forward, y left, z up, such as a LIDAR.

        Args:
            position_m: its place in the ego's frame.
            roll_deg: about its own x axis, left side up.
            pitch_deg: then about y, nose down.
            yaw_deg: then about z, to the left.

        Raises:
            CadetError: an angle that is not a number from -180 to 180, or a bad place.
        """
        check_three("Pose", "roll_deg, pitch_deg, yaw_deg", (roll_deg, pitch_deg, yaw_deg), 180)
        return cls.from_matrix(_matrix(position_m, rotation_of_angles(roll_deg, pitch_deg, yaw_deg)))

    @classmethod
    def of_camera(
        cls, position_m: Row3, *, roll_deg: float = 0.0, pitch_deg: float = 0.0, yaw_deg: float = 0.0
    ) -> Pose:
        """Return the pose of a camera's frame: x right, y down, z forward; it looks ahead where all angles are 0.

        Raises:
            CadetError: as `of_angles`.
        """
        check_three("Pose", "roll_deg, pitch_deg, yaw_deg", (roll_deg, pitch_deg, yaw_deg), 180)
        return cls.from_matrix(
            _matrix(position_m, product(rotation_of_angles(roll_deg, pitch_deg, yaw_deg), _CAMERA_AXES))
        )

    @classmethod
    def from_matrix(cls, matrix: NDArray[np.float64]) -> Pose:
        """Return the pose of a (4, 4) or (3, 4) float64 matrix.

        Raises:
            ShapeError: another shape or dtype.
            CadetError: its first three columns are no rotation.
        """
        check_array(matrix, "matrix", (len(matrix), 4), np.float64, finite=True)
        r = matrix[:3, :3]
        if np.abs(r @ r.T - np.eye(3)).max() > _UNIT_TOLERANCE or np.linalg.det(r) <= 0.0:
            raise CadetError("Pose: expected a rotation in the matrix's first three columns")
        x, y, z = matrix[:3, 3].tolist()
        return cls(position_m=(x, y, z), quaternion_wxyz=quaternion_of(r))

    def matrix(self) -> NDArray[np.float64]:
        """Return the (4, 4) float64 matrix that takes points of this frame into the carrier's."""
        return _matrix(self.position_m, rotation_of_quaternion(self.quaternion_wxyz))

    def carried_by(self, carrier: NDArray[np.float64]) -> Pose:
        """Return the pose in the frame that the (4, 4) matrix `carrier` leads to."""
        return Pose.from_matrix(product(carrier, self.matrix()))


def rotation_of_angles(roll_deg: float, pitch_deg: float, yaw_deg: float) -> NDArray[np.float64]:
    """Return the (3, 3) rotation by roll about x, then pitch about y, then yaw about z."""
    (cr, sr), (cp, sp), (cy, sy) = (cos_sin(angle) for angle in (roll_deg, pitch_deg, yaw_deg))
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    return product(product(about_z, about_y), about_x)


# NumPy's products, inverses, sines and cosines differ in their last bits from processor to processor, and a sensor's
# pose goes into every byte that it sees. Python's floats are added and multiplied the same everywhere.


def product(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Multiply two matrices, (n, k) and (k, m), with the same bits on every processor."""
    rows, columns = a.tolist(), b.T.tolist()
    return np.array([[_dot(row, column) for column in columns] for row in rows], np.float64)


def inverse(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Invert an affine (4, 4) matrix, with the same bits on every processor."""
    (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = matrix.tolist()
    cofactors = (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
    determinant = _dot((a, b, c), [row[0] for row in cofactors])
    rows = [[number / determinant for number in row] for row in cofactors]
    return np.array([[*row, -_dot(row, (x, y, z))] for row in rows] + [[0.0, 0.0, 0.0, 1.0]], np.float64)


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    total = 0.0
    for p, q in zip(a, b, strict=True):
        total += p * q
    return total


def cos_sin(angle_deg: float) -> tuple[float, float]:
    """Return cosine and sine of an angle by their series about the nearest right angle."""
    quarters = round(angle_deg / 90.0)
    angle = math.radians(angle_deg - 90.0 * quarters)
    cosine, sine, term = 1.0, 0.0, 1.0
    # Up to pi / 4 the twentieth term is below 1e-20.
    for n in range(1, 20):
        term *= angle / n
        sign = -1.0 if n % 4 in (2, 3) else 1.0
        if n % 2:
            sine += sign * term
        else:
            cosine += sign * term
    return ((cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine))[quarters % 4]


def rotation_of_quaternion(quaternion_wxyz: Sequence[float]) -> NDArray[np.float64]:
    """Return the (3, 3) rotation of a quaternion of any length but 0."""
    length = math.sqrt(_dot(quaternion_wxyz, quaternion_wxyz))
    w, x, y, z = (number / length for number in quaternion_wxyz)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(rotation: NDArray[np.float64]) -> Row4:
    """Return the unit quaternion (w, x, y, z) of a (3, 3) rotation; of both, the one whose w is not negative."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    # Of four ways the one that divides by the largest number.
    squares = (1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i)
    largest = squares.index(max(squares))
    numbers = (
        (squares[0], h - f, c - g, d - b),
        (h - f, squares[1], b + d, c + g),
        (c - g, b + d, squares[2], f + h),
        (d - b, c + g, f + h, squares[3]),
    )[largest]
    sign = -1.0 if numbers[0] < 0.0 else 1.0
    length = math.sqrt(_dot(numbers, numbers))
    w, x, y, z = (sign * number / length for number in numbers)
    return w, x, y, z


def angles_of_rotation(rotation: NDArray[np.float64]) -> Row3:
    """Return roll, pitch, and yaw in radians of a (3, 3) rotation, as `rotation_of_angles` takes them in degrees.

    They have the same bits on every processor. Straight up or down, yaw is 0 as far as rounding allows.
    """
    (a, _, _), (d, _, _), (g, h, i) = rotation.tolist()
    return angle_of(i, h), angle_of(math.sqrt(a * a + d * d), -g), angle_of(a, d)


def angle_of(x: float, y: float) -> float:
    """Return the angle of (x, y) from the x axis in radians, -pi to pi, with the same bits on every processor."""
    if x == 0.0 and y == 0.0:
        return 0.0
    if abs(y) > abs(x):
        return math.copysign(math.pi / 2, y) - _arctangent(x / y)
    flat = _arctangent(y / x)
    return flat if x > 0.0 else flat + math.copysign(math.pi, y)


def _arctangent(ratio: float) -> float:
    """Return the arctangent of -1 to 1: halved three times, then by its series."""
    for _ in range(3):
        ratio = ratio / (1.0 + math.sqrt(1.0 + ratio * ratio))
    square, power, total = ratio * ratio, ratio, 0.0
    # Up to the tangent of pi / 32 the eleventh term is below 1e-22.
    for n in range(11):
        total += (power if n % 2 == 0 else -power) / (2 * n + 1)
        power *= square
    return 8.0 * total


def _matrix(position_m: Row3, rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = position_m
    return matrix
