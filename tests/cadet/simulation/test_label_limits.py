"""What keeps an object from being labeled: fog, the image's edge, nearness, too few returns."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cadet
from cadet.sensors.sample import Wanted
from cadet.simulation.episode import request
from cadet.worlds.weather import air_of
from mesh_files.obj_meshes import WALL, assets_folder
from scans.sensed import objects_of

PLACES = [(11.0, -5.8), (19.0, 7.7), (29.0, -6.2), (41.0, 8.7), (56.0, -5.4), (73.0, 6.4)]
"""Of cars that do not hide each other, meters ahead and to the left."""

Found = dict[int, tuple[cadet.Label, dict[str, Any]]]


def exact(**limits: Any) -> cadet.SceneConfig:
    return cadet.SceneConfig(label=cadet.LabelConfig(boxes="exact", **limits))


def found_in(frame: cadet.Frame) -> Found:
    """Return labels and what the generator knows of them by actor."""
    pairs = zip(frame.labels, objects_of(frame), strict=True)
    return {meta["actor_id"]: (label, meta) for label, meta in pairs}


def cars_ahead(weather: str, config: cadet.SceneConfig) -> Found:
    scene = cadet.Scene.empty(weather=weather, config=config)
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    for seed, (x, y) in enumerate(PLACES):
        scene.add("car", x_m=x, y_m=y, yaw_rad=1.5, model_seed=seed)
    return found_in(scene.capture())


def is_labeled(found: Found) -> dict[int, bool]:
    return {actor_id: label.type != "DontCare" for actor_id, (label, _) in found.items()}


def test_fog_takes_of_what_is_visible_what_it_takes_of_the_contrast() -> None:
    clear, foggy = (cars_ahead(weather, exact()) for weather in ("clear_noon", "dense_fog"))
    assert len(clear) == len(PLACES) and all(is_labeled(clear).values())
    assert set(foggy) == set(clear), "what fog hides from the labels is not to be counted against a detector"
    extinction_per_m = air_of("dense_fog").fog
    for actor_id, (label, meta) in foggy.items():
        _, of_clear = clear[actor_id]
        assert (of_clear["contrast"], of_clear["visible_fraction"]) == (1.0, 1.0)
        middle_cam = np.array(meta["location_cam"]) - [0.0, meta["dimensions_hwl"][0] / 2, 0.0]
        expected = np.exp(-extinction_per_m * np.linalg.norm(middle_cam))
        assert meta["contrast"] == pytest.approx(expected, abs=0.002)
        assert meta["visible_fraction"] == pytest.approx(expected, abs=0.002)
        if expected < 0.098:
            assert label.type == "DontCare"
        elif expected > 0.102:
            assert (label.type, label.occluded) == ("Car", 0 if expected > 0.8 else 1 if expected > 0.5 else 2)
    assert {label.type for label, _ in foggy.values()} == {"Car", "DontCare"}


def test_what_neither_sensor_shows_has_no_label() -> None:
    found = cars_ahead("dense_fog", exact(min_visible_fraction=0.0))
    labeled = is_labeled(found)
    for actor_id, (_, meta) in found.items():
        assert labeled[actor_id] == (meta["num_points"] > 0 or meta["contrast"] >= 0.05), meta
    lost = [meta for actor_id, (_, meta) in found.items() if not labeled[actor_id]]
    assert lost and all(meta["num_points"] == 0 and meta["contrast"] < 0.05 for meta in lost)
    everything = cars_ahead("dense_fog", exact(min_visible_fraction=0.0, min_contrast=0.0))
    assert all(is_labeled(everything).values()) and len(everything) == len(PLACES)


def test_streets_in_fog_have_labels_where_a_sensor_shows_an_object() -> None:
    num_labels = 0
    for seed in range(3):
        for label, meta in found_in(cadet.Scene.random(seed=seed, weather="dense_fog").capture()).values():
            if label.type != "DontCare":
                # Annotators drew boxes round returns.
                assert meta["num_points"] >= 2 and meta["visible_fraction"] >= 0.1
                num_labels += 1
    assert num_labels >= 3


def small_rig() -> cadet.Rig:
    rig = cadet.Rig.kitti()
    return replace(rig, camera=rig.camera.resized(310, 94))


def test_what_is_all_but_outside_the_image_becomes_dontcare() -> None:
    small: dict[str, Any] = {"min_height_px": 3.75, "dontcare_min_pixels": 0.0, "min_visible_fraction": 0.0}
    scenes = []
    for limits in ({"max_truncation": 1.0}, {}):
        scene = cadet.Scene.empty(weather="clear_noon", rig=small_rig(), config=exact(**small, **limits))
        scene.add("car", x_m=9.0, y_m=6.0, yaw_rad=0.0, model_seed=1)
        scenes.append(scene)
    outcomes = set()
    for yaw in np.arange(0.0, -0.45, -0.03):
        whole: list[cadet.Label] = []
        cut: list[cadet.Label] = []
        for scene, into in zip(scenes, (whole, cut), strict=True):
            scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=float(yaw))
            into.extend(scene.capture().labels)
        assert len(whole) == len(cut)
        for label, limited in zip(whole, cut, strict=True):
            assert label.type == "Car" and label.bbox == limited.bbox
            assert limited.type == ("DontCare" if label.truncated > 0.95 else "Car"), label.truncated
            outcomes.add((limited.type, label.truncated > 0.7))
    assert outcomes == {("Car", False), ("Car", True), ("DontCare", True)}


def test_what_is_not_half_a_meter_ahead_becomes_dontcare(tmp_path: Path) -> None:
    """A wall along the way whose middle lies beside the camera."""
    own = assets_folder(tmp_path / "own", WALL)
    for min_depth_m, offset_m, expected in [(0.5, 0.3, "DontCare"), (0.0, 0.3, "Truck"), (0.5, 0.8, "Truck")]:
        config = exact(min_depth_m=min_depth_m, max_truncation=1.0)
        scene = cadet.Scene.empty(weather="clear_noon", assets=own, config=config)
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        camera_x_m = float(scene.sensor_poses()["world_from_cam"][0, 3])
        scene.add("truck", x_m=camera_x_m + offset_m, y_m=3.0, yaw_rad=0.0, model="wall")
        frame = scene.capture()
        ((label, meta),) = found_in(frame).values()
        assert meta["location_cam"][2] == pytest.approx(offset_m, abs=0.15)
        assert label.type == expected, (min_depth_m, offset_m)


def test_what_has_too_few_returns_becomes_dontcare() -> None:
    plain = cars_ahead("clear_noon", exact())
    counts = {actor_id: meta["num_points"] for actor_id, (_, meta) in plain.items()}
    least = min(counts.values())
    assert 0 < least < max(counts.values())
    for min_points in (least, least + 1):
        found = cars_ahead("clear_noon", exact(min_points=min_points))
        assert is_labeled(found) == {actor_id: count >= min_points for actor_id, count in counts.items()}


def test_an_object_that_the_scan_takes_away_makes_no_new_view() -> None:
    scene = cadet.Scene.empty(config=exact(min_points=60))
    near = scene.add("car", x_m=12.0, y_m=4.0)
    far = scene.add("pedestrian", x_m=45.0, y_m=-12.0, yaw_rad=1.57, speed_mps=1.5)
    native: Any = scene._native

    def labeled() -> list[int] | None:
        """Return who is labeled in a view that is new."""
        captured = native.capture_labeled(request(cadet.Rig(), 0, Wanted()))
        return captured and [sighting.actor_id for sighting in captured.sightings(0) if sighting.is_labeled]

    assert labeled() == [near]
    scene.step(3.0)
    (seen,) = [agent for agent in scene.agents if agent.id == far]
    assert seen.velocity_world[1] > 1.0
    assert labeled() is None
