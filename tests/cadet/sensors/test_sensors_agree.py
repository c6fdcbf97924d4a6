"""LIDAR and camera see one world: the same triangles, at the same instant."""

from __future__ import annotations

import numpy as np
import pytest

import cadet
from cadet.formats.kitti import Calibration, points_in_image
from cadet.sensors.kitti_calibrations import KITTI_CALIBRATIONS

CALIBRATIONS = list(KITTI_CALIBRATIONS)


def test_lidar_points_fall_on_their_own_pixels_at_the_papers_rig() -> None:
    same = total = 0
    for seed in range(4):
        scene = cadet.Scene.random(seed=seed, rig=cadet.Rig.paper(), weather="clear_noon")
        frame, scan = scene.capture(), scene.scan(ideal=True)
        hit = np.isfinite(scan.range_m) & (scan.actor_id > 0)
        points = scan.points_velo[hit, :3].astype(float)
        cam_from_velo = frame.calib.cam_from_velo
        points_cam = points @ cam_from_velo[:3, :3].T + cam_from_velo[:3, 3]
        uvw = points_cam @ frame.calib.P2[:, :3].T + frame.calib.P2[:, 3]
        u, v = np.rint(uvw[:, :2].T / uvw[:, 2]).astype(int) if len(uvw) else np.zeros((2, 0), int)
        assert frame.instance is not None
        height, width = frame.instance.shape
        inside = (uvw[:, 2] > 0.1) & (u >= 0) & (u < width) & (v >= 0) & (v < height)
        same += (frame.instance[v[inside], u[inside]] == scan.actor_id[hit][inside]).sum()
        total += inside.sum()
    assert total > 1000
    assert same >= 0.97 * total, same / total


@pytest.mark.parametrize("calibration", CALIBRATIONS)
def test_lidar_points_fall_on_their_own_pixels_by_the_written_calibration(calibration: str) -> None:
    """The LIDAR stands behind the camera: what something near hides from the camera alone is left out."""
    same = total = 0
    for seed in range(3):
        scene = cadet.Scene.random(seed=seed, rig=cadet.Rig.kitti(calibration=calibration), weather="clear_noon")
        frame, scan = scene.capture(), scene.scan(ideal=True)
        calib = Calibration.from_text(frame.calib.to_text())
        hit = np.isfinite(scan.range_m) & (scan.actor_id > 0)
        points_cam = calib.points_cam_from_velo(scan.points_velo[hit])
        inside = points_in_image(points_cam, calib, (frame.image.shape[1] - 1, frame.image.shape[0] - 1))
        u, v = np.rint(calib.project(points_cam[inside])).astype(int).T
        assert frame.instance is not None and frame.depth is not None
        is_open = frame.depth[v, u] > points_cam[inside, 2] - 0.5
        same += (frame.instance[v, u] == scan.actor_id[hit][inside])[is_open].sum()
        total += is_open.sum()
    assert total > 1000
    assert same >= 0.97 * total, same / total


@pytest.mark.parametrize("calibration", CALIBRATIONS)
def test_the_road_lies_in_the_cam_frame_as_the_calibration_tilts_it(calibration: str) -> None:
    rig = cadet.Rig.kitti(calibration=calibration)
    scene = cadet.Scene.empty(weather="clear_noon", rig=rig)
    scene.move_ego(x_m=-20.0, y_m=0.0, yaw_rad=0.0)
    frame, scan = scene.capture(), scene.scan(ideal=True)
    assert frame.plane is not None
    # By hand: the LIDAR looks down on a level road by its pitch.
    pitch = np.radians(rig.velo_roll_pitch_yaw_deg[1])
    up_cam = frame.calib.cam_from_velo[:3, :3] @ [-np.sin(pitch), 0.0, np.cos(pitch)]
    tilt_deg = np.degrees(np.arccos(np.clip(frame.plane[:3] @ up_cam, -1.0, 1.0)))
    assert tilt_deg < 0.15, tilt_deg
    on_road = np.isfinite(scan.range_m) & (scan.range_m < 25.0) & (np.abs(scan.points_velo[:, 1]) < 4.0)
    points_cam = frame.calib.points_cam_from_velo(scan.points_velo[on_road & (scan.points_velo[:, 0] > 4.0)])
    assert len(points_cam) > 2000
    assert np.abs(points_cam @ frame.plane[:3] + frame.plane[3]).max() < 0.02
    # The image is drawn from the same pose: depths of road pixels lie in the plane.
    assert frame.depth is not None and frame.instance is not None
    v, u = np.mgrid[frame.depth.shape[0] - 40 : frame.depth.shape[0] : 8, 300:900:40].reshape(2, -1)
    z = frame.depth[v, u].astype(float)
    p2 = frame.calib.P2
    k_inverse = np.linalg.inv(p2[:, :3])
    points = (np.stack([u * z, v * z, z]).T - p2[:, 3]) @ k_inverse.T
    assert np.abs(points @ frame.plane[:3] + frame.plane[3]).max() < 0.02


@pytest.mark.parametrize("calibration", CALIBRATIONS)
def test_2d_boxes_are_the_projected_3d_boxes(calibration: str) -> None:
    num_checked = 0
    for seed in range(2):
        scene = cadet.Scene.random(seed=seed, rig=cadet.Rig.kitti(calibration=calibration), weather="clear_noon")
        frame = scene.capture()
        height, width = frame.image.shape[:2]
        for label in frame.labels:
            if label.type == "DontCare":
                continue
            h, w, l = label.dimensions_hwl
            x = np.array([l, l, -l, -l, l, l, -l, -l]) / 2.0
            y = np.array([0.0, 0.0, 0.0, 0.0, -h, -h, -h, -h])
            z = np.array([w, -w, -w, w, w, -w, -w, w]) / 2.0
            c, s = np.cos(label.rotation_y), np.sin(label.rotation_y)
            corners = np.stack([c * x + s * z, y, -s * x + c * z], axis=1) + label.location_cam
            if corners[:, 2].min() < 0.2:
                continue
            uv = frame.calib.project(corners)
            expected = [*uv.min(axis=0), *uv.max(axis=0)]
            expected = np.clip(expected, 0.0, [width - 1, height - 1, width - 1, height - 1])
            np.testing.assert_allclose(label.bbox, expected, atol=0.011)
            num_checked += 1
    assert num_checked >= 3


def test_the_shipped_tools_rig_stands_in_one_point_over_the_road() -> None:
    scene = cadet.Scene.empty(weather="clear_noon", rig=cadet.Rig.cadet())
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    poses = scene.sensor_poses()
    np.testing.assert_allclose(poses["world_from_velo"][:3, 3], poses["world_from_cam"][:3, 3], atol=1e-12)
    assert abs(poses["world_from_velo"][2, 3] - 1.6) < 0.02
    frame, scan = scene.capture(), scene.scan(ideal=True)
    assert frame.image.shape == (384, 1248, 3)
    assert len(np.unique(scan.ring)) == 40
    assert frame.meta is not None and frame.meta["rig"] == "cadet"


def test_an_ideal_scan_agrees_with_parry() -> None:
    scene = cadet.Scene.random(seed=1, weather="clear_noon")
    lidar = cadet.Lidar.hdl64e_kitti()
    origins, directions, ring, column = lidar.rays()
    scan = scene.scan(lidar, ideal=True)
    assert np.array_equal(scan.ring, ring) and np.array_equal(scan.column, column)
    world_from_velo = scene.sensor_poses()["world_from_velo"]
    every = slice(None, None, 7)
    range_m, _, _ = scene.cast_rays(
        origins[every] @ world_from_velo[:3, :3].T + world_from_velo[:3, 3],
        directions[every] @ world_from_velo[:3, :3].T,
    )
    ours = scan.range_m[every]
    hit, hit_by_parry = np.isfinite(ours), np.isfinite(range_m)
    agree = hit == hit_by_parry
    both = hit & hit_by_parry
    agree[both] = np.abs(ours[both] - range_m[both]) < 1e-3
    assert agree.mean() >= 0.9999, (~agree).sum()


def test_triangles_are_those_that_the_sensors_see() -> None:
    scene = cadet.Scene.empty(weather="clear_noon")
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    car = scene.add("car", x_m=10.0, y_m=0.0, yaw_rad=0.0, model_seed=1)
    vertices_world, faces, actor_id = scene.triangles()
    assert vertices_world.dtype == np.float32 and faces.dtype == np.uint32 and actor_id.dtype == np.int32
    assert set(np.unique(actor_id)) == {0, car}
    own = vertices_world[np.unique(faces[actor_id == car])]
    assert abs(own[:, 2].min()) < 0.03 and 1.2 < own[:, 2].max() < 2.2
    assert 7.0 < own[:, 0].min() < 9.0 and 11.0 < own[:, 0].max() < 13.0


def test_a_flat_ground_is_where_the_mount_says() -> None:
    scene = cadet.Scene.empty(weather="clear_noon")
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.3)
    lidar = cadet.Lidar.hdl64e_uniform()
    origins, directions, _, _ = lidar.rays()
    scan = scene.scan(lidar, ideal=True)
    world_from_velo = scene.sensor_poses()["world_from_velo"]
    height = world_from_velo[2, 3]
    assert abs(height - 1.73) < 0.02
    down = directions @ world_from_velo[2, :3]
    steep = down < -0.08
    expected = -height / down[steep]
    assert np.allclose(scan.range_m[steep], expected, rtol=2e-3)
