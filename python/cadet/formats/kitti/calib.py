"""KITTI's `calib` files."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadet._util.arrays import as_array, check_array
from cadet._util.checks import check_image_size, check_kind, check_text, shown
from cadet._util.summary import summary
from cadet.errors import CadetError, ShapeError
from cadet.formats.kitti.files.calib_text import SHAPES, matrices_from_text
from cadet.formats.kitti.files.numbers import scientific_text

KEYS: Final = tuple(SHAPES)
"""The keys of a calibration file in the order of KITTI's lines."""

ZERO_DEPTH_M: Final = 2.5e-7
"""A depth that single precision may take for 0: what rounding makes of sums of matrix elements times coordinates."""

_NEAR_ZERO_M: Final = 0.01
"""Far more than single precision errs by within a scan's reach."""
_XYZ: Final = 3
_ROTATION_TOLERANCE: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Calibration:
    """The calibration of one frame. All arrays are float64 and read-only.

    The cam frame is the rectified camera 0; the image is camera 2's, so projecting needs the whole of P2. P0, P1, P3
    and Tr_imu_to_velo are all zero where they are unknown.

    Attributes:
        P0: (3, 4) projection of the cam frame into the left gray camera, pixels.
        P1: (3, 4) the right gray camera.
        P2: (3, 4) the left color camera: the one of `image_2`.
        P3: (3, 4) the right color camera.
        R0_rect: (3, 3) rotation into the rectified frame of camera 0.
        Tr_velo_to_cam: (3, 4) the velo frame into camera 0 before rectification, meters.
        Tr_imu_to_velo: (3, 4) the IMU's frame into the velo frame, meters.
        has_blank_line: whether the file ends with a blank line, as most of KITTI's do; kept so that text round trips.
            Ours end without, as the others of KITTI's do: pykitti stops at it.

    Raises:
        ShapeError: a matrix has the wrong shape or dtype.
        NonFiniteError: a matrix holds NaN or infinity.
    """

    P0: NDArray[np.float64]
    P1: NDArray[np.float64]
    P2: NDArray[np.float64]
    P3: NDArray[np.float64]
    R0_rect: NDArray[np.float64]
    Tr_velo_to_cam: NDArray[np.float64]
    Tr_imu_to_velo: NDArray[np.float64]
    has_blank_line: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        for name, shape in SHAPES.items():
            matrix = check_array(getattr(self, name), name, shape, np.float64, finite=True).copy()
            matrix.setflags(write=False)
            object.__setattr__(self, name, matrix)

    def __repr__(self) -> str:
        (fx, _, cx, _), (_, fy, cy, _), _ = self.P2.tolist()
        return summary(
            self,
            f"focal lengths {fx:.1f}, {fy:.1f} px",
            f"center {cx:.1f}, {cy:.1f} px",
            **{name: getattr(self, name) for name in SHAPES},
        )

    def __eq__(self, other: object) -> bool:
        """Tell whether all seven matrices are equal."""
        if not isinstance(other, Calibration):
            return NotImplemented
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in SHAPES)

    def __hash__(self) -> int:
        """Hash the matrices."""
        return hash(tuple(np.add(getattr(self, name), 0.0).tobytes() for name in SHAPES))

    @classmethod
    def from_pinhole(cls, K: ArrayLike, cam_from_velo: ArrayLike) -> Calibration:
        """Return the calibration of one pinhole camera and a LIDAR: the camera is all four of KITTI's.

        Args:
            K: (3, 3) [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels, (0, 0) the center of the top-left pixel.
            cam_from_velo: (4, 4) or (3, 4), meters: takes points [x, y, z, 1] of the LIDAR's frame into the camera's,
                x right, y down, z forward.

        Raises:
            ShapeError: another shape.
            NonFiniteError: NaN or infinity.
            CadetError: a `K` that is no pinhole camera's, or a `cam_from_velo` that does more than turn and move.
        """
        intrinsics = as_array(K, "K", (3, 3), finite=True).astype(np.float64)
        pose = as_array(cam_from_velo, "cam_from_velo", ("3 or 4", 4), finite=True).astype(np.float64)
        if min(intrinsics[0, 0], intrinsics[1, 1]) <= 0.0 or not np.array_equal(
            intrinsics[[1, 2, 2, 2], [0, 0, 1, 2]], [0, 0, 0, 1]
        ):
            raise CadetError(f"K: expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], got {shown(intrinsics.tolist())}")
        if len(pose) != 3 and not (len(pose) == 4 and pose[3].tolist() == [0, 0, 0, 1]):
            raise ShapeError(f"cam_from_velo: expected (3, 4), or (4, 4) that ends in 0, 0, 0, 1, got {pose.tolist()}")
        rotation = pose[:3, :3]
        is_rigid = np.abs(rotation @ rotation.T - np.eye(3)).max() < _ROTATION_TOLERANCE
        if not is_rigid or np.linalg.det(rotation) <= 0.0:
            raise CadetError(f"cam_from_velo: expected a rotation in its (3, 3), got {shown(rotation.tolist())}")
        seen, unknown = np.hstack([intrinsics, np.zeros((3, 1))]), np.zeros((3, 4))
        return cls(
            P0=seen, P1=seen, P2=seen, P3=seen, R0_rect=np.eye(3), Tr_velo_to_cam=pose[:3], Tr_imu_to_velo=unknown
        )

    @classmethod
    def from_text(cls, text: str, file: str = "calib") -> Calibration:
        """Parse a calibration file; the order of its keys does not matter.

        Args:
            text: the file's text.
            file: its name for messages.

        Raises:
            KittiFormatError: `P2`, `R0_rect` or `Tr_velo_to_cam` is missing, a key comes twice with different numbers,
                or a line has too few, too many or malformed numbers.
            CadetError: `text` is no text.
        """
        check_text("", "text", text)
        return cls(**matrices_from_text(text, file), has_blank_line=text.endswith("\n\n"))

    def to_text(self) -> str:
        """Write the calibration as KITTI does: 12 decimals, more only where a number needs them to come back."""
        lines = (f"{name}: {' '.join(scientific_text(x) for x in getattr(self, name).flat)}\n" for name in SHAPES)
        return "".join(lines) + ("\n" if self.has_blank_line else "")

    @cached_property
    def cam_from_velo(self) -> NDArray[np.float64]:
        """(4, 4) float64, read-only: R0_rect times Tr_velo_to_cam, the velo frame into the cam frame."""
        rectified = np.eye(4)
        rectified[:3, :3] = self.R0_rect
        matrix: NDArray[np.float64] = rectified @ np.vstack([self.Tr_velo_to_cam, [0.0, 0.0, 0.0, 1.0]])
        matrix.setflags(write=False)
        return matrix

    @cached_property
    def velo_from_cam(self) -> NDArray[np.float64]:
        """(4, 4) float64, read-only: the inverse of `cam_from_velo`.

        Raises:
            CadetError: there is none.
        """
        try:
            matrix = np.linalg.inv(self.cam_from_velo).astype(np.float64)
        except np.linalg.LinAlgError:
            raise CadetError("calib: R0_rect times Tr_velo_to_cam is singular: it has no inverse") from None
        matrix.setflags(write=False)
        return matrix

    @cached_property
    def eye_cam(self) -> NDArray[np.float64]:
        """(3,) float64, read-only: where camera 2 stands in the cam frame, meters.

        Raises:
            CadetError: P2 is no camera's.
        """
        try:
            eye = -np.linalg.solve(self.P2[:, :3], self.P2[:, 3]).astype(np.float64)
        except np.linalg.LinAlgError:
            raise CadetError("calib: the first three columns of P2 are singular: it is not a camera's") from None
        eye.setflags(write=False)
        return eye

    def points_cam_from_velo(self, points_velo: NDArray[Any]) -> NDArray[np.float64]:
        """Bring points from the velo frame into the cam frame.

        Args:
            points_velo: (N, 3) or wider, meters; columns past the third are dropped.

        Returns:
            (N, 3) float64, meters.

        Raises:
            ShapeError: fewer than three columns.
        """
        return _transform(self.cam_from_velo, points_velo, "points_velo")

    def points_velo_from_cam(self, points_cam: NDArray[Any]) -> NDArray[np.float64]:
        """Bring points from the cam frame into the velo frame: (N, 3) or wider to (N, 3) float64, meters.

        Raises:
            ShapeError: fewer than three columns.
            CadetError: there is no way back.
        """
        return _transform(self.velo_from_cam, points_cam, "points_cam")

    def project(self, points_cam: NDArray[Any]) -> NDArray[np.float64]:
        """Project points into the image with the whole of P2.

        Args:
            points_cam: (N, 3) or wider, meters.

        Returns:
            (N, 2) float64 [u, v] in pixels, (0, 0) the center of the top-left pixel; NaN for points in or behind
            camera 2's own plane, which have no image. Not finite for points beyond what float64 holds in pixels.

        Raises:
            ShapeError: fewer than three columns.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            homogeneous = _transform(self.P2, points_cam, "points_cam")
            depth = np.where(homogeneous[:, 2] > 0.0, homogeneous[:, 2], np.nan)
            points_img: NDArray[np.float64] = homogeneous[:, :2] / depth[:, None]
        return points_img


def points_in_image(points_cam: NDArray[Any], calib: Calibration, image_size: tuple[int, int]) -> NDArray[np.bool_]:
    """Tell which points the image sees: z > 0, 0 < u < W and 0 < v < H, all strict.

    Args:
        points_cam: (N, 3) or wider, meters, cam frame. May be empty.
        calib: the calibration, whose P2 projects.
        image_size: width and height in pixels.

    Returns:
        (N,) bool.

    Raises:
        ShapeError: `points_cam` has fewer than three columns.
        CadetError: no calibration, or no image size.

    Reference: the point filter of AVOD's KITTI reader.
    """
    check_kind("", "calib", calib, Calibration)
    width, height = check_image_size(image_size)
    points_img = calib.project(points_cam)
    u, v = points_img[:, 0], points_img[:, 1]
    inside: NDArray[np.bool_] = (points_cam[:, 2] > 0.0) & (u > 0.0) & (u < width) & (v > 0.0) & (v < height)
    return inside


def is_at_zero_depth(points_velo: NDArray[Any], calib: Calibration) -> NDArray[np.bool_]:
    """Tell which points have z = 0 in the cam frame, to single precision: programs divide by it.

    Args:
        points_velo: (N, 3) or wider, meters, velo frame. May be empty.
        calib: the calibration.

    Returns:
        (N,) bool.

    Raises:
        ShapeError: `points_velo` has fewer than three columns.
    """
    check_array(points_velo, "points_velo", ("N", "C"))
    if points_velo.shape[1] < _XYZ:
        raise ShapeError(f"points_velo: expected (N, 3) or wider, got {points_velo.shape}")
    a, b, c, d = calib.cam_from_velo[2].tolist()
    # Written out: a product of matrices adds up in another order on other machines, and its threads spin for a while.
    x, y, z = points_velo[:, :_XYZ].T
    # Few points come near, and looking at those alone in double precision is fast.
    near = np.flatnonzero(np.abs(a * x + b * y + c * z + d) < _NEAR_ZERO_M)
    x, y, z = points_velo[near, :_XYZ].astype(np.float64).T
    is_zero = np.zeros(len(points_velo), bool)
    is_zero[near] = np.abs(a * x + b * y + c * z + d) < ZERO_DEPTH_M
    return is_zero


def _transform(matrix: NDArray[np.float64], points: NDArray[Any], name: str) -> NDArray[np.float64]:
    check_array(points, name, ("N", "C"))
    if points.shape[1] < _XYZ:
        raise ShapeError(f"{name}: expected (N, 3) or wider, got {points.shape}")
    moved: NDArray[np.float64] = points[:, :3].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return moved
