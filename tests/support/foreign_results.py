"""Results of other programs, for tests: OpenPCDet's, and nuScenes' with the tables that they refer to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from synthetic import make_calib, make_labels


def openpcdet_frames() -> list[dict[str, Any]]:
    """Lay out a frame of three objects, and one of none, as OpenPCDet's `generate_prediction_dicts` does."""
    labels = make_labels(make_calib())[:3]
    lhw = np.array([[one.dimensions_hwl[2], one.dimensions_hwl[0], one.dimensions_hwl[1]] for one in labels], "f4")
    found: dict[str, Any] = {
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


HALF_TURN = [0.0, 0.0, 0.0, 1.0]
QUARTER_TURN = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]


def write_tables(folder: Path) -> Path:
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
        (folder / f"{name}.json").write_text(json.dumps(rows))
    return folder


def nuscenes_result(**changes: Any) -> dict[str, Any]:
    row = {"sample_token": "s", "translation": [100.0, 60.0, 2.8], "size": [1.8, 4.2, 1.6], "rotation": QUARTER_TURN}
    return {**row, "velocity": [0, 0], "detection_name": "car", "detection_score": 0.9, "attribute_name": ""} | changes


def write_results(folder: Path, *rows: dict[str, Any]) -> Path:
    path = folder / "results_nusc.json"
    path.write_text(json.dumps({"meta": {"use_lidar": True}, "results": {"s": list(rows)}}))
    return path
