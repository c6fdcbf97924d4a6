"""LIDAR and camera see one world: the same triangles, at the same instant."""

from __future__ import annotations

import numpy as np

import cadet


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
        height, width = frame.instance.shape
        inside = (uvw[:, 2] > 0.1) & (u >= 0) & (u < width) & (v >= 0) & (v < height)
        same += (frame.instance[v[inside], u[inside]] == scan.actor_id[hit][inside]).sum()
        total += inside.sum()
    assert total > 1000
    assert same >= 0.97 * total, same / total


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
    both = np.isfinite(ours) & np.isfinite(range_m)
    agree = (np.isinf(ours) & np.isinf(range_m)) | (both & (np.abs(np.where(both, ours - range_m, 0)) < 1e-3))
    assert agree.mean() >= 0.9999, (~agree).sum()


def test_triangles_are_those_that_the_sensors_see() -> None:
    scene = cadet.Scene.empty(weather="clear_noon")
    scene.move_ego(x=0.0, y=0.0, yaw=0.0)
    car = scene.add("car", x=10.0, y=0.0, yaw=0.0, model_seed=1)
    vertices_world, faces, actor_id = scene.triangles()
    assert vertices_world.dtype == np.float32 and faces.dtype == np.uint32 and actor_id.dtype == np.int32
    assert set(np.unique(actor_id)) == {0, car}
    own = vertices_world[np.unique(faces[actor_id == car])]
    assert abs(own[:, 2].min()) < 0.03 and 1.2 < own[:, 2].max() < 2.2
    assert 7.0 < own[:, 0].min() < 9.0 and 11.0 < own[:, 0].max() < 13.0


def test_a_flat_ground_is_where_the_mount_says() -> None:
    scene = cadet.Scene.empty(weather="clear_noon")
    scene.move_ego(x=0.0, y=0.0, yaw=0.3)
    lidar = cadet.Lidar.hdl64e_uniform()
    origins, directions, _, _ = lidar.rays()
    scan = scene.scan(lidar, ideal=True)
    height = scene.sensor_poses()["world_from_velo"][2, 3]
    assert abs(height - 1.73) < 0.02
    steep = directions[:, 2] < -0.08
    expected = -height / directions[steep, 2]
    assert np.allclose(scan.range_m[steep], expected, rtol=2e-3)
