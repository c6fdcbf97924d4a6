"""Bags of ROS 2's messages: what two independent readers find in them, and that they are whole however a run went."""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet._util.sink import LocalSink
from cadet.formats.packing_sink import PackingSink
from cadet.formats.ros_bags.bag_format import Bag, BagFormat
from cadet.formats.ros_bags.message_block import Message, block_of_bytes, bytes_of_block
from cadet.generate import Settings, generate
from cadet.sensors.sample import Sample, Wanted
from cadet.simulation.episode import Episode
from gen_process import tree

SAMPLES, HZ = 3, 10
EVERY = [("val" if number >= SAMPLES else "train", number) for number in range(2 * SAMPLES)]
Topics = dict[str, list[tuple[int, Any]]]


def settings(num_frames: int = 2 * SAMPLES) -> Settings:
    rig = cadet.Rig(
        camera=replace(cadet.Camera.kitti().resized(310, 94), distortion=(-0.1, 0.01, 0.0, 0.001, 0.0)),
        lidar=cadet.Lidar.vlp16(rolling=True),
    )
    policy = (
        cadet.ResetPolicy.kitti().with_rig(rig).with_weathers("clear_noon").as_sequence(hz=HZ, length_s=SAMPLES / HZ)
    )
    return Settings(seed=4, num_frames=num_frames, policy=policy, format="mcap")


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    for library in ("mcap", "rosbags"):
        pytest.importorskip(library, reason=f"needs {library}")
    out = tmp_path_factory.mktemp("bags") / "out"
    generate(out, settings(), workers=1)
    return out


@pytest.fixture(scope="module")
def samples() -> list[Sample]:
    episode = Episode(settings().policy, 4, 0, wanted=Wanted(shares=True))
    return [episode.next_sample(number) for number in range(SAMPLES)]


def read(path: Path) -> Topics:
    """Read a bag with rosbags: times and messages by topic."""
    from rosbags.highlevel import AnyReader

    found: Topics = {}
    with AnyReader([path]) as reader:
        for connection, time_ns, data in reader.messages():
            found.setdefault(connection.topic, []).append((time_ns, reader.deserialize(data, connection.msgtype)))
    return found


def rows_of(cloud: Any) -> NDArray[Any]:
    kinds = {7: "<f4", 4: "<u2"}
    record = np.dtype(
        {
            "names": [field.name for field in cloud.fields],
            "formats": [kinds[field.datatype] for field in cloud.fields],
            "offsets": [field.offset for field in cloud.fields],
            "itemsize": cloud.point_step,
        }
    )
    return np.frombuffer(bytes(cloud.data), record)


def matrix(place: Any, turn: Any) -> NDArray[np.float64]:
    pose = cadet.Pose(position_m=(place.x, place.y, place.z), quaternion_wxyz=(turn.w, turn.x, turn.y, turn.z))
    return pose.matrix()


def transforms(message: Any) -> dict[str, NDArray[np.float64]]:
    """Return the pose of each frame on the map."""
    found = {"map": np.eye(4)}
    for one in message.transforms:
        pose = matrix(one.transform.translation, one.transform.rotation)
        found[one.child_frame_id] = found[one.header.frame_id] @ pose
    return found


def test_a_bag_holds_what_the_sensors_took(root: Path, samples: list[Sample]) -> None:
    bag = read(root / "train" / "000000.mcap")
    assert {topic: len(messages) for topic, messages in bag.items()} == dict.fromkeys(
        ("/odom", "/tf", "/objects", "/velodyne/points", "/image_2/camera_info", "/image_2/image_raw/compressed"),
        SAMPLES,
    )
    for number, sample in enumerate(samples):
        time_ns, cloud = bag["/velodyne/points"][number]
        stamp = cloud.header.stamp
        time_us = 1_577_836_800 * 10**6 + round(sample.time_s * 1e6)
        assert time_ns == stamp.sec * 10**9 + stamp.nanosec == time_us * 1000
        rows, scan = rows_of(cloud), sample.scan()
        # Names, types, and offsets of velodyne_pointcloud.
        assert [(field.name, field.offset) for field in cloud.fields] == [
            *(("x", 0), ("y", 4), ("z", 8), ("intensity", 12), ("ring", 16), ("time", 18))
        ]
        assert (cloud.height, cloud.width, cloud.row_step) == (1, len(scan.ring), 22 * len(scan.ring))
        for index, name in enumerate(("x", "y", "z", "intensity")):
            np.testing.assert_array_equal(rows[name], scan.points_velo[:, index])
        np.testing.assert_array_equal(rows["ring"], scan.ring)
        np.testing.assert_array_equal(rows["time"], scan.time_s)
        image = cv2.imdecode(bag["/image_2/image_raw/compressed"][number][1].data, cv2.IMREAD_COLOR)
        assert image is not None
        np.testing.assert_array_equal(image[..., ::-1], sample.image())
        info = bag["/image_2/camera_info"][number][1]
        camera = sample.rig.camera
        assert (info.width, info.height, info.distortion_model) == (310, 94, "plumb_bob")
        assert info.d.tolist() == list(camera.distortion) and info.header.frame_id == "image_2"
        assert info.k.tolist() == [camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1]
        assert info.p.reshape(3, 4)[:, :3].ravel().tolist() == info.k.tolist()


def test_the_ego_moves_as_its_odometry_says(root: Path, samples: list[Sample]) -> None:
    bag = read(root / "train" / "000000.mcap")
    for number, sample in enumerate(samples):
        odometry, poses = bag["/odom"][number][1], transforms(bag["/tf"][number][1])
        pose = matrix(odometry.pose.pose.position, odometry.pose.pose.orientation)
        np.testing.assert_allclose(pose, sample.world_from_ego, atol=1e-9)
        np.testing.assert_allclose(pose, poses["base_link"], atol=1e-9)
        assert (odometry.header.frame_id, odometry.child_frame_id) == ("map", "base_link")
        twist = odometry.twist.twist.linear
        assert twist.x == pytest.approx(sample.ego_speed_mps, abs=0.05) and abs(twist.y) < 0.3
        for name in ("velodyne", "image_2"):
            pose = sample.world_from_ego @ sample.rig.ego_from_sensor(name)
            # KITTI's published rotations are none to the last digit.
            np.testing.assert_allclose(poses[name], pose, atol=1e-6)
    places = [message.pose.pose.position for _, message in bag["/odom"]]
    moved_m = np.hypot(places[1].x - places[0].x, places[1].y - places[0].y)
    assert moved_m == pytest.approx(samples[0].ego_speed_mps / HZ, abs=0.1) and moved_m > 0.1


def test_objects_are_where_their_points_are(root: Path, samples: list[Sample]) -> None:
    bag = read(root / "train" / "000000.mcap")
    num_points = 0
    for number, sample in enumerate(samples):
        rows = rows_of(bag["/velodyne/points"][number][1])
        world_from_velo = transforms(bag["/tf"][number][1])["velodyne"]
        points = np.c_[rows["x"], rows["y"], rows["z"], np.ones(len(rows))] @ world_from_velo.T
        detections = bag["/objects"][number][1].detections
        kinds = {str(agent.id): agent.type for agent in sample.agents}
        assert len(detections) > 5
        for found in detections:
            assert found.results[0].hypothesis.class_id == kinds[found.id] and found.results[0].hypothesis.score == 1.0
            local = points @ np.linalg.inv(matrix(found.bbox.center.position, found.bbox.center.orientation)).T
            half = np.array([found.bbox.size.x, found.bbox.size.y, found.bbox.size.z]) / 2
            inside = (np.abs(local[:, :3]) < half + 0.1).all(axis=1)
            is_its = sample.scan().actor_id == int(found.id)
            num_points += int(is_its.sum())
            # Who moves is met a little before or after the instant.
            assert inside[is_its].mean() > 0.8 if is_its.sum() > 20 else True
    assert num_points > 100


def test_the_library_of_mcap_reads_the_same_messages(root: Path) -> None:
    from mcap.reader import make_reader

    path = root / "val" / "000001.mcap"
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        assert (header.profile, header.library) == ("ros2", "cadet") and summary is not None
        assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
        rows = list(reader.iter_messages())
    assert [message.log_time for *_, message in rows] == sorted(message.log_time for *_, message in rows)
    ours = read(path)
    assert {channel.topic for _, channel, _ in rows} == set(ours)
    assert len(rows) == sum(map(len, ours.values())) == 6 * SAMPLES
    assert {message.sequence for *_, message in rows} == {3, 4, 5}


def test_the_manifest_names_every_sample_and_the_format(root: Path) -> None:
    manifest = json.loads((root / "manifest.json").read_text())
    assert manifest["dataset_format"] == "mcap" and manifest["counts"]["frames"] == 2 * SAMPLES
    names = [f"{split}/{number // SAMPLES:06d}.mcap/{number:06d}.messages" for split, number in EVERY]
    assert [name for name in manifest["sha256"] if name.endswith(".messages")] == names
    with pytest.raises(cadet.MissingFileError, match="a set of format mcap"):
        cadet.kitti.Dataset(root)


def test_workers_and_interruptions_change_no_byte(root: Path, tmp_path: Path) -> None:
    generate(tmp_path / "two", settings(), workers=2)
    assert tree(tmp_path / "two") == tree(root)

    class StoppedError(Exception):
        pass

    num_done = 0

    def stop(_: bool) -> None:
        nonlocal num_done
        num_done += 1
        if num_done == 2:
            raise StoppedError

    with pytest.raises(StoppedError):
        generate(tmp_path / "cut", settings(), workers=1, on_frame=stop)
    # What is there of an episode that is not whole is no bag yet.
    assert not list(tmp_path.glob("cut/*/*.mcap"))
    generate(tmp_path / "cut", settings(), workers=1, resume=True)
    assert tree(tmp_path / "cut") == tree(root)


def test_a_bag_grows_with_the_set_and_damage_is_mended(root: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    generate(out, settings(SAMPLES + 1), workers=1)
    assert len(read(out / "val" / "000001.mcap")["/odom"]) == 1
    generate(out, settings(), workers=1, resume=True)
    assert tree(out) == tree(root)
    for name, at in (("train/000000.mcap", 0.4), ("val/000001.mcap", 0.999)):
        data = bytearray((out / name).read_bytes())
        data[int(at * len(data))] ^= 0xFF
        (out / name).write_bytes(data)
        generate(out, settings(), workers=1, resume=True)
        assert tree(out) == tree(root)
    (out / "val/000001.mcap").write_bytes((root / "val/000001.mcap").read_bytes()[:-100])
    generate(out, settings(), workers=1, resume=True)
    assert tree(out) == tree(root)


def test_a_byte_beside_the_messages_is_mended_too(root: Path, tmp_path: Path) -> None:
    """Indexes, definitions, and the summary, of which the hashes of messages tell nothing."""
    path = tmp_path / "train" / "000000.mcap"
    shutil.copytree(root / "train", tmp_path / "train")
    sink = settings().exporter.store(LocalSink(tmp_path), settings().place)
    assert isinstance(sink, PackingSink)
    whole, bag = path.read_bytes(), Bag(path)
    blocks = [bag.read(name) for name in bag.members]
    places = [whole.index(text, len(whole) // 2) for text in (b"ros2msg", b"velodyne/points", b"uint8 INT8")]
    num_mended = 0
    for at in (*places, len(whole) - 40, len(whole) - 2):
        path.write_bytes(whole[:at] + b"~" + whole[at + 1 :])
        damaged = list(BagFormat().views(path))
        if damaged and [damaged[0].read(name) for name in damaged[0].members] == blocks:
            assert not BagFormat().is_sound(LocalSink(tmp_path), "train/000000.mcap")
            sink.mend("train/000000.mcap")
            assert path.read_bytes() == whole
            num_mended += 1
    assert num_mended > 1


def test_a_sample_is_read_in_any_order(root: Path) -> None:
    bag = Bag(root / "train" / "000000.mcap")
    assert bag.members == tuple(f"{number:06d}.messages" for number in range(SAMPLES))
    forward = [bag.read(name) for name in bag.members]
    assert [bag.read(name) for name in reversed(bag.members)] == forward[::-1]
    with pytest.raises(KeyError):
        bag.read("000009.messages")
    assert bag.read(bag.members[1]) == forward[1]
    assert not list(BagFormat().views(root / "manifest.json"))


def test_blocks_of_messages_come_back() -> None:
    messages = [Message("/a", "b/msg/C", b"\n1"), Message("/d", "e/msg/F", b"")]
    assert block_of_bytes(bytes_of_block(12, messages)) == (12, messages)


def test_what_does_not_fit_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    policy = cadet.ResetPolicy.kitti().as_sequence(hz=2, length_s=2)
    with pytest.raises(cadet.CadetError, match=r"cannot write the sensor '2nd' of the rig .*: ROS has letters"):
        Settings(policy=policy.with_rig(cadet.Rig(camera_name="2nd")), format="mcap")
    with pytest.raises(cadet.CadetError, match="mcap: expected a sequence"):
        Settings(policy=cadet.ResetPolicy.kitti(), format="mcap")
    monkeypatch.setitem(sys.modules, "mcap", None)
    with pytest.raises(cadet.CadetError, match=r"^--format mcap needs mcap: pip install 'cadet-sim\[mcap\]'$"):
        generate(tmp_path / "out", settings(), workers=1)
    assert not (tmp_path / "out").exists()
