"""Cyclists as labels, scans, and images see them, alone and in traffic."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import cadet
from cadet.formats.kitti.boxes import points_in_boxes


def scene_with(*cyclists: dict[str, Any], boxes: str = "exact") -> tuple[cadet.Scene, list[int]]:
    config = cadet.SceneConfig(label=cadet.LabelConfig(boxes=boxes))  # type: ignore[arg-type]
    scene = cadet.Scene.empty(config=config)
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    return scene, [scene.add("Cyclist", **place) for place in cyclists]


@pytest.mark.parametrize("speed", [None, 4.5])
@pytest.mark.parametrize("yaw", [0.0, 1.57, -2.4])
def test_a_cyclist_is_labeled_and_its_points_and_pixels_are_its_own(core: Any, yaw: float, speed: float | None) -> None:
    del core
    scene, (cyclist,) = scene_with({"x_m": 13.0, "y_m": 1.0, "yaw_rad": yaw, "speed_mps": speed, "model_seed": 3})
    scene.step(0.2)
    frame = scene.capture()
    (label,) = [label for label in frame.labels if label.type == "Cyclist"]
    height, width, length = label.dimensions_hwl
    assert 1.4 < height < 2.1 and 0.45 < width < 0.9 and 1.5 < length < 1.95
    assert frame.semantic is not None and frame.instance is not None
    of_it = frame.instance == cyclist
    assert set(np.unique(frame.semantic[of_it])) == {int(cadet.Semantic.CYCLIST)}
    rows, columns = np.nonzero(of_it)
    left, top, right, bottom = label.bbox
    assert left - 1 <= columns.min() and columns.max() <= right + 1
    assert top - 1 <= rows.min() and rows.max() <= bottom + 1
    scan = scene.scan(ideal=True)
    cam_from_velo = frame.calib.cam_from_velo
    points = (
        scan.points_velo[scan.actor_id == cyclist, :3].astype(float) @ cam_from_velo[:3, :3].T + cam_from_velo[:3, 3]
    )
    assert len(points) > 60
    box = np.array([[*label.location_cam, length, width, height, label.rotation_y]])
    # Who leans into a bend or turns the cranks leaves the box by a little at most.
    assert points_in_boxes(points, box, 0.03).mean() > 0.99


def test_a_scripted_cyclist_rides_and_stops(core: Any) -> None:
    del core
    scene, _ = scene_with()
    rider = scene.add("cyclist", path=[(0.0, 10.0, 2.0), (4.0, 26.0, 2.0), (6.0, 26.0, 2.0)])
    speeds = []
    for _ in range(3):
        meta = scene.capture().meta
        assert meta is not None
        (found,) = [o for o in meta["objects"] if o["actor_id"] == rider]
        speeds.append(float(np.linalg.norm(found["velocity_world"])))
        scene.step(2.2)
    assert speeds == pytest.approx([4.0, 4.0, 0.0], abs=1e-3)


def test_traffic_has_cyclists_if_they_are_asked_for(core: Any) -> None:
    del core

    def actors(num_cyclists: int) -> list[dict[str, Any]]:
        config = cadet.SceneConfig(num_cars=10, num_pedestrians=10, num_cyclists=num_cyclists)
        meta = cadet.Scene.random(seed=4, config=config).capture().meta
        assert meta is not None
        return [o for o in meta["objects"] if o["type"] != "DontCare"]

    assert not [o for o in actors(0) if o["type"] == "Cyclist"]
    assert [o for o in actors(12) if o["type"] == "Cyclist"]


def test_evaluation_finds_cyclists(core: Any) -> None:
    del core
    scene, _ = scene_with(
        {"x_m": 12.0, "y_m": 0.0, "yaw_rad": 0.3}, {"x_m": 20.0, "y_m": 3.0, "yaw_rad": 2.0, "model_seed": 9}
    )
    labels = [label for label in scene.capture().labels if label.type == "Cyclist"]
    assert len(labels) == 2
    found = [replace(label, score=0.9) for label in labels]
    # KITTI's recall counts from 40 objects on.
    report = cadet.evaluate([labels] * 40, [found] * 40)
    assert report.ap["Cyclist"]["3d"]["Moderate"] == pytest.approx(100.0, abs=0.1)
