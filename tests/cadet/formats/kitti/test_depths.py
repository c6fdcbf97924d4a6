"""No point of a frame has z = 0 in the frame of camera 0: other programs divide by it."""

from __future__ import annotations

import numpy as np
import pytest

import cadet
from cadet import Rig
from cadet.formats.kitti import Calibration
from cadet.formats.kitti.from_sample import move_off_zero_depth
from cadet.sensors.rig import RIG_PRESETS
from synthetic import make_calib

RIGS = [*(Rig.named(name) for name in RIG_PRESETS), *(rig for rig, _ in Rig.every_kitti())]


def depths_in_single_precision(points_velo: np.ndarray, calib: Calibration) -> np.ndarray:
    """Multiply as OpenPCDet does, with matrices of four bytes a number."""
    homogeneous = np.hstack([points_velo[:, :3], np.ones((len(points_velo), 1), np.float32)])
    matrix = calib.Tr_velo_to_cam.astype(np.float32).T @ calib.R0_rect.astype(np.float32).T
    return np.asarray((homogeneous @ matrix)[:, 2])


@pytest.mark.parametrize("rig", RIGS, ids=lambda rig: rig.name)
def test_no_rig_writes_a_point_of_depth_0(rig: Rig) -> None:
    frame = cadet.Scene.random(seed=1, rig=rig, weather="clear_noon").capture()
    assert len(frame.points_velo) > 10_000
    assert np.all(depths_in_single_precision(frame.points_velo, frame.calib) != 0.0)
    assert np.abs(frame.calib.points_cam_from_velo(frame.points_velo)[:, 2]).min() > 2.4e-7
    millimeters = frame.points_velo[:, :3].astype(np.float64) * 1e3
    np.testing.assert_allclose(millimeters, np.rint(millimeters), atol=0.004)


def test_a_column_to_the_side_would_give_such_points() -> None:
    scene = cadet.Scene.random(seed=1, rig=Rig.cadet(), weather="clear_noon")
    frame, raw = scene.capture(), scene.scan()
    is_zero = raw.points_velo[:, 0] == 0.0
    assert is_zero.sum() > 20
    np.testing.assert_array_equal(frame.points_velo[~is_zero], raw.points_velo[~is_zero])
    np.testing.assert_array_equal(frame.points_velo[is_zero, 0], np.float32(0.001))
    np.testing.assert_array_equal(frame.points_velo[is_zero, 1:], raw.points_velo[is_zero, 1:])


def test_points_move_outwards_along_the_axis_that_looks_ahead() -> None:
    calib = make_calib()
    backwards = Calibration(
        P0=calib.P0,
        P1=calib.P1,
        P2=calib.P2,
        P3=calib.P3,
        R0_rect=np.eye(3),
        # The camera looks along -y, from 0.5 m to the left.
        Tr_velo_to_cam=np.array([[-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, -1.0, 0.0, 0.5]]),
        Tr_imu_to_velo=calib.Tr_imu_to_velo,
    )
    points_velo = np.array([[3.0, 0.5, 1.0, 0.2], [3.0, 0.499, 1.0, 0.3], [-4.0, 0.5, 0.0, 0.4]], np.float32)
    moved = move_off_zero_depth(points_velo, backwards)
    wanted = np.array([[3.0, 0.501, 1.0, 0.2], [3.0, 0.499, 1.0, 0.3], [-4.0, 0.501, 0.0, 0.4]], np.float32)
    np.testing.assert_array_equal(moved, wanted)
    assert move_off_zero_depth(wanted, backwards) is wanted
