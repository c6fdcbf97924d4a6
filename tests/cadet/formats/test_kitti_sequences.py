"""Sequences in KITTI's tracking and raw layouts: by the formulas of its development kit, and through pykitti."""

from __future__ import annotations

import json
import math
import shutil
import xml.etree.ElementTree as ElementTree
from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet.formats.kitti_sequences.oxts import FIELDS
from cadet.formats.kitti_sequences.record import calibration_of_record
from cadet.generate import Settings, generate

Array = NDArray[np.float64]

HZ, SAMPLES, EPISODES = 10, 12, 2
NAMES = [name for name, _ in FIELDS]
RAW_DRIVE = "2020_01_01/2020_01_01_drive_0000_sync"


CAMERAS = ("image_3", "image_0", "image_1")


def settings(dataset_format: str, num_frames: int = EPISODES * SAMPLES, **changes: Any) -> Settings:
    rig = cadet.Rig(camera=cadet.Camera.kitti().resized(310, 94), lidar=cadet.Lidar.vlp16())
    policy = cadet.ResetPolicy.kitti().with_rig(rig).as_sequence(hz=HZ, length_s=SAMPLES / HZ)
    chosen = Settings(seed=8, num_frames=num_frames, policy=policy, format=dataset_format)
    return replace(chosen, **changes)


@pytest.fixture(scope="module")
def tracking(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("tracking") / "out"
    generate(root, settings("kitti_tracking"), workers=1)
    return root


@pytest.fixture(scope="module")
def raw(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("raw") / "out"
    generate(root, settings("kitti_raw", write=CAMERAS), workers=1)
    return root


@dataclass(frozen=True)
class Line:
    frame: int
    track: int
    type: str
    truncation: int
    label: cadet.Label


def tracking_labels(path: Path) -> list[Line]:
    found = []
    for line in path.read_text().splitlines():
        frame, track, rest = line.split(" ", 2)
        kind, truncation, _ = rest.split(" ", 2)
        known = rest.replace("Person ", "Person_sitting ", 1)
        found.append(Line(int(frame), int(track), kind, int(truncation), cadet.Label.from_line(known)))
    return found


def records_of(root: Path, episode: int = 0) -> list[dict[str, Any]]:
    first = episode * SAMPLES
    return [json.loads((root / "records" / f"{n:06d}.json").read_text()) for n in range(first, first + SAMPLES)]


def imu_poses(records: list[dict[str, Any]]) -> list[Array]:
    poses = []
    for record in records:
        velo_from_imu = np.vstack([record["calib"]["Tr_imu_to_velo"], [0, 0, 0, 1]])
        poses.append(np.array(record["world_from_ego"]) @ np.array(record["ego_from_velo"]) @ velo_from_imu)
    return poses


def poses_by_the_devkit(rows: Array) -> list[Array]:
    """The formulas of KITTI's convertOxtsToPose.m, about the first place."""
    scale = math.cos(rows[0, 0] * math.pi / 180)
    radius_m = 6378137
    poses = []
    for row in rows:
        lat, lon, alt, roll, pitch, yaw = row[:6]
        pose = np.eye(4)
        pose[0, 3] = scale * lon * math.pi * radius_m / 180
        pose[1, 3] = scale * radius_m * math.log(math.tan((90 + lat) * math.pi / 360))
        pose[2, 3] = alt
        about_x, about_y, about_z = (
            cv2.Rodrigues(np.array(axis))[0] for axis in ([roll, 0, 0], [0, pitch, 0], [0, 0, yaw])
        )
        pose[:3, :3] = about_z @ about_y @ about_x
        poses.append(pose)
    return poses


def test_oxts_project_back_to_the_poses_of_the_unit(tracking: Path) -> None:
    for episode in range(EPISODES):
        rows = np.loadtxt(tracking / "training" / "oxts" / f"{episode:04d}.txt")
        assert rows.shape == (SAMPLES, 30)
        expected = imu_poses(records_of(tracking, episode))
        for found, pose in zip(poses_by_the_devkit(rows), expected, strict=True):
            moved = pose[:3, 3] - expected[0][:3, 3]
            east, north = found[:2, 3] - poses_by_the_devkit(rows)[0][:2, 3]
            np.testing.assert_allclose([east, north, found[2, 3]], [*moved[:2], pose[2, 3]], atol=1e-4)
            np.testing.assert_allclose(found[:3, :3], pose[:3, :3], atol=1e-7)


def test_velocity_acceleration_and_turning_are_the_changes_of_the_poses(tracking: Path) -> None:
    rows = np.loadtxt(tracking / "training" / "oxts" / "0000.txt")
    column = {name: rows[:, index] for index, name in enumerate(NAMES)}
    poses = imu_poses(records_of(tracking))
    places = np.array([pose[:3, 3] for pose in poses])
    velocity = np.column_stack([column["ve"], column["vn"], column["vu"]])
    assert np.linalg.norm(velocity, axis=1).max() > 1.5
    # A mean over two time steps, to what the road's bumps change.
    means = (places[2:] - places[:-2]) * HZ / 2
    np.testing.assert_allclose(velocity[1:-1, :2], means[:, :2], atol=0.05)
    np.testing.assert_allclose(velocity[1:-1, 2], means[:, 2], atol=0.1)
    np.testing.assert_allclose(np.hypot(column["vf"], column["vl"]), np.hypot(column["vn"], column["ve"]), atol=1e-7)
    level = np.arctan2(column["vl"], column["vf"]) + column["yaw"] - np.arctan2(column["vn"], column["ve"])
    np.testing.assert_allclose(np.cos(level), 1.0, atol=1e-9)
    force = np.gradient(velocity, 1 / HZ, axis=0) + [0, 0, 9.80665]
    for index, pose in enumerate(poses):
        in_body = [column[name][index] for name in ("ax", "ay", "az")]
        np.testing.assert_allclose(pose[:3, :3] @ in_body, force[index], atol=1e-6)
        in_level = [column[name][index] for name in ("af", "al", "au")]
        np.testing.assert_allclose(np.linalg.norm(in_level), np.linalg.norm(force[index]), atol=1e-6)
        assert column["au"][index] == pytest.approx(force[index][2], abs=1e-6)
    for index in range(1, SAMPLES - 1):
        turned, _ = cv2.Rodrigues(poses[index - 1][:3, :3].T @ poses[index + 1][:3, :3])
        rates = [column[name][index] for name in ("wx", "wy", "wz")]
        np.testing.assert_allclose(rates, turned[:, 0] * HZ / 2, atol=0.05)


def test_a_track_is_one_object_that_moves_by_its_velocity(tracking: Path) -> None:
    records = records_of(tracking)
    lines = tracking_labels(tracking / "training" / "label_02" / "0000.txt")
    assert [line.frame for line in lines] == sorted(line.frame for line in lines)
    tracks: dict[int, dict[int, cadet.Label]] = defaultdict(dict)
    for line in lines:
        if line.type == "DontCare":
            assert line.track == -1
        else:
            assert line.track >= 1 and line.truncation in (0, 1, 2)
            assert line.frame not in tracks[line.track], "once a frame"
            tracks[line.track][line.frame] = line.label
    calib = calibration(tracking / "training" / "calib" / "0000.txt")
    rectified = np.eye(4)
    rectified[:3, :3] = calib["R_rect"].reshape(3, 3)
    velo_from_cam = np.linalg.inv(rectified @ np.vstack([calib["Tr_velo_cam"].reshape(3, 4), [0, 0, 0, 1]]))
    num_moving = 0
    for track, labels in tracks.items():
        assert len({(label.type, label.dimensions_hwl) for label in labels.values()}) == 1
        places, velocities = {}, {}
        for frame, label in labels.items():
            world_from_velo = np.array(records[frame]["world_from_ego"]) @ np.array(records[frame]["ego_from_velo"])
            places[frame] = (world_from_velo @ velo_from_cam @ [*label.location_cam, 1.0])[:2]
            seen = next(seen for seen in records[frame]["objects"] if seen["id"] == track)
            velocities[frame] = np.array(seen["velocity_world"])[:2]
        first, last = min(labels), max(labels)
        if len(labels) == last - first + 1 > SAMPLES // 2:
            speeds = np.array([velocities[frame] for frame in range(first, last + 1)])
            mean = (speeds[1:] + speeds[:-1]).mean(axis=0) / 2
            # An annotator's box sways by a centimeter or two on its object.
            way = (places[last] - places[first]) * HZ / (last - first)
            np.testing.assert_allclose(way, mean, atol=0.04 * HZ / (last - first))
            num_moving += int(np.linalg.norm(mean) > 0.5)
    assert len(tracks) >= 5 and num_moving >= 2


def calibration(path: Path) -> dict[str, Array]:
    found = {}
    for line in path.read_text().splitlines():
        key, *values = line.split()
        found[key.rstrip(":")] = np.array(values, np.float64)
    return found


def test_tracking_files_are_the_object_formats_of_the_same_samples(tracking: Path, tmp_path: Path) -> None:
    """Image, scan, and labels agree with `--format kitti`, whose own tests check them against the scene."""
    chosen = replace(settings("kitti_tracking", num_frames=3), format="kitti")
    generate(tmp_path / "kitti", chosen, workers=1)
    for number, frame in enumerate(cadet.kitti.Dataset(tmp_path / "kitti")):
        image = cv2.imread(str(tracking / "training" / "image_02" / "0000" / f"{number:06d}.png"))
        assert image is not None
        np.testing.assert_array_equal(image[..., ::-1], frame.image)
        points = np.fromfile(tracking / "training" / "velodyne" / "0000" / f"{number:06d}.bin", np.float32)
        np.testing.assert_array_equal(points.reshape(-1, 4), frame.points_velo)
        lines = [
            line for line in tracking_labels(tracking / "training" / "label_02" / "0000.txt") if line.frame == number
        ]
        assert [line.label.type for line in lines] == [label.type for label in frame.labels]
        for line, label in zip(lines, frame.labels, strict=True):
            np.testing.assert_allclose(line.label.box_cam, label.box_cam, atol=0.0051)
            np.testing.assert_allclose(line.label.bbox, label.bbox, atol=0.0051)
            if not label.is_dont_care:
                assert line.truncation == (label.truncated > 0.15) + (label.truncated > 0.5)
        found = calibration(tracking / "training" / "calib" / "0000.txt")
        for key, name in (("P2", "P2"), ("R_rect", "R0_rect"), ("Tr_velo_cam", "Tr_velo_to_cam")):
            np.testing.assert_array_equal(found[key], getattr(frame.calib, name).ravel())
    assert (tracking / "training" / "evaluate_tracking.seqmap.training").read_text().splitlines() == [
        f"{episode:04d} empty 000000 {SAMPLES:06d}" for episode in range(EPISODES)
    ]
    assert (tracking / "ImageSets" / "train.txt").read_text() == "0000\n"
    assert (tracking / "ImageSets" / "val.txt").read_text() == "0001\n"


def evaluated_by_trackeval(trackeval: Any, root: Path, tracks: dict[str, list[str]], trackers: Path) -> tuple[Any, Any]:
    """Return what TrackEval finds of the cars that a tracker gives each sequence as lines: HOTA, and CLEAR."""
    folder = trackers / "ours" / "data"
    folder.mkdir(parents=True)
    for sequence, lines in tracks.items():
        (folder / f"{sequence}.txt").write_text("".join(f"{line} 1.0\n" for line in lines))
    places = {"GT_FOLDER": str(root / "training"), "TRACKERS_FOLDER": str(trackers), "PRINT_CONFIG": False}
    unwanted = "OUTPUT_SUMMARY OUTPUT_DETAILED PLOT_CURVES PRINT_CONFIG LOG_ON_ERROR".split()
    metrics = [trackeval.metrics.HOTA(), trackeval.metrics.CLEAR()]
    evaluator = trackeval.Evaluator(dict.fromkeys(unwanted))
    found, _ = evaluator.evaluate([trackeval.datasets.Kitti2DBox(places)], metrics)
    cars = found["Kitti2DBox"]["ours"]["COMBINED_SEQ"]["car"]
    return cars["HOTA"], cars["CLEAR"]


def test_trackeval_finds_the_truth_perfect_and_exchanged_ids(tracking: Path, tmp_path: Path) -> None:
    # Its dependency opencv-python would write over opencv-python-headless.
    reason = "reads the folder with trackeval: pip install --no-deps trackeval tabulate"
    trackeval = pytest.importorskip("trackeval", reason=reason, exc_type=ImportError)
    tracks = {path.stem: path.read_text().splitlines() for path in (tracking / "training" / "label_02").glob("*.txt")}
    hota, clear = evaluated_by_trackeval(trackeval, tracking, tracks, tmp_path / "truth")
    assert hota["HOTA"].min() == clear["MOTA"] == 1.0 and clear["CLR_TP"] > 50
    lines = tracking_labels(tracking / "training" / "label_02" / "0000.txt")
    frames = Counter(line.track for line in lines if line.type == "Car" and line.truncation == 0)
    first, second = [str(track) for track, count in frames.items() if count == SAMPLES][:2]
    other = {first: second, second: first}
    fields = [line.split(" ", 2) for line in tracks["0000"]]
    tracks["0000"] = [
        f"{frame} {other.get(track, track) if int(frame) >= SAMPLES // 2 else track} {rest}"
        for frame, track, rest in fields
    ]
    hota, clear = evaluated_by_trackeval(trackeval, tracking, tracks, tmp_path / "exchanged")
    assert clear["MOTA"] == pytest.approx(1.0 - 2 / clear["CLR_TP"]) and hota["HOTA"].mean() < 0.99


def tracklets(path: Path) -> list[tuple[str, Array, int, list[dict[str, float]]]]:
    found = []
    for item in ElementTree.parse(path).getroot().findall("tracklets/item"):
        size = np.array([float(item.findtext(key, "")) for key in "hwl"])
        poses = [{field.tag: float(field.text or "") for field in pose} for pose in item.findall("poses/item")]
        assert int(item.findtext("poses/count", "")) == len(poses)
        found.append((item.findtext("objectType", ""), size, int(item.findtext("first_frame", "")), poses))
    return found


def test_tracklets_hold_every_label_and_go_on_between_them(tracking: Path, raw: Path) -> None:
    drive = raw / RAW_DRIVE
    found = tracklets(drive / "tracklet_labels.xml")
    records = records_of(raw)
    labeled = 0
    for kind, size, first, poses in found:
        assert poses[0]["state"] == poses[-1]["state"] == 2
        for frame, pose in enumerate(poses, start=first):
            place = np.array([pose["tx"], pose["ty"], pose["tz"]])
            if pose["state"] == 2:
                seen = [
                    seen
                    for seen in records[frame]["objects"]
                    if seen["type"].replace("_sitting", " (sitting)") == kind
                    and np.allclose(seen["pose_velo"][:3], place, atol=1e-5)
                ]
                assert len(seen) == 1
                height, width, length = size
                np.testing.assert_allclose(seen[0]["size_lwh"], [length, width, height], atol=1e-6)
                labeled += 1
    lines = tracking_labels(tracking / "training" / "label_02" / "0000.txt")
    assert labeled == sum(line.type != "DontCare" for line in lines) > 20


def test_a_hidden_objects_box_stays_on_its_agent(raw: Path) -> None:
    """Take an object's labels away in two frames: its box must be interpolated to where the label was."""
    from cadet.formats.kitti_sequences.tracklets import tracklets_of

    records = records_of(raw)
    ids = [{seen["id"] for seen in record["objects"] if seen["is_labeled"]} for record in records]
    always = set.intersection(*ids)
    hidden = (4, 5)
    assert always
    for agent in always:
        cut = json.loads(json.dumps(records))
        for frame in hidden:
            cut[frame]["objects"] = [seen for seen in cut[frame]["objects"] if seen["id"] != agent]
        # Others may be hidden for as long by themselves.
        whole = tracklets_of(records)
        (found,) = [
            t
            for t in tracklets_of(cut)
            if sum("<state>1<" in pose for pose in t.poses) == len(hidden) and t not in whole
        ]
        assert len(found.poses) == SAMPLES
        for frame in hidden:
            seen = next(seen for seen in records[frame]["objects"] if seen["id"] == agent)
            pose = ElementTree.fromstring(found.poses[frame])
            place = [float(pose.findtext(key, "")) for key in ("tx", "ty", "tz")]
            # What an annotator's box, which the labels hold, sways on its object.
            np.testing.assert_allclose(place, seen["pose_velo"][:3], atol=0.05)
            assert math.cos(float(pose.findtext("rz", "")) - seen["pose_velo"][3]) > 0.999
        del cut[hidden[0]]["agents"][str(agent)]
        assert len(tracklets_of(cut)) == len(tracklets_of(records)) + 1, "too far away meanwhile: two tracklets"


def test_pykitti_opens_the_raw_data(raw: Path) -> None:
    pykitti = pytest.importorskip("pykitti", reason="needs pykitti")
    for episode, date in enumerate(("2020_01_01", "2020_01_02")):
        drive = pykitti.raw(str(raw), date, f"{episode:04d}")
        records = records_of(raw, episode)
        assert len(drive) == SAMPLES == len(drive.cam2_files) == len(drive.cam3_files) == len(drive.velo_files)
        steps = np.diff([time.timestamp() for time in drive.timestamps])
        np.testing.assert_allclose(steps, 1 / HZ, atol=1e-5)
        expected = imu_poses(records)
        for index, (data, pose) in enumerate(zip(drive.oxts, expected, strict=True)):
            moved = pose.copy()
            moved[:3, 3] -= expected[0][:3, 3]
            np.testing.assert_allclose(data.T_w_imu, moved, atol=1e-4)
            assert drive.get_cam2(index).size == drive.get_cam0(index).size == drive.get_cam1(index).size == (310, 94)
            assert [drive.get_cam0(index).mode, drive.get_cam3(index).mode] == ["L", "RGB"]
        calib = calibration_of_record(records[0])
        np.testing.assert_allclose(drive.calib.P_rect_20, calib.P2, rtol=1e-12)
        np.testing.assert_allclose(drive.calib.T_cam0_velo, calib.cam_from_velo, atol=1e-12)
        np.testing.assert_allclose(drive.calib.T_velo_imu[:3], calib.Tr_imu_to_velo, atol=1e-12)
        points = drive.get_velo(3)
        assert points.shape[1] == 4 and len(points) > 3000


def test_every_camera_of_a_drive_has_its_times(raw: Path) -> None:
    """kitti2bag opens `image_0N/timestamps.txt` of each of the four."""
    for drive in raw.glob("2020_*/*_sync"):
        times = {path.parent.name: path.read_text() for path in drive.glob("image_*/timestamps.txt")}
        assert set(times) == {"image_00", "image_01", "image_02", "image_03"} and len(set(times.values())) == 1


def test_the_cameras_of_the_raw_calibration_see_what_the_projections_do(raw: Path) -> None:
    """K [R T] of the unrectified cameras and P_rect project points to the same pixels, as D is 0."""
    text = (raw / "2020_01_01" / "calib_cam_to_cam.txt").read_text()
    values = {
        key: np.array(rest.split(), np.float64) for key, rest in (line.split(": ") for line in text.splitlines()[1:])
    }
    points_cam = np.random.default_rng(0).uniform([-5, -2, 4], [5, 2, 40], (50, 3))
    rectify = values["R_rect_00"].reshape(3, 3)
    for camera in ("00", "01", "02", "03"):
        projected = values[f"P_rect_{camera}"].reshape(3, 4) @ np.column_stack([points_cam, np.ones(50)]).T
        turned = values[f"R_{camera}"].reshape(3, 3) @ (points_cam @ rectify).T + values[f"T_{camera}"][:, None]
        again = values[f"K_{camera}"].reshape(3, 3) @ values[f"R_rect_{camera}"].reshape(3, 3) @ turned
        np.testing.assert_allclose(again[:2] / again[2], projected[:2] / projected[2], atol=1e-4)
        assert not values[f"D_{camera}"].any()
        assert values[f"S_rect_{camera}"].tolist() == [310, 94]


@pytest.mark.parametrize("dataset_format", ["kitti_tracking", "kitti_raw"])
def test_workers_and_interruptions_change_no_byte(
    dataset_format: str, tracking: Path, raw: Path, tmp_path: Path
) -> None:
    whole = tracking if dataset_format == "kitti_tracking" else raw
    chosen = settings(dataset_format, write=CAMERAS if dataset_format == "kitti_raw" else ())
    out = tmp_path / "out"
    # As a run that was killed leaves it: the last record and the files of the end are missing.
    shutil.copytree(whole, out)
    (out / "records" / "000013.json").unlink()
    (out / "manifest.json").unlink()
    for path in (*out.rglob("oxts/**/*.txt"), *out.rglob("*.xml"), *out.rglob("label_02/*.txt")):
        path.unlink()
    image = next(path for path in sorted(out.rglob("*.png")))
    image.write_bytes(image.read_bytes()[:-1])
    summary = generate(out, chosen, workers=2, resume=True)
    assert summary.num_new == 2
    files = sorted(path.relative_to(whole) for path in whole.rglob("*") if path.is_file())
    assert files == sorted(path.relative_to(out) for path in out.rglob("*") if path.is_file())
    for name in files:
        assert (out / name).read_bytes() == (whole / name).read_bytes(), name


def test_what_does_not_fit_is_refused() -> None:
    for dataset_format in ("kitti_tracking", "kitti_raw"):
        with pytest.raises(cadet.CadetError, match=rf"{dataset_format}: expected a sequence \(--hz"):
            Settings(policy=cadet.ResetPolicy.kitti(), format=dataset_format)
        bent = replace(cadet.Camera.kitti(), distortion=(0.1, 0.0, 0.0, 0.0, 0.0))
        with pytest.raises(cadet.CadetError, match=f"{dataset_format} has no distortion"):
            settings(dataset_format, rig=cadet.Rig(camera=bent))
        with pytest.raises(cadet.CadetError, match="no right color camera"):
            settings(dataset_format, rig=cadet.Rig.paper(), write=("image_3",))
    with pytest.raises(cadet.CadetError, match="cannot write image_0: the rig paper has no gray camera"):
        settings("kitti_raw", rig=cadet.Rig.paper(), write=("image_0",))
