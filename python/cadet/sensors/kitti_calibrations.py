"""KITTI's four calibrations, to the digit as its `calib` files have them, one for each set of recording days.

The files of 2011_10_03 are KITTI's raw data's and its odometry benchmark's. The inertial unit was never moved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from cadet._util.checks import is_one_of, shown
from cadet.errors import CadetError

Row3 = tuple[float, float, float]
Row4 = tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class KittiCalibration:
    """The figures of one calibration, and how often and how KITTI's car was driven with it."""

    num_frames: int
    """Of the 7,481 frames of the object benchmark's training set."""
    image_size: tuple[int, int]
    """Width and height of the rectified images, pixels."""
    focal_px: float
    """Focal length of all four rectified cameras."""
    center_px: tuple[float, float]
    """Their optical axis: column and row."""
    p1_column: Row3
    """The fourth column of P1."""
    p2_column: Row3
    """The fourth column of P2."""
    p3_column: Row3
    """The fourth column of P3."""
    r0_rect: tuple[Row3, Row3, Row3]
    """R0_rect."""
    tr_velo_to_cam: tuple[Row4, Row4, Row4]
    """Tr_velo_to_cam."""
    lidar_pitch_deg: float
    """How far the LIDAR looks down on the road it stands on: the mean over the drives, by the bottoms of the labeled
    boxes (17,000, 2,200, 1,600 and 1,200 nearer than 35 m) and by scans. Its roll is 0.0 within 0.2 degrees."""


TR_IMU_TO_VELO: Final[tuple[Row4, Row4, Row4]] = (
    (9.999976e-01, 7.553071e-04, -2.035826e-03, -8.086759e-01),
    (-7.854027e-04, 9.998898e-01, -1.482298e-02, 3.195559e-01),
    (2.024406e-03, 1.482454e-02, 9.998881e-01, -7.997231e-01),
)

KITTI_CALIBRATIONS: Final[dict[str, KittiCalibration]] = {
    "2011_09_26": KittiCalibration(
        num_frames=6057,
        image_size=(1242, 375),
        focal_px=721.5377,
        center_px=(609.5593, 172.854),
        p1_column=(-387.5744, 0.0, 0.0),
        p2_column=(44.85728, 0.2163791, 0.002745884),
        p3_column=(-339.5242, 2.199936, 0.002729905),
        r0_rect=(
            (9.999239e-01, 9.837760e-03, -7.445048e-03),
            (-9.869795e-03, 9.999421e-01, -4.278459e-03),
            (7.402527e-03, 4.351614e-03, 9.999631e-01),
        ),
        tr_velo_to_cam=(
            (7.533745e-03, -9.999714e-01, -6.166020e-04, -4.069766e-03),
            (1.480249e-02, 7.280733e-04, -9.998902e-01, -7.631618e-02),
            (9.998621e-01, 7.523790e-03, 1.480755e-02, -2.717806e-01),
        ),
        lidar_pitch_deg=0.37,
    ),
    "2011_09_28": KittiCalibration(
        num_frames=770,
        image_size=(1224, 370),
        focal_px=707.0493,
        center_px=(604.0814, 180.5066),
        p1_column=(-379.7842, 0.0, 0.0),
        p2_column=(45.75831, -0.3454157, 0.004981016),
        p3_column=(-334.1081, 2.33066, 0.003201153),
        r0_rect=(
            (9.999128e-01, 1.009263e-02, -8.511932e-03),
            (-1.012729e-02, 9.999406e-01, -4.037671e-03),
            (8.470675e-03, 4.123522e-03, 9.999556e-01),
        ),
        tr_velo_to_cam=(
            (6.927964e-03, -9.999722e-01, -2.757829e-03, -2.457729e-02),
            (-1.162982e-03, 2.749836e-03, -9.999955e-01, -6.127237e-02),
            (9.999753e-01, 6.931141e-03, -1.143899e-03, -3.321029e-01),
        ),
        lidar_pitch_deg=0.90,
    ),
    "2011_09_29": KittiCalibration(
        num_frames=358,
        image_size=(1238, 374),
        focal_px=718.3351,
        center_px=(600.3891, 181.5122),
        p1_column=(-385.8846, 0.0, 0.0),
        p2_column=(44.50382, -0.5951107, 0.002616315),
        p3_column=(-336.3147, 3.159867, 0.005323834),
        r0_rect=(
            (9.999478e-01, 9.791707e-03, -2.925305e-03),
            (-9.806939e-03, 9.999382e-01, -5.238719e-03),
            (2.873828e-03, 5.267134e-03, 9.999820e-01),
        ),
        tr_velo_to_cam=(
            (7.755449e-03, -9.999694e-01, -1.014303e-03, -7.275538e-03),
            (2.294056e-03, 1.032122e-03, -9.999968e-01, -6.324057e-02),
            (9.999673e-01, 7.753097e-03, 2.301990e-03, -2.670414e-01),
        ),
        lidar_pitch_deg=0.80,
    ),
    "2011_10_03": KittiCalibration(
        num_frames=296,
        image_size=(1241, 376),
        focal_px=718.856,
        center_px=(607.1928, 185.2157),
        p1_column=(-386.1448, 0.0, 0.0),
        p2_column=(45.38225, -0.1130887, 0.003779761),
        p3_column=(-337.2877, 2.369057, 0.004915215),
        r0_rect=(
            (9.999454e-01, 7.259129e-03, -7.519551e-03),
            (-7.292213e-03, 9.999638e-01, -4.381729e-03),
            (7.487471e-03, 4.436324e-03, 9.999621e-01),
        ),
        tr_velo_to_cam=(
            (7.967514e-03, -9.999679e-01, -8.462264e-04, -1.377769e-02),
            (-2.771053e-03, 8.241710e-04, -9.999958e-01, -5.542117e-02),
            (9.999644e-01, 7.969825e-03, -2.764397e-03, -2.918589e-01),
        ),
        lidar_pitch_deg=0.32,
    ),
}

MOST_FREQUENT: Final = "2011_09_26"


def kitti_calibration(name: str) -> KittiCalibration:
    """Return the calibration of a recording day.

    Raises:
        CadetError: there is none of that name.
    """
    if not is_one_of(name, KITTI_CALIBRATIONS):
        raise CadetError(f"unknown calibration {shown(name)}; known: {', '.join(KITTI_CALIBRATIONS)}")
    return KITTI_CALIBRATIONS[name]
