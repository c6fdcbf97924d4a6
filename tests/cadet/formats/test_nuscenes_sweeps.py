"""nuScenes' format at more than 2 Hz, with the classes of points: sweeps, and what the devkit says."""

from __future__ import annotations

import json
import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import Agent, Scan, Semantic
from cadet.formats.nuscenes import VERSION
from cadet.formats.nuscenes.classes import CATEGORIES
from cadet.formats.nuscenes.lint import lint
from cadet.formats.nuscenes.point_categories import point_categories
from cadet.generate import Settings, generate

SCENES, SAMPLES, HZ = 2, 10, 6
Table = list[dict[str, Any]]


def small_settings(hz: int = HZ, **given: Any) -> Settings:
    """One small camera ahead, and nuScenes' LIDAR."""
    rig = cadet.Rig.nuscenes()
    rig = replace(rig, camera=rig.camera.resized(400, 225), more=())
    policy = cadet.ResetPolicy.kitti().with_rig(rig).as_sequence(hz=hz, length_s=SAMPLES / hz)
    return Settings(policy=policy, format="nuscenes", **given)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("sweeps") / "out"
    generate(out, small_settings(seed=3, num_frames=SCENES * SAMPLES, write=("lidarseg",)), workers=1)
    return out


def table(root: Path, name: str) -> Table:
    rows: Table = json.loads((root / VERSION / f"{name}.json").read_text())
    return rows


def test_every_third_of_six_samples_a_second_is_a_key_frame(root: Path) -> None:
    samples, data = table(root, "sample"), table(root, "sample_data")
    keys = [number for number in range(SCENES * SAMPLES) if number % SAMPLES % 3 == 0]
    assert len(samples) == len(keys) == SCENES * 4
    assert np.diff([row["timestamp"] for row in samples[:4]]).tolist() == [500_000] * 3
    assert len(data) == 2 * SCENES * SAMPLES
    times = {row["token"]: row["timestamp"] for row in samples}
    last = {samples[3]["token"], samples[-1]["token"]}
    for row in data:
        folder, _, name = row["filename"].split("/")
        number = int(name[:6])
        assert row["is_key_frame"] is (number in keys) and folder == ("samples" if number in keys else "sweeps")
        assert (root / row["filename"]).is_file()
        # By nuScenes' schema a sweep is the sample's that follows it; none follows those at the end.
        late_us = times[row["sample_token"]] - row["timestamp"]
        assert late_us == 0 if number in keys else 0 < late_us < 500_000 or row["sample_token"] in last
    for channel in ("CAM_FRONT", "LIDAR_TOP"):
        chain = [row for row in data if f"/{channel}/" in row["filename"]]
        assert [row["next"] for row in chain] == [
            "" if (at + 1) % SAMPLES == 0 else chain[at + 1]["token"] for at in range(SCENES * SAMPLES)
        ]
    assert {row["sample_token"] for row in table(root, "sample_annotation")} == set(times)
    assert [scene["nbr_samples"] for scene in table(root, "scene")] == [4, 4]


@pytest.mark.parametrize(("hz", "every"), [(1, 1), (2, 1), (4, 2), (20, 10), (60, 30)])
def test_key_frames_come_at_two_hertz(hz: int, every: int) -> None:
    settings = small_settings(hz)
    folders = [settings.exporter.path(settings.place(number), "LIDAR_TOP.pcd.bin")[:6] for number in range(SAMPLES)]
    assert folders == ["sample" if number % every == 0 else "sweeps" for number in range(SAMPLES)]


def test_rates_without_samples_at_half_seconds_are_refused() -> None:
    with pytest.raises(cadet.CadetError, match=r"^nuscenes: expected --hz up to 2, or 4, .*, got 15$"):
        small_settings(15)


def test_points_in_a_box_have_its_category_and_the_road_lies_under_the_wheels(root: Path) -> None:
    by_token = {name: {row["token"]: row for row in table(root, name)} for name in ("sample_data", "ego_pose")}
    by_token |= {name: {row["token"]: row for row in table(root, name)} for name in ("calibrated_sensor", "instance")}
    index_of = {row["token"]: row["index"] for row in table(root, "category")}
    labels = table(root, "lidarseg")
    assert len(labels) == SCENES * SAMPLES
    found, roads_m = Counter[bool](), []
    for row in labels:
        data = by_token["sample_data"][row["sample_data_token"]]
        points = np.fromfile(root / data["filename"], np.float32).reshape(-1, 5)
        classes = np.fromfile(root / row["filename"], np.uint8)
        assert row["filename"] == f"lidarseg/{VERSION}/{data['token']}_lidarseg.bin" and len(classes) == len(points)
        world_from_ego = matrix(by_token["ego_pose"][data["ego_pose_token"]])
        calibrated = by_token["calibrated_sensor"][data["calibrated_sensor_token"]]
        ego = np.c_[points[:, :3], np.ones(len(points))] @ matrix(calibrated).T
        is_near = np.linalg.norm(ego[:, :2], axis=1) < 6.0
        roads_m.append(ego[is_near & (classes == list(CATEGORIES).index("flat.driveable_surface")), 2])
        if not data["is_key_frame"]:
            continue
        world = ego @ world_from_ego.T
        for box in table(root, "sample_annotation"):
            if box["sample_token"] == data["sample_token"]:
                width, length, height = box["size"]
                local = np.abs((world @ np.linalg.inv(matrix(box)).T)[:, :3])
                is_inside = (local <= np.array([length, width, height]) / 2 - 0.1).all(axis=1)
                index = index_of[by_token["instance"][box["instance_token"]]["category_token"]]
                found.update((classes[is_inside] == index).tolist())
    assert found[True] > 1000 and found[False] < 0.01 * found[True]
    road_m = np.concatenate(roads_m)
    assert len(road_m) > 2000 and np.abs(road_m).max() < 0.3


def matrix(row: dict[str, Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    x, y, z = row["translation"]
    w, i, j, k = row["rotation"]
    return cadet.Pose(position_m=(x, y, z), quaternion_wxyz=(w, i, j, k)).matrix()


def test_things_that_people_have_along_are_no_people() -> None:
    models = {2: "child with dog/3", 3: "woman with rollator/1", 4: "man with pram/9", 5: "man/2"}
    agents = [
        Agent(number, "Pedestrian", m, (0.5, 0.5, 1.7), np.eye(4), (0, 0, 0), None) for number, m in models.items()
    ]
    seen = [(number, kind) for number in models for kind in (Semantic.PERSON, Semantic.FURNITURE)][:-1]
    seen += [(0, Semantic.FURNITURE), (0, Semantic.SKY), (0, Semantic.ROAD_MARKING), (0, Semantic.OTHER_VEHICLE)]
    zeros = np.zeros(len(seen), np.int32)
    scan = Scan(
        points_velo=np.zeros((len(seen), 4), np.float32),
        ring=zeros,
        column=zeros,
        actor_id=np.array([number for number, _ in seen], np.int32),
        semantic=np.array([kind for _, kind in seen], np.uint8),
        range_m=zeros.astype(np.float64),
        time_s=zeros.astype(np.float32),
        echo=zeros.astype(np.uint8),
    )
    names = [list(CATEGORIES)[index] for index in point_categories(scan, agents)]
    person = "human.pedestrian."
    assert names[:4] == [f"{person}child", "animal", f"{person}adult", "movable_object.pushable_pullable"]
    assert names[4:7] == [f"{person}stroller", f"{person}stroller", f"{person}adult"]
    assert names[7:] == ["static.manmade", "noise", "flat.driveable_surface", "vehicle.bicycle"]


def test_the_lint_finds_classes_that_are_not_those_of_a_scan(root: Path, tmp_path: Path) -> None:
    assert lint(root) == (SCENES * 4, [])
    for name in ("samples", "sweeps", VERSION, "maps"):
        (tmp_path / name).symlink_to(root / name)
    (tmp_path / "lidarseg" / VERSION).mkdir(parents=True)
    files = [row["filename"] for row in table(root, "lidarseg")]
    for file in files[2:]:
        (tmp_path / file).symlink_to(root / file)
    (tmp_path / files[1]).write_bytes((root / files[1]).read_bytes()[:-1])
    found = sorted((finding.rule, finding.file) for finding in lint(tmp_path)[1])
    assert found == [("damaged-file", files[1]), ("missing-file", files[0])]


def test_a_set_that_was_cut_short_goes_on_to_the_same_bytes(root: Path, tmp_path: Path) -> None:
    settings = small_settings(seed=3, num_frames=SCENES * SAMPLES, write=("lidarseg",))
    generate(tmp_path / "out", replace(settings, num_frames=2), workers=1)
    labels = next((tmp_path / "out" / "lidarseg" / VERSION).iterdir())
    labels.write_bytes(b"")
    generate(tmp_path / "out", settings, workers=2, resume=True)
    names = sorted(str(path.relative_to(root)) for path in root.rglob("*") if path.is_file())
    assert names == sorted(str(p.relative_to(tmp_path / "out")) for p in (tmp_path / "out").rglob("*") if p.is_file())
    assert all((tmp_path / "out" / name).read_bytes() == (root / name).read_bytes() for name in names)


def test_the_devkit_gives_the_truth_full_marks_and_joins_sweeps(root: Path, tmp_path: Path) -> None:
    pytest.importorskip("nuscenes", reason="needs nuscenes-devkit")
    with warnings.catch_warnings():
        # The devkit's own.
        warnings.simplefilter("ignore")
        from nuscenes.eval.common.config import config_factory
        from nuscenes.eval.detection.evaluate import DetectionEval
        from nuscenes.eval.detection.utils import category_to_detection_name
        from nuscenes.eval.lidarseg.utils import LidarsegClassMapper
        from nuscenes.nuscenes import NuScenes
        from nuscenes.utils.color_map import get_colormap
        from nuscenes.utils.data_classes import LidarPointCloud
        from nuscenes.utils.splits import create_splits_scenes

        nusc = NuScenes(version=VERSION, dataroot=str(root), verbose=False)
        # The devkit's colors stand in the order of the indices.
        assert list(CATEGORIES) == list(get_colormap())
        assert set(LidarsegClassMapper(nusc).fine_idx_2_coarse_idx_mapping) == set(range(32))
        names = create_splits_scenes()["val"]
        results: dict[str, list[dict[str, Any]]] = {}
        for sample in nusc.sample:
            if nusc.get("scene", sample["scene_token"])["name"] in names:
                boxes = [nusc.get("sample_annotation", name) for name in sample["anns"]]
                results[sample["token"]] = [
                    {
                        "sample_token": sample["token"],
                        "translation": box["translation"],
                        "size": box["size"],
                        "rotation": box["rotation"],
                        "velocity": nusc.box_velocity(box["token"])[:2].tolist(),
                        "detection_name": category_to_detection_name(box["category_name"]),
                        "detection_score": 1.0,
                        "attribute_name": nusc.get("attribute", box["attribute_tokens"][0])["name"],
                    }
                    for box in boxes
                    if category_to_detection_name(box["category_name"]) is not None
                ]
        assert len(results) == 4
        meta = {f"use_{name}": False for name in ("camera", "lidar", "radar", "map", "external")}
        (tmp_path / "results.json").write_text(json.dumps({"meta": meta, "results": results}))
        config = config_factory("detection_cvpr_2019")
        judge = DetectionEval(
            nusc, config, str(tmp_path / "results.json"), "val", str(tmp_path / "judged"), verbose=False
        )
        metrics, _ = judge.evaluate()
        there = {box.detection_name for box in judge.gt_boxes.all}
        assert {"car", "pedestrian"} <= there
        of_class = {name: metrics.mean_dist_aps[name] for name in there}
        assert of_class == dict.fromkeys(there, pytest.approx(1.0))
        errors = [metrics.get_label_tp(name, "trans_err") for name in there]
        assert errors == pytest.approx([0.0] * len(there), abs=1e-9)

        # Sweeps brought into one frame cover each other: what stands stays where it is.
        sample = nusc.sample[2]
        one, _ = LidarPointCloud.from_file_multisweep(nusc, sample, "LIDAR_TOP", "LIDAR_TOP", nsweeps=1)
        some, times = LidarPointCloud.from_file_multisweep(nusc, sample, "LIDAR_TOP", "LIDAR_TOP", nsweeps=4)
        assert np.unique(np.round(times, 3)).tolist() == pytest.approx([0.0, 0.167, 0.333, 0.5], abs=2e-3)
        assert some.points.shape[1] > 3.5 * one.points.shape[1]
        stands = np.abs(some.points[:2]).max(axis=0) < 15.0
        height_m = [some.points[2, stands & (np.abs(times[0] - late) < 1e-2)] for late in (0.0, 0.333)]
        assert abs(np.percentile(height_m[0], 30) - np.percentile(height_m[1], 30)) < 0.05
