"""Rigs of many sensors: what each of them sees agrees with the others, and what nobody asked for costs nothing."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
import cadet.generate
from cadet import Camera, Lidar, MountedCamera, MountedLidar, Pose, Rig, Scene


def fronto(width: int = 400, height: int = 200, **lens: Any) -> Camera:
    return Camera(width=width, height=height, fx=300.0, fy=300.0, cx=(width - 1) / 2, cy=(height - 1) / 2, **lens)


@pytest.fixture(scope="module")
def street() -> Scene:
    return Scene.random(seed=4, weather="clear_noon", rig=Rig.kitti())


def best_disparity(left: NDArray[Any], right: NDArray[Any], u: int, v: int, around: float) -> float:
    """Find where a patch of the left image lies in the right one, to a fraction of a pixel."""
    half = 8
    patch = left[v - half : v + half + 1, u - half : u + half + 1]
    shift = round(around)
    first = u - shift - half - 5
    strip = right[v - half : v + half + 1, first : first + 2 * half + 11]
    scores = cv2.matchTemplate(strip, patch, cv2.TM_CCOEFF_NORMED)[0]
    k = int(np.argmax(scores))
    if scores[k] < 0.9 or not 0 < k < len(scores) - 1:
        return float("nan")
    a, b, c = scores[k - 1 : k + 2]
    return u - (first + half + k + 0.5 * float((a - c) / (a - 2 * b + c)))


def test_static_points_have_the_disparity_of_their_depth(street: Scene) -> None:
    """(P2[0, 3] - P3[0, 3]) / z, which is what makes the pair a rectified one; depth by the left camera's map."""
    errors: list[float] = []
    for _ in range(4):
        errors += disparity_errors(street.capture(sensors=["image_3"]))
        street.step(3.0)
    found = np.array(errors)[np.isfinite(errors)]
    assert len(found) > 60
    assert np.median(np.abs(found)) < 0.25 and abs(np.median(found)) < 0.15
    assert (np.abs(found) < 1.0).mean() > 0.85


def disparity_errors(frame: cadet.Frame) -> list[float]:
    """Measure the disparity of well-textured static patches less what the calibration says of their depth."""
    left, right = (cv2.cvtColor(frame.images[name], cv2.COLOR_RGB2GRAY) for name in ("image_2", "image_3"))
    assert frame.depth is not None and frame.instance is not None
    baseline = frame.calib.P2[0, 3] - frame.calib.P3[0, 3]
    assert baseline / 721.5377 == pytest.approx(0.5327, abs=1e-3)
    corners = cv2.goodFeaturesToTrack(left, 400, 0.02, 12)
    errors: list[float] = []
    for u, v in corners.reshape(-1, 2).round().astype(int):
        if not (90 < u < left.shape[1] - 12 and 12 < v < left.shape[0] - 12):
            continue
        window = (slice(v - 8, v + 9), slice(u - 8, u + 9))
        depth = frame.depth[window]
        # A patch at one depth, of the world that stands still.
        if frame.instance[window].any() or depth.max() > 1.05 * depth.min() or depth.max() > 40.0:
            continue
        z = float(np.median(depth))
        errors.append(best_disparity(left, right, u, v, baseline / z) - baseline / z)
    return errors


def test_a_frame_is_the_same_whatever_else_is_asked_for(street: Scene) -> None:
    plain, more = street.capture(sensors=[]), street.capture(sensors=["image_3"])
    assert list(plain.images) == ["image_2"] and list(more.images) == ["image_2", "image_3"]
    np.testing.assert_array_equal(plain.image, more.image)
    np.testing.assert_array_equal(plain.points_velo, more.points_velo)
    assert plain.labels == more.labels and plain.meta == more.meta


def test_what_is_not_asked_for_is_not_rendered() -> None:
    rig = Rig(camera=fronto(), lidar=Lidar.vlp16()).with_sensors(
        *(
            MountedCamera(
                name=f"big{k}", camera=Camera(width=1600, height=900, fx=1200, fy=1200, cx=799.5, cy=449.5), pose=at
            )
            for k, at in enumerate([Pose.of_camera((0.0, 0.0, 1.6), yaw_deg=yaw) for yaw in (0, 90, 180)])
        )
    )
    scene = Scene.random(seed=4, weather="clear_noon", rig=rig)
    _ = scene.capture()

    def processor_s(sensors: list[str]) -> float:
        start = time.process_time()
        frame = scene.capture(sensors=sensors)
        assert list(frame.images) == ["image_2", *sensors]
        return time.process_time() - start

    few = min(processor_s([]) for _ in range(3))
    many = min(processor_s(["big0", "big1", "big2"]) for _ in range(3))
    assert many > 3 * few, (few, many)


def square_scene(rig: Rig, left_m: float = 1.0) -> Scene:
    """A plain square with one car 12 m ahead, turned a little, and one behind."""
    scene = Scene.empty(rig=rig, config=cadet.SceneConfig(label=cadet.LabelConfig(boxes="exact")))
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    scene.add("car", x_m=12.0, y_m=left_m, yaw_rad=0.4, model_seed=1)
    scene.add("car", x_m=-10.0, y_m=-1.0, yaw_rad=2.0, model_seed=2)
    return scene


def test_cameras_see_agents_where_their_poses_say() -> None:
    """The agent's box, by world pose, mount and pinhole formula alone, bounds its pixels in the instance map."""
    mounted = {
        "ahead": Pose.of_camera((1.0, 0.3, 1.5), pitch_deg=3, roll_deg=4),
        "back": Pose.of_camera((-1.5, 0.0, 1.4), yaw_deg=172, pitch_deg=-2),
    }
    sensors = [MountedCamera(name=name, camera=fronto(), pose=pose) for name, pose in mounted.items()]
    frame = square_scene(Rig(camera=fronto(), lidar=Lidar.vlp16()).with_sensors(*sensors)).capture()
    assert frame.sample is not None
    for name, pose in mounted.items():
        maps = frame.sample.maps(name)
        assert maps is not None
        agent = frame.agents[0 if name == "ahead" else 1]
        length, width, height = agent.size_lwh
        corners = [(x, y, z, 1.0) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)]
        world = agent.world_from_agent @ (np.array(corners) * [length, width, height, 1.0]).T
        x, y, z, _ = np.linalg.inv(frame.sample.world_from_ego @ pose.matrix()) @ world
        u, v = 300.0 * x / z + 199.5, 300.0 * y / z + 99.5
        rows, columns = np.nonzero(maps.instance == agent.id)
        # A car fills its box but for the rounded corners; mirrors reach a little out.
        assert u.min() - 2.0 <= columns.min() and columns.max() <= u.max() + 2.0, name
        assert columns.max() - columns.min() > 0.82 * (u.max() - u.min()), name
        assert v.min() - 1.0 <= rows.min() and rows.max() <= v.max() + 1.0
        assert rows.max() - rows.min() > 0.75 * (v.max() - v.min())


def test_a_second_lidar_sees_the_same_world_from_its_own_place() -> None:
    pose = Pose.of_angles((0.5, 0.8, 1.2), yaw_deg=-70, pitch_deg=5)
    side = MountedLidar(name="side", lidar=Lidar.vlp16(), pose=pose)
    rig = Rig(camera=fronto(), lidar=Lidar.hdl64e_uniform()).with_sensors(side)
    frame = square_scene(rig).capture()
    assert list(frame.scans) == ["velodyne", "side"] and frame.sample is not None
    scan = frame.scans["side"]
    own = frame.sample.world_from_ego @ pose.matrix()
    points = np.c_[scan.points_velo[:, :3], np.ones(len(scan.points_velo))] @ own.T
    road = points[scan.actor_id == 0]
    # The square is flat at height 0; ranges are off by 8 to 15 mm.
    assert len(road) > 500 and np.abs(np.median(road[:, 2])) < 0.02
    car = frame.agents[0]
    local = np.linalg.inv(car.world_from_agent) @ points[scan.actor_id == car.id].T
    assert local.shape[1] > 20
    assert (np.abs(local[:3].T - [0, 0, car.size_lwh[2] / 2]) <= np.array(car.size_lwh) / 2 + 0.1).all()


def test_lenses_bend_images_and_boxes_by_opencvs_model() -> None:
    """cv2.projectPoints says where the corners of a car's box fall in the distorted image and its maps."""
    bent = (-0.3, 0.1, 0.001, -0.002, 0.0)
    rig = Rig(camera=fronto(distortion=bent), lidar=Lidar.vlp16(), extrinsics=cadet.Extrinsics.aligned())
    frame = square_scene(rig, 5.0).capture()
    straight = square_scene(replace(rig, camera=fronto()), 5.0).capture()
    assert frame.instance is not None and straight.depth is not None and frame.depth is not None
    matrix = np.array([[300.0, 0.0, 199.5], [0.0, 300.0, 99.5], [0.0, 0.0, 1.0]])
    # Every tenth pixel of the straight depth map, as a point, and where OpenCV puts it.
    vs, us = np.mgrid[5:200:10, 5:400:10].reshape(2, -1)
    z = straight.depth[vs, us].astype(np.float64)
    is_ground = np.isfinite(z) & (z < 30.0)
    us, vs, z = us[is_ground], vs[is_ground], z[is_ground]
    points = np.stack([(us - 199.5) / 300.0 * z, (vs - 99.5) / 300.0 * z, z], axis=1)
    pixels = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array(bent))[0].reshape(-1, 2)
    inside = ((pixels > 1) & (pixels < [398, 198])).all(axis=1)
    assert inside.sum() > 300 and np.abs(pixels - np.c_[us, vs])[inside].max() > 10.0
    u, v = pixels[inside].round().astype(int).T
    seen = frame.depth[v, u]
    # Half a pixel of the ground's slope, and none of an edge's.
    close = np.abs(seen / z[inside] - 1.0) < 0.05
    assert close.mean() > 0.95
    # The label's rectangle bounds the car in the distorted image.
    car = next(label for label in frame.labels if label.type == "Car")
    rows, columns = np.nonzero(frame.instance == 1)
    left, top, right, bottom = car.bbox
    assert left - 2 <= columns.min() and columns.max() <= right + 2
    assert columns.max() - columns.min() > 0.82 * (right - left)
    assert top - 1 <= rows.min() and rows.max() <= bottom + 1
    flat = next(label for label in straight.labels if label.type == "Car").bbox
    assert np.abs(np.subtract(flat, car.bbox)).max() > 3.0


def test_a_rolling_shutter_sees_each_row_at_its_time(tmp_path: Path) -> None:
    """A car that crosses at 12 m/s stands f v t / z further in the row of time t than under a global shutter."""
    speed, read_out_s = 12.0, 0.06
    rolling = replace(fronto(), rolling_shutter_s=read_out_s)
    frames = []
    for camera in (fronto(), rolling):
        scene = Scene.empty(rig=Rig(camera=camera, lidar=Lidar.vlp16(), extrinsics=cadet.Extrinsics.aligned()))
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        scene.add("car", x_m=14.0, y_m=-2.0, yaw_rad=math.pi / 2, model_seed=1, speed_mps=speed)
        scene.step(0.1)
        frames.append(scene.capture())
    still, rolled = frames
    assert still.instance is not None and rolled.instance is not None and still.depth is not None
    shifts, expected = [], []
    for row in range(200):
        here, there = (np.flatnonzero(ids[row] == 1) for ids in (still.instance, rolled.instance))
        if min(len(here), len(there)) > 50:
            shifts.append(there.mean() - here.mean())
            time_s = read_out_s * (row / 199 - 0.5)
            # To the left, as the car drives north and the camera looks east.
            expected.append(-300.0 * speed * time_s / float(np.median(still.depth[row, here])))
    assert len(shifts) > 15 and np.ptp(expected) > 1.0
    # Where the roof is flat, a row sees another part of it.
    assert np.percentile(np.abs(np.subtract(shifts, expected)), 90) < 0.8
    assert "rolling_shutter_s=0.06" in repr(rolling) and rolling.unusual() == {"rolling_shutter_s": 0.06}
    with pytest.raises(cadet.CadetError, match=r"Camera.rolling_shutter_s.*0 to 0.1"):
        replace(rolling, rolling_shutter_s=1.0)
    text = (
        'name = "mine"\n[[lidar]]\nname = "top"\nlidar = "vlp16"\nposition_m = [0.9, 0.0, 1.8]\n'
        'quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]\n[[camera]]\nname = "front"\nwidth = 400\nheight = 200\n'
        "fx = 300.0\nfy = 300.0\ncx = 199.5\ncy = 99.5\nrolling_shutter_s = 0.06\n"
        "position_m = [1.7, 0.0, 1.5]\nquaternion_wxyz = [0.5, -0.5, 0.5, -0.5]\n"
    )
    (tmp_path / "mine.toml").write_text(text)
    assert Rig.read(tmp_path / "mine.toml").camera.rolling_shutter_s == 0.06


def test_nuscenes_rig_is_nuscenes() -> None:
    rig = Rig.nuscenes()
    assert rig.camera_names == (
        "CAM_FRONT",
        "CAM_FRONT_RIGHT",
        "CAM_FRONT_LEFT",
        "CAM_BACK",
        "CAM_BACK_LEFT",
        "CAM_BACK_RIGHT",
    )
    assert rig.lidar_names == ("LIDAR_TOP",) and rig.lidar == Lidar.hdl32e()
    # Its images are made for screens, KITTI's for measuring.
    cameras = [rig.sensor(name) for name in rig.camera_names]
    assert all(isinstance(camera, Camera) and camera.response == "srgb" for camera in cameras)
    assert Rig.kitti().camera.response == "linear"
    front, lidar = rig.ego_from_sensor("CAM_FRONT"), rig.ego_from_sensor("LIDAR_TOP")
    # 1.70 m and 0.94 m ahead of the rear axle; the LIDAR's y axis and the camera's z axis look ahead.
    assert (front - lidar)[:3, 3] == pytest.approx([0.757, 0.016, -0.329], abs=1e-3)
    assert front[0, 2] > 0.999 and lidar[0, 1] > 0.999
    yaws = {name: np.degrees(np.arctan2(*rig.ego_from_sensor(name)[[1, 0], 2])) for name in rig.camera_names}
    expected = {"CAM_FRONT": 0, "CAM_FRONT_RIGHT": -56, "CAM_FRONT_LEFT": 55, "CAM_BACK_LEFT": 108}
    for name, yaw in {**expected, "CAM_BACK_RIGHT": -111, "CAM_BACK": 180}.items():
        assert (yaws[name] - yaw + 180) % 360 - 180 == pytest.approx(0, abs=2.0), name


def test_a_loaded_car_turns_all_its_sensors_together() -> None:
    rig = Rig.nuscenes()
    pitched = rig.pitched(1.5)
    names = (*rig.camera_names, *rig.lidar_names)
    reference = "LIDAR_TOP"
    for name in names:
        before = np.linalg.inv(rig.ego_from_sensor(reference)) @ rig.ego_from_sensor(name)
        after = np.linalg.inv(pitched.ego_from_sensor(reference)) @ pitched.ego_from_sensor(name)
        np.testing.assert_allclose(after, before, atol=1e-9)
    assert not np.allclose(pitched.ego_from_sensor("CAM_BACK"), rig.ego_from_sensor("CAM_BACK"))


def test_the_right_image_is_written_beside_the_left_one(tmp_path: Path) -> None:
    settings = cadet.generate.Settings(
        num_frames=1,
        policy=cadet.ResetPolicy.kitti().with_rig(replace(cadet.Rig.kitti(), lidar=cadet.Lidar(rolling=True))),
        write=("image_3", "point_labels", "point_times"),
    )
    cadet.generate.generate(tmp_path / "out", settings, workers=1)
    training = tmp_path / "out" / "training"
    left, right = (cv2.imread(str(training / name / "000000.png")) for name in ("image_2", "image_3"))
    assert left is not None and right is not None and left.shape == right.shape
    assert not np.array_equal(left, right)
    # As SemanticKITTI: a class below, an instance above, one for each point.
    labels = np.fromfile(training / "point_labels" / "000000.label", np.uint32)
    points = np.fromfile(training / "velodyne" / "000000.bin", np.float32).reshape(-1, 4)
    times_s = np.fromfile(training / "point_times" / "000000.bin", np.float32)
    assert len(labels) == len(times_s) == len(points)
    # Clockwise, forward at 0: a laser looks a few degrees beside its point at most.
    azimuth_rad = np.arctan2(points[:, 1], points[:, 0])
    assert np.abs(np.angle(np.exp(1j * (times_s * 20 * np.pi + azimuth_rad)))).max() < 0.1
    classes, instances = labels & 0xFFFF, labels >> 16
    assert {40, 50} <= set(classes.tolist())
    vehicles = np.isin(classes, [10, 18, 252, 258])
    assert (instances[vehicles] > 0).all() and (instances[np.isin(classes, [40, 48, 50, 70, 72])] == 0).all()
    # What is labeled a car has as many points of its instance as its line's meta says.
    frame = cadet.kitti.read_frame(tmp_path / "out", 0)
    assert frame.meta is not None
    for one in frame.meta["objects"]:
        assert (instances == one["actor_id"]).sum() == one["num_points"]


def test_rigs_without_a_right_camera_have_no_right_image() -> None:
    with pytest.raises(cadet.CadetError, match="cannot write image_3: the rig paper has no right color camera"):
        cadet.generate.Settings(policy=cadet.ResetPolicy.paper(), write=("image_3",))
    with pytest.raises(
        cadet.CadetError,
        match="the rig kitti has no sensor 'image_4'; it has image_2, image_3, image_0, image_1, velodyne",
    ):
        Scene.random(seed=1, rig=Rig.kitti()).capture(sensors=["image_4"])
