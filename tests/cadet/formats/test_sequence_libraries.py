"""Sequences in 123D's Arrow logs and in NVIDIA's NCore V4: converted by each project, opened by its own reader.

NCore's converter of KITTI's raw data is part of its repository, not of its package: `NCORE_CLONE` names a clone.
"""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet.formats.kitti_sequences import RawDrive
from cadet.generate import Settings, generate
from readers.sequence_converters import scenes_of_123d, sequence_of_ncore

pytestmark = pytest.mark.filterwarnings("ignore")

WIDTH, HEIGHT = 200, 112
KEY_FRAMES = (0, 10, 20)
NUM_FRAMES = 10


def records(root: Path, num_frames: int) -> list[dict[str, Any]]:
    """Read what the simulation knew of each frame."""
    return [json.loads((root / "records" / f"{number:06d}.json").read_text()) for number in range(num_frames)]


def moved(points: NDArray[Any], transform: NDArray[Any]) -> NDArray[np.float64]:
    result: NDArray[np.float64] = np.asarray(points, np.float64) @ transform[:3, :3].T + transform[:3, 3]
    return result


def matrix(place: dict[str, Any]) -> NDArray[np.float64]:
    x, y, z = place["translation"]
    w, i, j, k = place["rotation"]
    return cadet.Pose(position_m=(x, y, z), quaternion_wxyz=(w, i, j, k)).matrix()


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a scene in nuScenes' format: 20 sweeps a second, as nuScenes' LIDAR, and so three key frames."""
    pytest.importorskip(
        "py123d.parser.nuscenes.nuscenes_parser",
        reason="reads the folder with py123d: pip install 'py123d[nuscenes]' 'pyarrow<23'",
        exc_type=ImportError,
    )
    rig = cadet.Rig.nuscenes()
    cameras = [mounted for mounted in rig.more if isinstance(mounted, cadet.MountedCamera)]
    more = tuple(replace(mounted, camera=mounted.camera.resized(WIDTH, HEIGHT)) for mounted in cameras)
    rig = replace(rig, camera=rig.camera.resized(WIDTH, HEIGHT), more=more)
    policy = cadet.ResetPolicy.kitti().with_rig(rig).as_sequence(hz=20, length_s=1.05)
    root = tmp_path_factory.mktemp("123d") / "scenes"
    generate(root, Settings(seed=1, num_frames=21, policy=policy, format="nuscenes"), workers=1)
    return root


@pytest.mark.parametrize(
    ("dataset", "numbers"), [("nuscenes", KEY_FRAMES), ("nuscenes-interpolated", tuple(range(0, 21, 2)))]
)
def test_123d_opens_what_its_converter_of_nuscenes_wrote(
    dataset: str, numbers: tuple[int, ...], scenes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUSCENES_DATA_ROOT", str(scenes))
    monkeypatch.setenv("PY123D_DATA_ROOT", str(tmp_path))
    (scene,) = scenes_of_123d(scenes, tmp_path, f"{dataset}_train")
    assert (scene.log_name, scene.number_of_iterations) == ("scene-0001", len(numbers))
    assert len(scene.available_camera_names) == 6
    known = records(scenes, 21)
    num_boxes = 0
    for index, number in enumerate(numbers):
        record = known[number]
        expected_us = (known[number]["time_s"] - known[0]["time_s"]) * 1e6
        times_us = [scene.get_timestamp_at_iteration(at).time_us for at in (0, index)]
        assert times_us[1] - times_us[0] == pytest.approx(expected_us, abs=1)

        world_from_ego = scene.get_ego_state_se3_at_iteration(index).imu_se3.transformation_matrix
        np.testing.assert_allclose(world_from_ego, matrix(record["ego"]), atol=1e-9)

        sensor = record["sensors"]["CAM_FRONT"]
        camera = scene.get_camera_at_iteration(index, "pcam_f0")
        assert (camera.metadata.width, camera.metadata.height) == (WIDTH, HEIGHT)
        np.testing.assert_allclose(camera.metadata.intrinsics.camera_matrix, sensor["camera_intrinsic"])
        world_from_camera = camera.camera_to_global_se3.transformation_matrix
        np.testing.assert_allclose(world_from_camera, matrix(record["ego"]) @ matrix(sensor), atol=1e-6)
        folder = "samples" if number in KEY_FRAMES else "sweeps"
        ours = cv2.imread(str(scenes / folder / "CAM_FRONT" / f"{number:06d}.jpg"))
        assert ours is not None and camera.image.shape == ours.shape
        assert np.abs(camera.image.astype(int) - ours[..., ::-1]).max() <= 2

        xyz_ego = scene.get_lidar_at_iteration(index, "lidar_top").xyz
        scan = np.fromfile(scenes / folder / "LIDAR_TOP" / f"{number:06d}.pcd.bin", np.float32).reshape(-1, 5)
        expected_ego = moved(scan[:, :3], matrix(record["sensors"]["LIDAR_TOP"]))
        np.testing.assert_allclose(xyz_ego, expected_ego, atol=1e-4)

        if number in KEY_FRAMES:
            boxes = scene.get_box_detections_se3_at_iteration(index)
            assert len(boxes) == len(record["objects"]) > 0
            points_world = moved(xyz_ego, world_from_ego)
            for box, seen in zip(boxes, record["objects"], strict=True):
                place = box.center_se3.transformation_matrix
                np.testing.assert_allclose(place, matrix(seen), atol=1e-6)
                size_lwh = [box.bounding_box_se3.length, box.bounding_box_se3.width, box.bounding_box_se3.height]
                np.testing.assert_allclose(size_lwh, np.array(seen["size_wlh"])[[1, 0, 2]], atol=1e-6)
                own = np.abs(moved(points_world, np.linalg.inv(place)))
                num_inside = (own <= np.array(size_lwh) / 2 + 0.1).all(axis=1).sum()
                assert box.attributes.num_lidar_points == seen["num_points"] <= num_inside / 0.9 + 3
                num_boxes += seen["num_points"] > 10
    assert num_boxes > 10


def test_ncore_opens_what_its_converter_of_raw_drives_wrote(tmp_path: Path) -> None:
    pytest.importorskip("ncore.data.v4", reason="reads the folder with ncore: pip install nvidia-ncore")
    clone = os.environ.get("NCORE_CLONE")
    if clone is None:
        pytest.skip("reads the folder with ncore: NCORE_CLONE names no clone of github.com/NVIDIA/ncore")
    rig = cadet.Rig(camera=cadet.Camera.kitti().resized(310, 94), lidar=cadet.Lidar.vlp16())
    policy = cadet.ResetPolicy.kitti().with_rig(rig).as_sequence(hz=10, length_s=1.0)
    root = tmp_path / "drives"
    generate(root, Settings(seed=0, num_frames=NUM_FRAMES, policy=policy, format="kitti_raw"), workers=1)
    drive = RawDrive(root / "2020_01_01" / "2020_01_01_drive_0000_sync")
    sequence = sequence_of_ncore(drive.folder, tmp_path, clone)
    assert (sequence.camera_ids, sequence.lidar_ids) == (["camera_color_left"], ["lidar_top"])
    camera, lidar = sequence.get_camera_sensor("camera_color_left"), sequence.get_lidar_sensor("lidar_top")
    assert camera.frames_count == lidar.frames_count == NUM_FRAMES
    model, p2 = camera.model_parameters, drive.calib.P2
    assert model.resolution.tolist() == [310, 94]
    np.testing.assert_allclose([*model.focal_length, *model.principal_point], p2[[0, 1, 0, 1], [0, 1, 2, 2]], rtol=1e-6)

    def pose(source: str, target: str, time_us: Any) -> NDArray[np.float64]:
        found: NDArray[np.float64] = sequence.pose_graph.evaluate_poses(source, target, np.array(time_us, np.uint64))
        return found

    known = records(root, NUM_FRAMES)
    world_from_velo = [np.array(record["world_from_ego"]) @ np.array(record["ego_from_velo"]) for record in known]
    times_us = lidar.frames_timestamps_us[:, 1]
    # NCore's world is the unit's frame at the first instant.
    ours_from_theirs = world_from_velo[0] @ np.linalg.inv(pose("lidar_top", "world", times_us[0]))
    observations = list(sequence.get_cuboid_track_observations())
    num_boxes = 0
    for index, (frame_id, record, time_us) in enumerate(zip(drive.ids, known, times_us, strict=True)):
        frame = drive.read_frame(frame_id)
        assert int(time_us - times_us[0]) == pytest.approx((record["time_s"] - known[0]["time_s"]) * 1e6, abs=1)
        velo = ours_from_theirs @ pose("lidar_top", "world", time_us)
        np.testing.assert_allclose(velo, world_from_velo[index], atol=1e-3)

        assert np.array_equal(camera.get_frame_handle(index).get_data().get_decoded_image(), frame.image)
        cloud = lidar.get_frame_point_cloud(index, motion_compensation=True, with_start_points=False)
        np.testing.assert_allclose(cloud.xyz_m_end, frame.points_velo[:, :3], atol=1e-3)
        ahead = frame.points_velo[frame.points_velo[:, 0] > 5.0, :3]
        seen_cam = moved(ahead, pose("lidar_top", "camera_color_left", time_us))
        pixels = seen_cam[:, :2] / seen_cam[:, 2:] * model.focal_length + model.principal_point
        projected = np.c_[frame.calib.points_cam_from_velo(ahead), np.ones(len(ahead))] @ p2.T
        # The converter reads a camera's place off P2's last column undivided by the intrinsics: 2 mm to the side.
        np.testing.assert_allclose(pixels, projected[:, :2] / projected[:, 2:], atol=0.1)

        of_frame = [seen for seen in observations if seen.timestamp_us == time_us]
        boxes = [seen.transform("world", int(time_us), sequence.pose_graph) for seen in of_frame]
        centers_world = moved(np.array([box.bbox3.centroid for box in boxes]), ours_from_theirs)
        for seen in record["objects"]:
            if seen["is_labeled"]:
                middle_velo = np.array(seen["pose_velo"][:3]) + [0.0, 0.0, seen["size_lwh"][2] / 2]
                away_m = np.linalg.norm(centers_world - moved(middle_velo, world_from_velo[index]), axis=1)
                nearest = boxes[int(away_m.argmin())]
                assert away_m.min() < 2e-3
                np.testing.assert_allclose(nearest.bbox3.dim, seen["size_lwh"], atol=1e-5)
                num_boxes += 1
    assert num_boxes > 10
