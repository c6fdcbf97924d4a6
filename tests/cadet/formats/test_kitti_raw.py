"""KITTI's raw layout: the gray cameras, and the times of a scan that turns."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet.errors import KittiFormatError, MissingFileError
from cadet.formats.kitti_sequences import KittiRawExporter, RawDrive
from cadet.formats.kitti_sequences.raw_drive import is_raw_drive
from cadet.generate import Settings, generate
from raw_drives import write_raw_drive
from synthetic import make_frame

RIG = cadet.Rig(camera=cadet.Camera.kitti().resized(310, 94), lidar=cadet.Lidar.vlp16())


@pytest.mark.parametrize(("name", "offset"), [("image_0", "cam0"), ("image_1", "cam1")])
def test_gray_images_are_seen_from_where_the_gray_cameras_stand(name: str, offset: str) -> None:
    """A camera mounted there has the same depth in every pixel, and the same light but for exposure and noise."""
    rig = RIG
    ego_from_cam = rig.ego_from_sensor(name)
    if offset == "cam1":
        ego_from_cam[:3, 3] -= ego_from_cam[:3, :3] @ rig.camera.cam1_from_cam0_m
    kept = {key: getattr(rig.camera, key) for key in ("fx", "fy", "cx", "cy")}
    mine = cadet.MountedCamera(
        name="mine", camera=cadet.Camera(width=310, height=94, **kept), pose=cadet.Pose.from_matrix(ego_from_cam)
    )
    scene = cadet.Scene.empty(rig=replace(rig, more=(mine,)))
    scene.add("car", x_m=9.0, y_m=-1.0, yaw_rad=0.4)
    sample = scene.capture(sensors=(name, "mine")).sample
    assert sample is not None
    seen, expected, left = (sample.maps(camera) for camera in (name, "mine", None))
    assert seen is not None and expected is not None and left is not None
    np.testing.assert_allclose(seen.depth, expected.depth, rtol=1e-4)
    assert not np.allclose(seen.depth, left.depth, rtol=1e-2)
    mine_image, its_image = (cv2.blur(sample.image(camera).astype(np.float32), (9, 9)) for camera in ("mine", name))
    # Each camera exposes for itself.
    assert np.abs(its_image * (mine_image.mean() / its_image.mean()) - mine_image).mean() < 1.5
    gray = cv2.imdecode(np.frombuffer(KittiRawExporter().encode(sample, (name,))[name], np.uint8), cv2.IMREAD_UNCHANGED)
    assert gray is not None and gray.shape == (94, 310)
    wanted = cv2.cvtColor(sample.image(name), cv2.COLOR_RGB2GRAY)
    assert np.abs(gray.astype(int) - wanted.astype(int)).max() <= 1


@pytest.mark.parametrize("rolling", [False, True])
def test_a_turning_scan_starts_before_its_instant_and_ends_after_it(rolling: bool, tmp_path: Path) -> None:
    table = replace(cadet.Lidar.vlp16().beam_table(), name="fast", rate_hz=20.0, start_azimuth_deg=90.0)
    rig = replace(RIG, name="turning", lidar=replace(cadet.Lidar.custom(table), rolling=rolling))
    policy = cadet.ResetPolicy.kitti().with_rig(rig).as_sequence(hz=10, length_s=1.2)
    generate(tmp_path / "out", Settings(seed=8, num_frames=3, policy=policy, format="kitti_raw"), workers=1)
    drive = tmp_path / "out" / "2020_01_01" / "2020_01_01_drive_0000_sync"
    # Clockwise from the left, a quarter of a turn before it looks forward.
    begin_s, end_s = (-0.0125, 0.0375) if rolling else (0.0, 0.0)
    times = {}
    for name in ("velodyne_points/timestamps", "image_02/timestamps", "oxts/timestamps"):
        times[name] = seconds_of(drive / f"{name}.txt")
        np.testing.assert_allclose(times[name], [2.0, 2.1, 2.2], atol=1e-9)
    for part, late_s in (("start", begin_s), ("end", end_s)):
        found = seconds_of(drive / f"velodyne_points/timestamps_{part}.txt")
        np.testing.assert_allclose(found - times["velodyne_points/timestamps"], late_s, atol=1e-9)


def test_a_drive_is_read_as_frames(tmp_path: Path) -> None:
    frame = make_frame(labels=())
    folder = write_raw_drive(tmp_path, [frame, replace(frame, points_velo=frame.points_velo[:9])])
    drive = RawDrive(folder)
    assert is_raw_drive(folder) and not is_raw_drive(tmp_path) and drive.ids == ("0000000000", "0000000001")
    first, second = map(drive.read_frame, drive.ids)
    assert np.array_equal(first.image, frame.image) and np.array_equal(first.points_velo, frame.points_velo)
    assert len(second.points_velo) == 9 and not first.labels and first.plane is None
    for name in ("P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo"):
        np.testing.assert_allclose(getattr(drive.calib, name), getattr(frame.calib, name), rtol=1e-6, atol=1e-9)
    assert drive.has("velodyne", "0000000001") and drive.has("calib", "0000000001")
    assert not drive.has("velodyne", "0000000002") and not drive.has("label_2", "0000000001")


def test_what_a_drive_lacks_is_named(tmp_path: Path) -> None:
    folder = write_raw_drive(tmp_path, [make_frame(labels=())])
    cameras = folder.parent / "calib_cam_to_cam.txt"
    text = cameras.read_text()
    with pytest.raises(MissingFileError, match=r"sync: frame 0000000000: a raw drive has no labels"):
        RawDrive(folder).read_labels("0000000000")
    with pytest.raises(MissingFileError, match=r"0000000007\.png: no such file"):
        RawDrive(folder).read_frame("0000000007")
    for damaged, message in (
        (text.replace("P_rect_02", "P_rect_05"), r"calib_cam_to_cam\.txt: missing key 'P_rect_02'"),
        (text.replace("R_rect_00: ", "R_rect_00: 1.0 "), r"R_rect_00: expected 9 numbers, got 10"),
        (text.replace("R_rect_00: ", "R_rect_00: x"), r"R_rect_00: .*'x"),
    ):
        cameras.write_text(damaged)
        with pytest.raises(KittiFormatError, match=message):
            _ = RawDrive(folder).calib
    cameras.unlink()
    with pytest.raises(MissingFileError, match=r"2011_09_26/calib_cam_to_cam\.txt: no such file"):
        RawDrive(folder).read_frame("0000000000")
    (folder / "image_02" / "data" / "0000000000.png").unlink()
    with pytest.raises(MissingFileError, match="no images: expected files such as"):
        RawDrive(folder)


def seconds_of(path: Path) -> NDArray[np.float64]:
    """Return the seconds since noon: a scene has lasted two at its first sample."""
    noon = datetime(2020, 1, 1, 12)
    return np.array(
        [
            (datetime.fromisoformat(line[:26]) - noon).total_seconds() + float(line[26:]) * 1e-9
            for line in path.read_text().splitlines()
        ]
    )
