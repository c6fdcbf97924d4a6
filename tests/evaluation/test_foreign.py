from __future__ import annotations

import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import CadetError, Detections
from cadet.errors import FileFormatError, MissingFileError
from synthetic import make_calib, make_labels

ALL = (cadet.Level("All", 0.0, inclusive=True),)


def openpcdet_frames() -> list[dict[str, Any]]:
    """Lay out a frame of three objects, and one of none, as OpenPCDet's `generate_prediction_dicts` does."""
    labels = make_labels(make_calib())[:3]
    lhw = np.array([[one.dimensions_hwl[2], one.dimensions_hwl[0], one.dimensions_hwl[1]] for one in labels], "f4")
    found = {
        "name": np.array([one.type for one in labels]),
        "truncated": np.zeros(3),
        "occluded": np.zeros(3),
        "alpha": np.array([one.alpha for one in labels], "f4"),
        "bbox": np.array([one.bbox for one in labels], "f4"),
        "dimensions": lhw,
        "location": np.array([one.location_cam for one in labels], "f4"),
        "rotation_y": np.array([one.rotation_y for one in labels], "f4"),
        "score": np.array([0.9, 0.5, 0.7], "f4"),
        "boxes_lidar": np.zeros((3, 7), "f4"),
        "frame_id": "000001",
    }
    empty = {key: value[:0] for key, value in found.items() if key != "frame_id"} | {"frame_id": np.str_("000002")}
    return [found, empty]


@pytest.mark.parametrize("protocol", [4, 5])
def test_openpcdets_pickle_is_its_text(tmp_path: Path, protocol: int) -> None:
    frames = openpcdet_frames()
    (tmp_path / "result.pkl").write_bytes(pickle.dumps(frames, protocol))
    found = cadet.read_detections(tmp_path / "result.pkl")
    assert list(found) == ["000001", "000002"] and len(found["000002"].types) == 0
    # What OpenPCDet writes beside it, by its own format.
    one, line = frames[0], "%s -1 -1 %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f\n"
    text = "".join(
        line
        % (
            one["name"][k],
            one["alpha"][k],
            *one["bbox"][k],
            *one["dimensions"][k][[1, 2, 0]],
            *one["location"][k],
            one["rotation_y"][k],
            one["score"][k],
        )
        for k in range(3)
    )
    expected = Detections.from_labels(cadet.kitti.labels_from_text(text))
    assert found["000001"].types == expected.types
    for name in ("boxes_img", "boxes_cam", "alphas", "scores"):
        np.testing.assert_allclose(getattr(found["000001"], name), getattr(expected, name), atol=1e-4)


def test_a_pickle_that_would_run_code_does_not(tmp_path: Path) -> None:
    class Evil:
        def __reduce__(self) -> Any:
            return os.mkdir, (str(tmp_path / "made"),)

    (tmp_path / "evil.pkl").write_bytes(pickle.dumps([Evil()]))
    with pytest.raises(FileFormatError, match=r"^evil\.pkl: no pickle of arrays: it names (posix|nt)\.mkdir"):
        cadet.read_detections(tmp_path / "evil.pkl")
    assert not (tmp_path / "made").exists()


HALF_TURN = [0.0, 0.0, 0.0, 1.0]
QUARTER_TURN = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]


@pytest.fixture
def tables(tmp_path: Path) -> Path:
    """Write tables of one sample: at (100, 50, 2), looking north, with a car ahead and a bus to the left."""
    ahead: dict[str, Any] = {
        "translation": [100.0, 60.0, 2.8],
        "size": [1.8, 4.2, 1.6],
        "rotation": QUARTER_TURN,
        "instance_token": "c",
    }
    left = {"translation": [95.0, 50.0, 3.5], "size": [2.5, 11.0, 3.0], "rotation": HALF_TURN, "instance_token": "b"}
    unseen = {**ahead, "translation": [100.0, 80.0, 2.8], "num_lidar_pts": 0}
    far = {**ahead, "translation": [100.0, 101.0, 2.8]}
    pram = {**left, "instance_token": "p"}
    annotations = [
        {"sample_token": "s", "num_lidar_pts": 5, "num_radar_pts": 0, **row} for row in (ahead, left, unseen, far, pram)
    ]
    data = {"sample_token": "s", "is_key_frame": True}
    for name, rows in {
        "sensor": [{"token": "L", "modality": "lidar"}, {"token": "C", "modality": "camera"}],
        "calibrated_sensor": [{"token": "l", "sensor_token": "L"}, {"token": "k", "sensor_token": "C"}],
        "ego_pose": [
            {"token": "at", "translation": [100.0, 50.0, 2.0], "rotation": QUARTER_TURN},
            {"token": "later", "translation": [0.0, 0.0, 0.0], "rotation": HALF_TURN},
        ],
        "sample_data": [
            {**data, "calibrated_sensor_token": "k", "ego_pose_token": "later"},
            {**data, "calibrated_sensor_token": "l", "ego_pose_token": "at"},
        ],
        "category": [
            {"token": "1", "name": "vehicle.car"},
            {"token": "2", "name": "vehicle.bus.rigid"},
            {"token": "3", "name": "human.pedestrian.stroller"},
        ],
        "instance": [
            {"token": "c", "category_token": "1"},
            {"token": "b", "category_token": "2"},
            {"token": "p", "category_token": "3"},
        ],
        "sample_annotation": annotations,
    }.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(rows))
    return tmp_path


def result(**changes: Any) -> dict[str, Any]:
    row = {"sample_token": "s", "translation": [100.0, 60.0, 2.8], "size": [1.8, 4.2, 1.6], "rotation": QUARTER_TURN}
    return {**row, "velocity": [0, 0], "detection_name": "car", "detection_score": 0.9, "attribute_name": ""} | changes


def written(folder: Path, *rows: dict[str, Any]) -> Path:
    path = folder / "results_nusc.json"
    path.write_text(json.dumps({"meta": {"use_lidar": True}, "results": {"s": list(rows)}}))
    return path


def test_nuscenes_tables_become_boxes_about_the_car(tables: Path) -> None:
    (truth,) = cadet.read_ground_truth(tables).values()
    assert truth.types == ("car", "bus", "car"), "no returns and no class of the task leave an object out"
    # x right, y down, z forward from the ego's origin; the first looks ahead, the second, westward, to the left.
    np.testing.assert_allclose(truth.boxes_cam[0], [0, 0, 10, 4.2, 1.8, 1.6, -np.pi / 2], atol=1e-9)
    np.testing.assert_allclose(truth.boxes_cam[1], [-5, 0, 0, 11, 2.5, 3.0, -np.pi], atol=1e-9)


@pytest.mark.parametrize(("off_m", "limits"), [(0.0, 4), (0.8, 3), (1.5, 2), (3.0, 1), (5.0, 0)])
def test_nuscenes_results_are_scored_by_its_own_rules(tables: Path, off_m: float, limits: int) -> None:
    path = written(tables, result(translation=[100.0 + off_m, 60.0, 2.8]))
    found, truth = cadet.read_detections(path, tables), cadet.read_ground_truth(tables)
    result_of = cadet.analyze(truth, found, classes=["Car"], levels=ALL, parts=["centers"])
    assert result_of.centers is not None
    score = result_of.centers["Car"]
    assert score.n_gt == 1, "beyond 50 m nothing counts"
    assert [ap > 99.0 for ap in score.ap.values()] == [False] * (4 - limits) + [True] * limits
    if off_m == 0.0:
        assert (score.ate_m, score.ase, score.aoe_rad) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[]", r"not laid out as a detector's results are \(TypeError: "),
        ('{"s": []}', r"not laid out as a detector's results are \(KeyError: 'results'\)"),
        ('{"results": {"other": []}}', "sample 'other': the tables have no such sample"),
        ('{"results": {"s": [{"translation": [1, 2]}]}}', "not laid out as"),
        ("{", "no JSON"),
    ],
)
def test_what_is_no_nuscenes_result_is_refused_in_one_line(tables: Path, content: str, message: str) -> None:
    path = tables / "results_nusc.json"
    path.write_text(content)
    with pytest.raises(FileFormatError, match=rf"^results_nusc\.json.*{message}") as caught:
        cadet.read_detections(path, tables)
    assert "\n" not in str(caught.value)


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    (tmp_path / "r.json").write_text("{}")
    with pytest.raises(CadetError, match=r"r\.json: nuScenes' results need tables="):
        cadet.read_detections(tmp_path / "r.json")
    with pytest.raises(CadetError, match=r"expected OpenPCDet's \.pkl or nuScenes' \.json"):
        cadet.read_detections(tmp_path)
    with pytest.raises(MissingFileError, match=r"none\.pkl: no such file"):
        cadet.read_detections(tmp_path / "none.pkl")
    with pytest.raises(MissingFileError, match=r"sensor\.json: no such file"):
        cadet.read_ground_truth(tmp_path)
    (tmp_path / "bad.pkl").write_bytes(pickle.dumps([{"name": np.array(["Car"])}]))
    with pytest.raises(FileFormatError, match=r"^bad\.pkl: not laid out as a detector's results are \(KeyError"):
        cadet.read_detections(tmp_path / "bad.pkl")
