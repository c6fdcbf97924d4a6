"""The poses of LIDAR, cameras, and inertial unit relative to each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import check_number, check_three, make_plain, shown
from cadet.errors import CadetError
from cadet.sensors.kitti_calibrations import MOST_FREQUENT, TR_IMU_TO_VELO, Row3, Row4, kitti_calibration
from cadet.sensors.pose import product

_IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_NOT_MOVED = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
_DEFAULT = kitti_calibration(MOST_FREQUENT)
# Calibration files carry seven digits.
_ROTATION_TOLERANCE = 1e-4


@dataclass(frozen=True, kw_only=True)
class Extrinsics:
    """KITTI's three matrices, by rows; those of its most frequent calibration by default.

    A point of the velo frame (x forward, y left, z up) comes into the cam frame, the rectified camera 0 (x right,
    y down, z forward), by `r0_rect` times `tr_velo_to_cam`.

    Raises:
        CadetError: a matrix of another shape, a number outside its range, or what is no rotation.
    """

    r0_rect: tuple[Row3, Row3, Row3] = _DEFAULT.r0_rect
    """The rotation that rectifies camera 0."""
    tr_velo_to_cam: tuple[Row4, Row4, Row4] = _DEFAULT.tr_velo_to_cam
    """From the LIDAR to camera 0 before it is rectified, meters."""
    tr_imu_to_velo: tuple[Row4, Row4, Row4] = TR_IMU_TO_VELO
    """From the inertial unit to the LIDAR, meters."""

    def __post_init__(self) -> None:
        for name, num_columns in (("r0_rect", 3), ("tr_velo_to_cam", 4), ("tr_imu_to_velo", 4)):
            rows = getattr(self, name)
            is_matrix = isinstance(rows, tuple) and len(rows) == 3
            if not is_matrix or not all(isinstance(row, tuple) and len(row) == num_columns for row in rows):
                raise CadetError(f"Extrinsics.{name}: expected three rows of {num_columns} numbers, got {shown(rows)}")
            for value in (value for row in rows for value in row):
                check_number("Extrinsics", name, value, -20, 20)
            rotation = np.array(rows)[:, :3]
            is_orthonormal = np.abs(rotation @ rotation.T - np.eye(3)).max() < _ROTATION_TOLERANCE
            if not is_orthonormal or np.linalg.det(rotation) <= 0.0:
                raise CadetError(
                    f"Extrinsics.{name}: expected a rotation in its first three columns, got {shown(rows)}"
                )
        make_plain(self)

    @classmethod
    def kitti(cls, *, calibration: str = MOST_FREQUENT) -> Extrinsics:
        """Return KITTI's: of "2011_09_26", "2011_09_28", "2011_09_29" or "2011_10_03".

        Raises:
            CadetError: another name.
        """
        figures = kitti_calibration(calibration)
        return cls(r0_rect=figures.r0_rect, tr_velo_to_cam=figures.tr_velo_to_cam)

    @classmethod
    def aligned(cls, *, cam0_in_velo_m: Row3 = (0.0, 0.0, 0.0)) -> Extrinsics:
        """Return those of a camera that looks exactly along the LIDAR's x axis from a place in its frame.

        Raises:
            CadetError: a place that is not three numbers from -20 to 20.
        """
        check_three("Extrinsics", "cam0_in_velo_m", cam0_in_velo_m, 20)
        x, y, z = cam0_in_velo_m
        velo_to_cam = ((0.0, -1.0, 0.0, y), (0.0, 0.0, -1.0, z), (1.0, 0.0, 0.0, -x))
        return cls(r0_rect=_IDENTITY, tr_velo_to_cam=velo_to_cam, tr_imu_to_velo=_NOT_MOVED)

    def cam_from_velo(self) -> NDArray[np.float64]:
        """Return the (3, 4) float64 product of `r0_rect` and `tr_velo_to_cam`."""
        return product(np.array(self.r0_rect, np.float64), np.array(self.tr_velo_to_cam, np.float64))

    def matrices(self) -> dict[str, NDArray[np.float64]]:
        """Return the matrices by KITTI's keys, float64."""
        return {
            "R0_rect": np.array(self.r0_rect, dtype=np.float64),
            "Tr_velo_to_cam": np.array(self.tr_velo_to_cam, dtype=np.float64),
            "Tr_imu_to_velo": np.array(self.tr_imu_to_velo, dtype=np.float64),
        }
