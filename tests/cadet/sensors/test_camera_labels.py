"""Labels of every camera of a rig: in memory, in KITTI's folder and in shards, and in the lint."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import Camera, Lidar, MountedCamera, Pose, Rig, Scene
from cadet.formats.convert import convert
from cadet.formats.kitti.from_sample import calibration_of
from cadet.generate import Settings, generate

LENS = Camera(width=400, height=200, fx=300.0, fy=300.0, cx=199.5, cy=99.5)
REAR = Pose.of_camera((-1.5, 0.1, 1.4), yaw_deg=172, pitch_deg=2, roll_deg=3)


def rig(*cameras: MountedCamera) -> Rig:
    return Rig(camera=LENS, lidar=Lidar.vlp16(), extrinsics=cadet.Extrinsics.aligned()).with_sensors(*cameras)


def rear(camera: Camera = LENS) -> MountedCamera:
    return MountedCamera(name="rear", camera=camera, pose=REAR)


def of_camera(frame: cadet.Frame, name: str) -> cadet.Frame:
    assert frame.sample is not None
    return cadet.kitti.frame_from_sample(frame.sample, name)


def square(of: Rig) -> Scene:
    """A plain square: a car ahead; behind, a car, one that it hides in part, and a pedestrian at the image's edge."""
    scene = Scene.empty(rig=of, config=cadet.SceneConfig(label=cadet.LabelConfig(boxes="exact")))
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.3)
    for kind, ahead_m, left_m, yaw_rad in [
        ("car", 12.0, 1.0, 0.4),
        ("car", -11.0, 1.5, 2.0),
        ("car", -20.0, 4.0, 2.5),
        ("pedestrian", -8.0, 6.0, 1.0),
    ]:
        x = ahead_m * math.cos(0.3) - left_m * math.sin(0.3)
        y = ahead_m * math.sin(0.3) + left_m * math.cos(0.3)
        scene.add(kind, x_m=x, y_m=y, yaw_rad=yaw_rad, model_seed=1)
    return scene


def test_a_further_cameras_labels_are_what_pose_and_pinhole_say() -> None:
    frame = square(rig(rear())).capture()
    labels = frame.camera_labels
    assert list(labels) == ["image_2", "rear"] and labels["image_2"] == frame.labels
    assert [label.type for label in frame.labels] == ["Car"]
    seen = {label.type: label for label in labels["rear"]}
    assert [label.type for label in labels["rear"]] == ["Car", "Car", "Pedestrian"]
    assert frame.sample is not None
    cam_from_world = np.linalg.inv(frame.sample.world_from_ego @ REAR.matrix())
    for agent, label in zip(frame.agents[1:], labels["rear"], strict=True):
        length, width, height = agent.size_lwh
        x, y, z, heading = label.box_cam[[0, 1, 2, 6]]
        # Upright in the camera's frame about the true center, heading as the agent's x axis falls on its x-z plane.
        center = (cam_from_world @ agent.world_from_agent @ [0.0, 0.0, height / 2, 1.0])[:3]
        assert (x, y - height / 2, z) == pytest.approx(center, abs=1e-6)
        ahead = (cam_from_world @ agent.world_from_agent)[:3, 0]
        assert math.sin(heading - math.atan2(-ahead[2], ahead[0])) == pytest.approx(0.0, abs=1e-6)
        assert math.sin(label.alpha - heading + math.atan2(x, z)) == pytest.approx(0.0, abs=1e-6)
        cos, sin = math.cos(heading), math.sin(heading)
        corners = [
            (x + cos * l + sin * w, y - h, z - sin * l + cos * w)
            for l in (-length / 2, length / 2)
            for w in (-width / 2, width / 2)
            for h in (0.0, height)
        ]
        u = [300.0 * cx / cz + 199.5 for cx, _, cz in corners]
        v = [300.0 * cy / cz + 99.5 for _, cy, cz in corners]
        inside = (max(min(u), 0), max(min(v), 0), min(max(u), 399), min(max(v), 199))
        assert label.bbox == pytest.approx(inside, abs=1e-6)
        whole = (max(u) - min(u)) * (max(v) - min(v))
        shown = (inside[2] - inside[0]) * (inside[3] - inside[1])
        assert label.truncated == pytest.approx(1 - shown / whole, abs=1e-6)
    assert seen["Pedestrian"].truncated > 0.05
    # The near car hides some of the far one.
    near, far, _ = labels["rear"]
    assert near.occluded == 0 and far.occluded > 0


def test_a_camera_has_the_same_labels_as_a_rigs_first_and_as_a_further_one() -> None:
    """All fields: a rig whose only camera is the rear one, and one that has it as its second."""
    first = replace(rig(), camera_name="rear")
    turned = np.linalg.inv(REAR.matrix()) @ first.ego_from_sensor("velodyne")
    rows: Any = tuple(tuple(row) for row in turned[:3].tolist())
    first = replace(first, extrinsics=replace(cadet.Extrinsics.aligned(), tr_velo_to_cam=rows))
    bent = replace(LENS, distortion=(-0.2, 0.05, 0.0, 0.0, 0.0))
    for lens in (LENS, bent):
        alone = square(replace(first, camera=lens)).capture()
        beside = of_camera(square(rig(rear(lens))).capture(), "rear")
        assert len(alone.labels) == 3
        for one, other in zip(alone.labels, beside.labels, strict=True):
            assert (one.type, one.occluded) == (other.type, other.occluded)
            for name in ("truncated", "alpha", "bbox", "dimensions_hwl", "location_cam", "rotation_y"):
                assert getattr(one, name) == pytest.approx(getattr(other, name), abs=1e-3), name
        assert alone.meta is not None and beside.meta is not None
        for one, other in zip(alone.meta["objects"], beside.meta["objects"], strict=True):
            assert one["num_points"] == other["num_points"]
            assert one["visible_fraction"] == pytest.approx(other["visible_fraction"], abs=0.01)
        np.testing.assert_allclose(alone.calib.cam_from_velo, beside.calib.cam_from_velo, atol=1e-9)
        np.testing.assert_array_equal(alone.calib.P2, beside.calib.P2)


def test_a_further_cameras_calibration_puts_the_scan_on_its_image() -> None:
    frame = square(rig(rear())).capture()
    seen, scan = of_camera(frame, "rear"), frame.scans["velodyne"]
    assert seen.instance is not None and seen.plane is None and frame.sample is not None
    np.testing.assert_array_equal(seen.image, frame.images["rear"])
    for agent in frame.agents[1:2]:
        points = seen.calib.points_cam_from_velo(scan.points_velo[scan.actor_id == agent.id])
        u, v = np.rint(seen.calib.project(points)).astype(int).T
        assert len(u) > 10 and (seen.instance[v, u] == agent.id).mean() > 0.8
    with pytest.raises(cadet.CadetError, match="no image of the camera 'left'; there are image_2, rear"):
        of_camera(frame, "left")
    assert seen.camera_labels == {} and frame.camera_labels["rear"] == seen.labels


def test_labels_of_the_right_camera_are_projected_by_p3() -> None:
    scene = Scene.random(seed=1, weather="clear_noon", rig=Rig.kitti())
    frame = scene.capture(sensors=["image_3", "image_0"])
    right = frame.camera_labels["image_3"]
    shared = {label.location_cam: label for label in right if not label.is_dont_care}
    pairs = [(label, shared[label.location_cam]) for label in frame.labels if label.location_cam in shared]
    assert len(pairs) > 2
    for left, other in pairs:
        assert (left.dimensions_hwl, left.rotation_y, left.alpha) == (
            other.dimensions_hwl,
            other.rotation_y,
            other.alpha,
        )
        boxes = cadet.kitti.boxes
        projected = boxes.project_boxes(other.box_cam[None], replace(frame.calib, P2=frame.calib.P3))
        assert other.bbox == pytest.approx(boxes.clip_boxes_img(projected, frame.image_size)[0], abs=1e-6)
        assert other.bbox[0] < left.bbox[0] or left.bbox[0] == 0.0
    np.testing.assert_array_equal(of_camera(frame, "image_3").calib.P2, frame.calib.P3)
    np.testing.assert_array_equal(calibration_of(scene._rig, "image_0").P2, frame.calib.P0)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two frames of a stereo camera and one that looks to the rear."""
    root = tmp_path_factory.mktemp("cameras") / "out"
    generate(root, settings(), workers=1)
    return root


def settings(**more: object) -> Settings:
    of = Rig.kitti().with_image_size(310, 94).with_sensors(rear())
    policy = cadet.ResetPolicy.kitti().with_rig(of)
    write = ("image_3", "label_3", "cameras", "depth")
    return Settings(seed=1, num_frames=2, policy=policy, write=write, **more)  # type: ignore[arg-type]


def test_further_cameras_have_folders_like_the_first_ones(written: Path) -> None:
    training = written / "training"
    kinds = {"image_2": ".png", "calib": ".txt", "label_2": ".txt", "depth": ".png"}
    assert {path.name for path in (training / "cameras" / "rear").iterdir()} == set(kinds)
    for kind, suffix in kinds.items():
        files = sorted((training / "cameras" / "rear" / kind).iterdir())
        assert [path.name for path in files] == [f"00000{n}{suffix}" for n in range(2)]
    assert sorted(path.name for path in (training / "label_3").iterdir()) == ["000000.txt", "000001.txt"]
    of = settings().policy.rigs[0][0]
    frame = cadet.kitti.read_frame(written, 0, camera="rear")
    assert frame.image.shape == (200, 400, 3) and frame.depth is not None and frame.meta is None
    assert frame.labels
    np.testing.assert_array_equal(frame.points_velo, cadet.kitti.read_frame(written, 0).points_velo)
    # The car of the episode is pitched by its load, and all its sensors with it.
    np.testing.assert_allclose(frame.calib.cam_from_velo, calibration_of(of, "rear").cam_from_velo, atol=1e-9)
    with pytest.raises(cadet.MissingFileError, match="no camera 'left'; there are rear"):
        cadet.kitti.read_frame(written, 0, camera="left")


def test_the_lint_reads_every_cameras_labels(written: Path, tmp_path: Path) -> None:
    assert cadet.kitti.lint(written) == []
    root = tmp_path / "damaged"
    generate(root, settings(), workers=1)
    folder = root / "training"
    own = folder / "cameras" / "rear" / "label_2" / "000000.txt"
    fields = own.read_text().split()
    fields[4] = f"{float(fields[4]) + 3.0:.2f}"
    own.write_text(" ".join(fields[:15]) + "\n")
    right = folder / "label_3" / "000001.txt"
    right.write_text(right.read_text().replace(" ", " x", 1))
    (folder / "cameras" / "rear" / "calib" / "000001.txt").unlink()
    (folder / "cameras" / "rear" / "image_2" / "000007.png").write_bytes(b"")
    found = {(one.file, one.rule) for one in cadet.kitti.lint(root)}
    assert found == {
        ("cameras/rear/label_2/000000.txt", "label-projection"),
        ("label_3/000001.txt", "damaged-file"),
        ("cameras/rear/calib/000001.txt", "missing-file"),
        ("cameras/rear/image_2/000007.png", "stray-file"),
    }


def test_shards_hold_the_same_bytes_and_lead_back_to_the_folder(written: Path, tmp_path: Path) -> None:
    shards = tmp_path / "shards"
    generate(shards, settings(format="webdataset"), workers=1)
    convert(written, tmp_path / "converted", "webdataset")
    tar = Path("train", "000000.tar")
    assert (shards / tar).read_bytes() == (tmp_path / "converted" / tar).read_bytes()
    done = convert(shards, tmp_path / "back", "kitti")
    assert done.left_out == ()
    here, there = (
        {path.relative_to(root): path.read_bytes() for path in root.rglob("*") if path.is_file()}
        for root in (written / "training", tmp_path / "back" / "training")
    )
    assert here == there and Path("cameras/rear/label_2/000001.txt") in here


def test_what_a_rig_has_no_camera_for_is_refused() -> None:
    for write, of, message in [
        ("cameras", Rig.kitti(), "cannot write cameras: the rig kitti has no further camera"),
        ("label_3", Rig.paper(), "cannot write label_3: the rig paper has no right color camera"),
        (
            "cameras",
            rig(MountedCamera(name="a/b", camera=LENS, pose=REAR)),
            "cannot write the camera 'a/b' of the rig custom: expected letters, digits, _, and -, up to 64",
        ),
    ]:
        with pytest.raises(cadet.CadetError, match=message):
            Settings(policy=cadet.ResetPolicy.kitti().with_rig(of), write=(write,))
    several = cadet.ResetPolicy.kitti()
    mixed = replace(several, rigs=((Rig.kitti().with_sensors(rear()), 0.5), (rig(replace(rear(), name="b")), 0.5)))
    with pytest.raises(cadet.CadetError, match="expected the same further cameras on all rigs"):
        _ = Settings(policy=mixed, write=("cameras",)).kinds
