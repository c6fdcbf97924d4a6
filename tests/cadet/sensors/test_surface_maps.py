"""Normals and flows of images against closed forms, against the next frame, and in KITTI's files."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet import Camera, Lidar, MountedCamera, Pose, Rig, Scene
from cadet.generate import Settings, generate
from cadet.sensors.sample import MORE_MAPS

LENS = Camera(width=400, height=200, fx=300.0, fy=300.0, cx=199.5, cy=99.5)
STEP_S = 1 / 60


def rig(camera: Camera = LENS) -> Rig:
    """A camera that looks ahead, level."""
    level = (0.0, 0.0, 0.0)
    extrinsics = cadet.Extrinsics.aligned()
    return Rig(camera=camera, lidar=Lidar.vlp16(), extrinsics=extrinsics, velo_roll_pitch_yaw_deg=level)


def points_cam(depth: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return (H, W, 3) points of the pixels' centers in the camera's frame, the sky's 1 m ahead."""
    v, u = np.mgrid[: depth.shape[0], : depth.shape[1]]
    z = np.where(np.isfinite(depth), depth, 1.0).astype(np.float64)
    return np.stack([(u - LENS.cx) / LENS.fx * z, (v - LENS.cy) / LENS.fy * z, z], axis=-1)


def pixels(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return points[..., :2] / points[..., 2:] * [LENS.fx, LENS.fy] + [LENS.cx, LENS.cy]


@pytest.fixture(scope="module")
def street() -> Scene:
    scene = Scene.random(seed=4, weather="clear_noon", rig=rig())
    scene.step(3.0)
    return scene


def test_what_stands_flows_as_the_next_frames_pose_says(street: Scene) -> None:
    """The poses of two captures, a step apart, move each static point; the first one's flow must have said so."""
    flow_s = STEP_S
    frame = street.capture(more_maps=MORE_MAPS, flow_s=flow_s)
    assert frame.depth is not None and frame.optical_flow is not None and frame.scene_flow is not None
    assert frame.instance is not None and frame.meta is not None and frame.meta["flow_s"] == flow_s
    world_from_now = street.sensor_poses()["world_from_cam"]
    street.step(flow_s)
    then_from_now = np.linalg.inv(street.sensor_poses()["world_from_cam"]) @ world_from_now
    assert np.linalg.norm(then_from_now[:3, 3]) > 0.05
    now = points_cam(frame.depth)
    then = now @ then_from_now[:3, :3].T + then_from_now[:3, 3]
    is_static = (frame.instance == 0) & (then[..., 2] > 2.0) & (now[..., 2] > 2.0)
    off_px = np.abs(frame.optical_flow - (pixels(then) - pixels(now)))[is_static]
    # What the ego's motion changes by within a step, and single precision.
    assert is_static.sum() > 20_000 and np.percentile(off_px, 95) < 0.05
    assert not frame.scene_flow[frame.instance <= 0].any()
    assert np.isnan(frame.optical_flow[frame.instance == -1]).all()


def driven(speed_mps: float, camera: Camera = LENS) -> Scene:
    """A square on which a car crosses the view and another stands, from an ego that stands."""
    scene = Scene.empty(rig=rig(camera))
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    scene.add("car", x_m=14.0, y_m=-1.0, yaw_rad=math.pi / 2, model_seed=1, speed_mps=speed_mps)
    scene.add("car", x_m=18.0, y_m=3.0, yaw_rad=0.0, model_seed=2)
    return scene


def test_a_steady_motion_has_the_flow_of_its_closed_form() -> None:
    """f v t / z to the left for a car that crosses, 0 for all else."""
    speed_mps, flow_s = 12.0, 0.1
    frame = driven(speed_mps).capture(more_maps=MORE_MAPS, flow_s=flow_s)
    assert frame.depth is not None and frame.optical_flow is not None and frame.scene_flow is not None
    assert frame.instance is not None
    is_car, others = frame.instance == 1, (frame.instance == 0) | (frame.instance == 2)
    assert is_car.sum() > 500 and (frame.instance == 2).sum() > 300
    expected = -LENS.fx * speed_mps * flow_s / frame.depth[is_car].astype(np.float64)
    assert np.abs(frame.optical_flow[is_car, 0] - expected).max() < 0.05
    assert np.abs(frame.optical_flow[is_car, 1]).max() < 0.05
    assert np.abs(frame.optical_flow[others]).max() < 0.05
    # To the left of a camera that looks ahead; the label's metadata has the velocity in the world.
    np.testing.assert_allclose(frame.scene_flow[is_car] - [-speed_mps, 0.0, 0.0], 0.0, atol=1e-3)
    assert not frame.scene_flow[others].any()


def test_the_flow_of_a_car_leads_to_where_it_is_in_the_next_frame() -> None:
    scene = driven(12.0)
    flow_s = 6 * STEP_S
    frame = scene.capture(more_maps=["optical_flow"], flow_s=flow_s)
    scene.step(flow_s)
    after = scene.capture()
    assert frame.optical_flow is not None and frame.instance is not None and after.instance is not None
    v, u = np.nonzero(frame.instance == 1)
    there = np.rint(np.c_[u, v] + frame.optical_flow[v, u]).astype(int)
    inside = (there[:, 0] >= 0) & (there[:, 0] < 400)
    assert inside.sum() > 300
    assert (after.instance[there[inside, 1], there[inside, 0]] == 1).mean() > 0.97


def test_normals_are_those_of_the_surfaces(street: Scene) -> None:
    """A square's ground is level. In a street the normals are of length 1, toward the camera, and those of its rays."""
    flat = driven(0.0).capture(more_maps=["normals"])
    assert flat.normals is not None and flat.instance is not None and flat.optical_flow is None
    np.testing.assert_allclose(flat.normals[flat.instance == 0] - [0.0, -1.0, 0.0], 0.0, atol=1e-6)
    assert not flat.normals[flat.instance == -1].any()
    frame = street.capture(more_maps=["normals"])
    assert frame.normals is not None and frame.depth is not None and frame.instance is not None
    seen = frame.instance >= 0
    np.testing.assert_allclose(np.linalg.norm(frame.normals[seen], axis=1), 1.0, atol=1e-6)
    rays = points_cam(frame.depth)
    assert ((frame.normals * rays).sum(axis=2)[seen] < 1e-5).all()
    pose = street.sensor_poses()["world_from_cam"]
    v, u = (places[::97] for places in np.nonzero(seen))
    directions = rays[v, u] @ pose[:3, :3].T
    hits = street.cast_rays(np.tile(pose[:3, 3], (len(v), 1)), directions)
    same = np.abs(hits.range_m - np.linalg.norm(directions, axis=1)) < 1e-3 * hits.range_m
    assert same.mean() > 0.9
    np.testing.assert_allclose(frame.normals[v, u][same] @ pose[:3, :3].T, hits.normal_world[same], atol=1e-3)


def test_a_rolling_shutter_moves_each_row_from_its_own_time() -> None:
    """Depth along the axis does not change for a car that crosses, nor does f v t / z."""
    frame = driven(12.0, replace(LENS, rolling_shutter_s=0.06)).capture(more_maps=MORE_MAPS)
    assert frame.optical_flow is not None and frame.instance is not None and frame.depth is not None
    assert frame.normals is not None and frame.scene_flow is not None
    is_car = frame.instance == 1
    expected = -LENS.fx * 12.0 * 0.1 / frame.depth[is_car].astype(np.float64)
    assert is_car.sum() > 500 and np.abs(frame.optical_flow[is_car, 0] - expected).max() < 0.05
    np.testing.assert_allclose(frame.scene_flow[is_car] - [-12.0, 0.0, 0.0], 0.0, atol=1e-3)
    np.testing.assert_allclose(frame.normals[frame.instance == 0] - [0.0, -1.0, 0.0], 0.0, atol=1e-6)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("surfaces") / "out"
    rear = MountedCamera(name="rear", camera=LENS, pose=Pose.of_camera((-1.0, 0.0, 1.5), yaw_deg=180))
    of = Rig.kitti().with_image_size(310, 94).with_sensors(rear)
    policy = cadet.ResetPolicy.kitti().with_rig(of).as_sequence(hz=5.0, length_s=0.4)
    generate(root, Settings(seed=1, num_frames=2, policy=policy, write=(*MORE_MAPS, "cameras")), workers=1)
    return root


def test_files_hold_what_frames_do(written: Path) -> None:
    assert cadet.kitti.lint(written) == []
    rig_of = Rig.kitti().with_image_size(310, 94)
    policy = cadet.ResetPolicy.kitti().with_rig(rig_of).as_sequence(hz=5.0, length_s=0.4)
    env = cadet.Environment(policy=policy, more_maps=MORE_MAPS)
    env.reset(seed=1)
    frame, read = env.step(), cadet.kitti.read_frame(written, 0)
    for name, steps in (("normals", 32767), ("optical_flow", 64), ("scene_flow", 256)):
        ours, theirs = getattr(frame, name), getattr(read, name)
        assert theirs.dtype == np.float32 and np.array_equal(np.isnan(ours), np.isnan(theirs))
        assert np.nanmax(np.abs(ours - theirs)) <= 0.5001 / steps, name
    # The time to the next frame of the sequence.
    assert frame.meta is not None and read.meta is not None and read.meta["flow_s"] == frame.meta["flow_s"] == 0.2
    assert cadet.kitti.read_frame(written, 1, camera="rear").optical_flow is not None
    # KITTI's development kit, by OpenCV, which has blue first.
    raw = cv2.imread(str(written / "training" / "optical_flow" / "000000.png"), cv2.IMREAD_UNCHANGED)
    assert raw is not None and raw.dtype == np.uint16
    valid, flow = raw[..., 0], (raw[..., :0:-1].astype(np.float64) - 2**15) / 64.0
    assert set(np.unique(valid).tolist()) <= {0, 1} and frame.optical_flow is not None
    np.testing.assert_array_equal(valid == 1, ~np.isnan(frame.optical_flow[..., 0]))
    assert np.abs(flow[valid == 1] - frame.optical_flow[valid == 1]).max() < 0.01


def test_damaged_maps_are_found(written: Path, tmp_path: Path) -> None:
    files = {kind: (written / "training" / kind / "000000.png").read_bytes() for kind in MORE_MAPS}
    for kind, data in files.items():
        root = tmp_path / kind / "training"
        for needed, suffix in (("image_2", ".png"), ("velodyne", ".bin"), ("calib", ".txt"), ("label_2", ".txt")):
            (root / needed).mkdir(parents=True)
            own = f"{needed}/000000{suffix}"
            (root / own).write_bytes((written / "training" / own).read_bytes())
        (root / kind).mkdir()
        (root / kind / "000000.png").write_bytes(data)
        assert [one for one in cadet.kitti.lint(root.parent) if kind in one.file] == []
        (root / kind / "000000.png").write_bytes((written / "training" / "image_2" / "000000.png").read_bytes())
        found = [(one.file, one.rule) for one in cadet.kitti.lint(root.parent) if kind in one.file]
        assert found == [(f"{kind}/000000.png", "damaged-file")]


def test_flow_beyond_kittis_range_is_unknown_and_others_come_back() -> None:
    from cadet.formats.kitti.files.vector_images import bytes_from_flow, flow_from_bytes

    flow = np.array([[[0.0, 0.0], [511.98, -512.0], [512.1, 0.0], [np.nan, np.nan]]], np.float32)
    back = flow_from_bytes(bytes_from_flow(flow), "flow")
    np.testing.assert_allclose(back[0, :2], flow[0, :2], atol=0.5 / 64)
    assert np.isnan(back[0, 2:]).all()


def test_unknown_maps_and_times_are_refused(street: Scene) -> None:
    with pytest.raises(cadet.CadetError, match="more_maps: unknown map 'flow'; known: normals, optical_flow"):
        street.capture(more_maps=["flow"])
    with pytest.raises(cadet.CadetError, match="flow_s: expected"):
        street.capture(more_maps=["optical_flow"], flow_s=0.0)
