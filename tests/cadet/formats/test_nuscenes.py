"""A set in nuScenes' format: tables that refer to each other, boxes on points, and what the devkit makes of it."""

from __future__ import annotations

import json
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np
import pytest

import cadet
from cadet._util.sink import Sink
from cadet.formats.nuscenes import VERSION
from cadet.formats.nuscenes.classes import ATTRIBUTES, CATEGORIES, attribute, category, visibility
from cadet.formats.nuscenes.scene_names import scene_names
from cadet.generate import Settings, generate

SCENES, SAMPLES = 2, 5


class Memory:
    """Files that are read back."""

    def __init__(self, files: dict[str, bytes]) -> None:
        self.files = files

    def read_all(self, names: list[str]) -> list[bytes]:
        return [self.files[name] for name in names]


CHANNELS = 7


def small_rig() -> cadet.Rig:
    """nuScenes' rig with images of a quarter of the size."""
    rig = cadet.Rig.nuscenes()
    more = []
    for mounted in rig.more:
        assert isinstance(mounted, cadet.MountedCamera)
        more.append(replace(mounted, camera=mounted.camera.resized(400, 225)))
    return replace(rig, camera=rig.camera.resized(400, 225), more=tuple(more))


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("nuscenes") / "out"
    policy = cadet.ResetPolicy.kitti().with_rig(small_rig()).as_sequence(hz=2, length_s=SAMPLES / 2)
    generate(out, Settings(seed=1, num_frames=SCENES * SAMPLES, policy=policy, format="nuscenes"), workers=1)
    return out


@pytest.fixture(scope="module")
def tables(root: Path) -> dict[str, list[dict[str, Any]]]:
    names = "category attribute visibility instance sensor calibrated_sensor ego_pose log scene sample sample_data"
    names += " sample_annotation map"
    return {name: json.loads((root / VERSION / f"{name}.json").read_text()) for name in names.split()}


def test_a_rolling_shutter_is_stamped_with_the_middle_of_its_exposures(tmp_path: Path) -> None:
    """The tables have one time an image: that of the global shutter's instant, where labels and ego pose are known."""
    written = {}
    for name, seconds in (("global", 0.0), ("rolling", 0.02)):
        rig = small_rig()
        rig = replace(rig, camera=replace(rig.camera, rolling_shutter_s=seconds))
        policy = cadet.ResetPolicy.kitti().with_rig(rig).as_sequence(hz=2, length_s=1.0)
        generate(tmp_path / name, Settings(seed=1, num_frames=2, policy=policy, format="nuscenes"), workers=1)
        tables = [(tmp_path / name / VERSION / f"{table}.json").read_text() for table in ("sample_data", "ego_pose")]
        files = sorted((tmp_path / name / "samples").glob("CAM_*/*.jpg"))
        written[name] = (tables, {str(file.relative_to(tmp_path / name)): file.read_bytes() for file in files})
    (tables, images), (others, rolled) = written["global"], written["rolling"]
    assert tables == others
    assert images.keys() == rolled.keys()
    # Only the front camera's rows are of other times; the others are exposed as it is, and differ by its gain alone.
    for name, data in images.items():
        encoded = [np.frombuffer(of, np.uint8) for of in (data, rolled[name])]
        one, other = (np.asarray(cv2.imdecode(file, cv2.IMREAD_COLOR), np.float64) for file in encoded)
        difference = np.abs(one - other).mean()
        assert difference > 1.5 if "CAM_FRONT/" in name else difference < 1.0, (name, difference)


def matrix(row: dict[str, Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    x, y, z = row["translation"]
    w, i, j, k = row["rotation"]
    return cadet.Pose(position_m=(x, y, z), quaternion_wxyz=(w, i, j, k)).matrix()


def test_every_token_is_unique_and_every_reference_leads_somewhere(tables: dict[str, list[dict[str, Any]]]) -> None:
    tokens = {name: {row["token"] for row in rows} for name, rows in tables.items()}
    for name, rows in tables.items():
        assert len(tokens[name]) == len(rows) > 0, name
    chained = {"sample", "sample_data", "sample_annotation"}
    aliases = {"first_sample": "sample", "last_sample": "sample"}
    aliases |= {"first_annotation": "sample_annotation", "last_annotation": "sample_annotation"}
    num_references = 0
    for name, rows in tables.items():
        for row in rows:
            for key, value in row.items():
                if key in ("prev", "next"):
                    assert name in chained and (value == "" or value in tokens[name])
                elif key.endswith("_token"):
                    target = key.removesuffix("_token")
                    assert value in tokens[aliases.get(target, target)], (name, key)
                    num_references += 1
                elif key.endswith("_tokens"):
                    target = key.removesuffix("_tokens")
                    assert value and set(value) <= tokens[target], (name, key)
    assert num_references > 500
    # By nuScenes-lidarseg's table; converters of VAD and Senna take the index for granted.
    indices = {row["name"]: row["index"] for row in tables["category"]}
    assert indices["human.pedestrian.adult"] == 2 and indices["vehicle.car"] == 17 and indices["vehicle.truck"] == 23
    assert indices["noise"] == 0 and indices["flat.driveable_surface"] == 24 and indices["static.vegetation"] == 30
    assert sorted(indices.values()) == list(range(32))


def test_chains_run_through_each_scene_by_half_seconds(tables: dict[str, list[dict[str, Any]]]) -> None:
    samples = {row["token"]: row for row in tables["sample"]}
    assert len(tables["scene"]) == SCENES and len(samples) == SCENES * SAMPLES
    for scene in tables["scene"]:
        times, at = [], scene["first_sample_token"]
        while at:
            times.append(samples[at]["timestamp"])
            assert samples[at]["scene_token"] == scene["token"]
            last, at = at, samples[at]["next"]
        assert last == scene["last_sample_token"] and len(times) == scene["nbr_samples"] == SAMPLES
        assert np.diff(times).tolist() == [500_000] * (SAMPLES - 1)
    for name, key in (("sample_data", "calibrated_sensor_token"), ("sample_annotation", "instance_token")):
        rows = {row["token"]: row for row in tables[name]}
        for row in rows.values():
            if row["next"]:
                assert rows[row["next"]]["prev"] == row["token"] and rows[row["next"]][key] == row[key]
    assert len(tables["sample_data"]) == CHANNELS * len(samples) == len(tables["ego_pose"])
    assert sum(row["next"] == "" for row in tables["sample_data"]) == CHANNELS * SCENES
    annotations = {row["token"]: row for row in tables["sample_annotation"]}
    for instance in tables["instance"]:
        count, at = 0, instance["first_annotation_token"]
        while at:
            count, last, at = count + 1, at, annotations[at]["next"]
        assert (last, count) == (instance["last_annotation_token"], instance["nbr_annotations"])


def test_files_are_there_in_the_size_that_the_tables_say(root: Path, tables: dict[str, list[dict[str, Any]]]) -> None:
    for row in tables["sample_data"]:
        path = root / row["filename"]
        if row["fileformat"] == "jpg":
            image = cv2.imread(str(path))
            assert image is not None and image.shape == (row["height"], row["width"], 3) == (225, 400, 3)
        else:
            points = np.fromfile(path, np.float32).reshape(-1, 5)
            assert len(points) > 5000
            assert points[:, 3].min() >= 0 and points[:, 3].max() <= 255 and points[:, 3].max() > 20
            assert set(np.unique(points[:, 4])) <= set(range(32))
            # Ring 0 is the lowest.
            elevation = np.arctan2(points[:, 2], np.linalg.norm(points[:, :2], axis=1))
            assert elevation[points[:, 4] < 8].mean() < elevation[points[:, 4] >= 24].mean()
    assert (root / tables["map"][0]["filename"]).is_file()


def test_boxes_lie_on_their_points_and_in_the_images(root: Path, tables: dict[str, list[dict[str, Any]]]) -> None:
    by_token = {name: {row["token"]: row for row in rows} for name, rows in tables.items()}
    num_boxes = num_seen = num_inside = num_points = 0
    for data in tables["sample_data"]:
        calibrated = by_token["calibrated_sensor"][data["calibrated_sensor_token"]]
        world_from_sensor = matrix(by_token["ego_pose"][data["ego_pose_token"]]) @ matrix(calibrated)
        annotations = [a for a in tables["sample_annotation"] if a["sample_token"] == data["sample_token"]]
        channel = by_token["sensor"][calibrated["sensor_token"]]["channel"]
        if channel == "LIDAR_TOP":
            points = np.fromfile(root / data["filename"], np.float32).reshape(-1, 5)
            world = np.c_[points[:, :3], np.ones(len(points))] @ world_from_sensor.T
            for annotation in annotations:
                width, length, height = annotation["size"]
                local = np.abs((world @ np.linalg.inv(matrix(annotation)).T)[:, :3])
                num_inside += (local <= np.array([length, width, height]) / 2 + 0.1).all(axis=1).sum()
                num_points += annotation["num_lidar_pts"]
                num_boxes += annotation["num_lidar_pts"] > 20
        else:
            intrinsic = np.array(calibrated["camera_intrinsic"])
            for annotation in annotations:
                middle = np.linalg.inv(world_from_sensor) @ matrix(annotation)[:, 3]
                u, v, z = intrinsic @ middle[:3]
                is_in_image = z > 2.0 and 0 < u / z < 399 and 0 < v / z < 224
                num_seen += is_in_image and annotation["visibility_token"] == "4"
    assert num_boxes > 10 and num_seen > 10
    # Curbs and neighbors add some; arms, mirrors, and tailgates that stand open are missing.
    assert num_inside >= 0.9 * num_points


def test_calibrations_are_the_published_ones_up_to_the_cars_load(tables: dict[str, list[dict[str, Any]]]) -> None:
    """CAM_FRONT of nuScenes' car n015 by calibrated_sensor.json; a load turns the car by a tenth of a degree."""
    sensors = {row["token"]: row["channel"] for row in tables["sensor"]}
    front = [row for row in tables["calibrated_sensor"] if sensors[row["sensor_token"]] == "CAM_FRONT"]
    assert len(front) == SCENES
    for row in front:
        assert row["translation"] == pytest.approx([1.70079118954, 0.0159456324149, 1.51095763913], abs=0.01)
        assert row["rotation"] == pytest.approx([0.4998, -0.5030, 0.4998, -0.4974], abs=0.004)
        # A quarter of 1266.417.
        assert row["camera_intrinsic"][0][0] == pytest.approx(316.604, abs=1e-3)


def test_instances_move_as_their_attributes_say(tables: dict[str, list[dict[str, Any]]]) -> None:
    names = {row["token"]: row["name"] for row in tables["attribute"]}
    annotations = {row["token"]: row for row in tables["sample_annotation"]}
    checked = {"vehicle.parked": 0, "vehicle.moving": 0, "pedestrian.moving": 0, "pedestrian.standing": 0}
    for row in annotations.values():
        name = names[row["attribute_tokens"][0]]
        if row["next"]:
            moved_m = np.linalg.norm(np.subtract(annotations[row["next"]]["translation"], row["translation"]))
            if name == "vehicle.parked":
                assert moved_m < 0.05
            elif name == "vehicle.moving":
                assert moved_m > 0.01
            checked[name] = checked.get(name, 0) + 1
    assert checked["vehicle.parked"] > 5 and checked["vehicle.moving"] + checked["pedestrian.moving"] > 5


def test_levels_and_attributes_have_nuscenes_limits() -> None:
    assert [visibility(share) for share in (None, 0.0, 0.39, 0.4, 0.6, 0.79, 0.8, 1.0)] == list("11123344")
    for (kind, model, speed_mps, fastest_mps), expected in {
        ("Car", "suv/1", 0.0, 0.1): "vehicle.parked",
        ("Van", "small_van/1", 0.0, 5.0): "vehicle.stopped",
        ("Truck", "bus/1", 3.0, 5.0): "vehicle.moving",
        ("Cyclist", "man on bicycle/1", 0.0, 0.0): "cycle.with_rider",
        ("Misc", "motorbike/1", 0.0, 0.0): "cycle.without_rider",
        ("Misc", "caravan/1", 0.0, 0.0): "vehicle.parked",
        ("Pedestrian", "child/1", 1.2, 1.2): "pedestrian.moving",
        ("Pedestrian", "man with pram/1", 0.0, 1.2): "pedestrian.standing",
        ("Person_sitting", "woman/1", 0.0, 0.0): "pedestrian.sitting_lying_down",
    }.items():
        assert attribute(kind, model, speed_mps, fastest_mps) == expected and expected in ATTRIBUTES


def test_categories_follow_the_models_of_the_core() -> None:
    """Every family of models that the core draws, and what nuScenes' annotators would call it."""
    scene = cadet.Scene.empty(rig=cadet.Rig(camera=cadet.Camera.kitti().resized(124, 38)))
    kinds = ("car", "van", "truck", "tram", "misc", "pedestrian", "person_sitting", "cyclist")
    for number, kind in enumerate(kinds):
        for seed in range(120):
            x, y = seed % 12 * 14.0 - 80.0, seed // 12 * 14.0 - 70.0 + number
            scene.add(kind, x_m=x, y_m=y, yaw_rad=0.0, model_seed=seed, overlap="allow")
    found: dict[str, set[str]] = {}
    for agent in scene.agents:
        found.setdefault(category(agent.type, agent.model), set()).add(agent.model.rpartition("/")[0])
    assert set(found) <= set(CATEGORIES)
    vehicles = {f"vehicle.{name}" for name in ("bicycle", "bus.rigid", "car", "motorcycle", "trailer", "truck")}
    assert set(found) == vehicles | {"human.pedestrian.adult", "human.pedestrian.child"}
    assert found["vehicle.bus.rigid"] == {"bus", "light-rail"}
    assert found["vehicle.motorcycle"] == {"motorbike"}
    assert found["vehicle.trailer"] <= {"caravan"} | {f"{it}_trailer" for it in ("box", "open", "covered", "platform")}
    assert found["human.pedestrian.child"] == {"child"} and found["human.pedestrian.adult"] == {"man", "woman"}
    assert {name.split(" on ")[1] for name in found["vehicle.bicycle"]} == {"bicycle"}
    assert not found["vehicle.truck"] & {"bus"} and len(found["vehicle.truck"]) > 5
    # What people carry is drawn where they walk; a user's own vehicle may have any name.
    assert category("Pedestrian", "woman with pram/5") == "human.pedestrian.stroller"
    assert category("Pedestrian", "child with dog/5") == "human.pedestrian.child"
    assert category("Truck", "bus") == category("Truck", "school bus") == "vehicle.truck"


def test_scenes_have_official_names_split_by_split(root: Path) -> None:
    train, val, test = (scene_names(split) for split in ("train", "val", "test"))
    assert [len(names) for names in (train, val, test)] == [700, 150, 150]
    assert len({*train, *val, *test}) == 1000 and all(list(names) == sorted(names) for names in (train, val, test))
    # As the papers and the devkit have them.
    assert train[:4] == ("scene-0001", "scene-0002", "scene-0004", "scene-0005") and train[-1] == "scene-1110"
    assert val[:3] == ("scene-0003", "scene-0012", "scene-0013") and val[-1] == "scene-1073"
    assert test[0] == "scene-0077" and {"scene-0061", "scene-1100"} <= set(train) and {"scene-0103"} <= set(val)
    splits = json.loads((root / VERSION / "splits.json").read_text())
    assert splits == {"train": ["scene-0001"], "val": ["scene-0003"]}
    assert not (root / "v1.0-test").exists()


def test_the_devkits_splits_are_ours() -> None:
    devkit = pytest.importorskip("nuscenes.utils.splits", reason="needs nuscenes-devkit")
    official = devkit.create_splits_scenes()
    assert {split: list(scene_names(split)) for split in ("train", "val", "test")} == {
        split: official[split] for split in ("train", "val", "test")
    }


def test_test_scenes_have_tables_of_their_own() -> None:
    of_version = {"v1.0-trainval": ["scene-0001", "scene-0003", "scene-0002"], "v1.0-test": ["scene-0077"]}
    policy = cadet.ResetPolicy.kitti().as_sequence(hz=2, length_s=0.5)
    settings = Settings(num_frames=4, policy=policy, format="nuscenes", test_fraction=1 / 3)
    record = {"time_s": 0.0, "map": "m", "weather": "w", "sensors": {}, "objects": [], "sha256": {}}
    sink = Memory({settings.exporter.path(place, "record"): json.dumps(record).encode() for place in settings.places()})
    files = settings.exporter.finish(cast(Sink, sink), settings.places()).files
    found = {version: [scene["name"] for scene in json.loads(files[f"{version}/scene.json"])] for version in of_version}
    assert found == of_version
    assert json.loads(files["v1.0-test/splits.json"]) == {"test": ["scene-0077"]}


@pytest.mark.parametrize(("num_frames", "val_fraction", "split"), [(701, 0, "train"), (302, 0.5, "val")])
def test_more_scenes_than_names_are_refused(num_frames: int, val_fraction: float, split: str) -> None:
    policy = cadet.ResetPolicy.kitti().as_sequence(hz=2, length_s=0.5)
    given: dict[str, Any] = {
        "policy": policy,
        "val_fraction": val_fraction,
        "format": "nuscenes",
    }
    Settings(num_frames=num_frames - 1, **given)
    with pytest.raises(cadet.CadetError, match=rf"^nuscenes: \d+ {split} scenes, but nuScenes' own splits name \d+: "):
        Settings(num_frames=num_frames, **given)


def test_a_set_that_was_cut_short_goes_on_to_the_same_bytes(root: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    policy = cadet.ResetPolicy.kitti().with_rig(small_rig()).as_sequence(hz=2, length_s=SAMPLES / 2)
    settings = Settings(seed=1, num_frames=2, policy=policy, format="nuscenes")
    generate(out, settings, workers=1)
    record = out / "records" / "000000.json"
    record.write_text(record.read_text().replace('"ego_speed_mps":', '"ego_speed_mps":1'))
    generate(out, replace(settings, num_frames=3), workers=1, resume=True)
    for name in ("samples/CAM_BACK/000002.jpg", "samples/LIDAR_TOP/000000.pcd.bin", "records/000000.json"):
        assert (out / name).read_bytes() == (root / name).read_bytes()
    with pytest.raises(cadet.CadetError, match="has frames up to 000002 already"):
        generate(out, settings, workers=1, resume=True)


def test_what_does_not_fit_is_refused() -> None:
    policy = cadet.ResetPolicy.kitti().as_sequence(hz=2, length_s=2)
    bent = replace(cadet.Camera.kitti(), distortion=(0.1, 0.0, 0.0, 0.0, 0.0))
    for rig, message in (
        (cadet.Rig(camera=bent), "nuScenes has no distortion"),
        (cadet.Rig(camera_name="a.b"), "it names a folder"),
    ):
        with pytest.raises(cadet.CadetError, match=message):
            Settings(policy=policy.with_rig(rig), format="nuscenes")
    with pytest.raises(
        cadet.CadetError, match="unknown format 'coco'; known: kitti, kitti_tracking, kitti_raw, nuscenes"
    ):
        Settings(policy=cadet.ResetPolicy.kitti(), format="coco")
    with pytest.raises(cadet.CadetError, match="cannot write 'depth'; known: lidarseg"):
        Settings(policy=policy, format="nuscenes", write=("depth",))
    with pytest.raises(cadet.CadetError, match="a rate that divides the 60 steps of a second, got 7"):
        cadet.ResetPolicy.kitti().as_sequence(hz=7, length_s=1)


def test_the_devkit_loads_it_renders_a_sample_and_finds_boxes_on_points(root: Path, tmp_path: Path) -> None:
    pytest.importorskip("nuscenes", reason="needs nuscenes-devkit")
    with warnings.catch_warnings():
        # The devkit's own.
        warnings.simplefilter("ignore")
        import matplotlib

        matplotlib.use("Agg")
        from nuscenes.nuscenes import NuScenes
        from nuscenes.utils.data_classes import LidarPointCloud
        from nuscenes.utils.geometry_utils import points_in_box

        nusc = NuScenes(version=VERSION, dataroot=str(root), verbose=False)
        picture = tmp_path / "sample.png"
        nusc.render_sample(nusc.sample[1]["token"], out_path=str(picture), verbose=False)
        assert cv2.imread(str(picture)) is not None
        num_boxes = 0
        for sample in nusc.sample:
            path, boxes, _ = nusc.get_sample_data(sample["data"]["LIDAR_TOP"])
            points = LidarPointCloud.from_file(path).points[:3]
            for box in boxes:
                expected = nusc.get("sample_annotation", box.token)["num_lidar_pts"]
                if expected >= 10:
                    assert points_in_box(box, points, wlh_factor=1.1).sum() >= 0.9 * expected
                    num_boxes += 1
        assert num_boxes > 10
        speeds = [np.linalg.norm(nusc.box_velocity(row["token"])[:2]) for row in nusc.sample_annotation]
        assert 3.0 < np.nanmax(speeds) < 25.0
