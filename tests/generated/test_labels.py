"""Labels against the pixels, the points and parry's rays of the same instant."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet.boxes import corners_cam, points_in_boxes
from cadet.kitti.dataset import encode_frame
from sensed import Sensed, objects_of, sense

ROAD = (cadet.Semantic.ROAD, cadet.Semantic.ROAD_MARKING)


def labelled(sensed: Sensed) -> list[tuple[cadet.Label, dict[str, Any]]]:
    pairs = zip(sensed.frame.labels, objects_of(sensed.frame), strict=True)
    return [(label, meta) for label, meta in pairs if label.type != "DontCare"]


def box_cam(label: cadet.Label) -> NDArray[np.float64]:
    h, w, l = label.dimensions_hwl
    return np.array([[*label.location_cam, l, w, h, label.rotation_y]])


def test_there_is_something_to_look_at(street_frames: list[Sensed]) -> None:
    types = [label.type for s in street_frames for label, _ in labelled(s)]
    assert types.count("Car") > 60
    assert types.count("Pedestrian") > 5
    levels = {label.occluded for s in street_frames for label, _ in labelled(s)}
    assert levels == {0, 1, 2}


def test_boxes_contain_their_points(street_frames: list[Sensed]) -> None:
    inside = total = 0
    for sensed in street_frames:
        cam_from_velo = sensed.frame.calib.cam_from_velo
        points = sensed.scan.points_velo[:, :3].astype(float) @ cam_from_velo[:3, :3].T + cam_from_velo[:3, 3]
        for label, meta in labelled(sensed):
            own = points[sensed.scan.actor_id == meta["actor_id"]]
            assert len(own) == meta["num_points"]
            if len(own) >= 20:
                kept = points_in_boxes(own, box_cam(label), 0.05).sum()
                inside, total = inside + kept, total + len(own)
                assert kept >= 0.9 * len(own), (meta["model"], kept, len(own))
    assert total > 5000
    assert inside >= 0.98 * total


def test_bbox_contains_the_silhouette_and_the_visible_pixels(street_frames: list[Sensed]) -> None:
    for sensed in street_frames:
        for label, meta in labelled(sensed):
            rows, columns = np.nonzero(sensed.frame.instance == meta["actor_id"])
            assert len(rows) > 0, "a label needs visible pixels"
            u1, v1, u2, v2 = label.bbox
            # Mirrors stick out of KITTI's boxes, and a box has no pitch or roll.
            slack_u, slack_v = 2 + 0.08 * (u2 - u1), 2 + 0.06 * (v2 - v1)
            s1, t1, s2, t2 = meta["silhouette_bbox"]
            assert s1 >= u1 - slack_u and s2 <= u2 + slack_u, (meta["model"], label.bbox, meta["silhouette_bbox"])
            assert t1 >= v1 - slack_v and t2 <= v2 + slack_v, (meta["model"], label.bbox, meta["silhouette_bbox"])
            inside = (columns >= u1 - 1) & (columns <= u2 + 1) & (rows >= v1 - 1) & (rows <= v2 + 1)
            assert inside.mean() > 0.93


def test_boxes_fit_their_silhouettes(street_frames: list[Sensed]) -> None:
    overlaps = []
    for sensed in street_frames:
        for label, meta in labelled(sensed):
            if label.truncated > 0 or label.type != "Car":
                continue
            a, b = np.array(label.bbox), np.array(meta["silhouette_bbox"])
            lo, hi = np.maximum(a[:2], b[:2]), np.minimum(a[2:], b[2:])
            both = np.prod(np.maximum(hi - lo, 0))
            overlaps.append(both / (np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2]) - both))
    assert len(overlaps) > 30
    assert np.median(overlaps) > 0.8


def test_no_label_through_walls() -> None:
    """Parry, which knows nothing of the kernel, must meet the labelled actor first along its pixels' rays."""
    scene = cadet.Scene.random(seed=3, weather="clear_noon")
    sensed = sense(scene)
    p2 = sensed.frame.calib.P2
    center_cam = -np.linalg.solve(p2[:, :3], p2[:, 3])
    world_from_cam = np.linalg.inv(sensed.cam_from_world)
    origin = world_from_cam[:3, :3] @ center_cam + world_from_cam[:3, 3]
    checked = 0
    for _, meta in labelled(sensed):
        rows, columns = np.nonzero(sensed.frame.instance == meta["actor_id"])
        pixels = np.stack([columns, rows, np.ones(len(rows))], axis=1).astype(float)
        directions = pixels @ np.linalg.inv(p2[:, :3]).T @ world_from_cam[:3, :3].T
        _, actor_id, _ = scene.cast_rays(np.repeat(origin[None], len(pixels), axis=0), directions)
        assert (actor_id == meta["actor_id"]).mean() > 0.995
        checked += 1
    assert checked >= 1


def test_a_car_behind_a_van_is_occluded_and_one_behind_a_wall_is_not_there() -> None:
    scene = cadet.Scene.empty(weather="clear_noon")
    scene.move_ego(x=0.0, y=0.0, yaw=0.0)
    near = scene.add("car", x=12.0, y=0.0, yaw=np.pi / 2, model_seed=1)
    far = scene.add("car", x=22.0, y=0.9, yaw=np.pi / 2, model_seed=2)
    objects = {o["actor_id"]: o for o in objects_of(scene.capture())}
    assert objects[near]["visible_fraction"] > 0.999
    assert far not in objects or objects[far]["visible_fraction"] < 0.6


@pytest.mark.parametrize("yaw", [0.0, 0.5, np.pi / 2, 2.5, -1.2, np.pi])
def test_a_lone_car_is_labelled_where_it_was_put(yaw: float) -> None:
    scene = cadet.Scene.empty(weather="clear_noon")
    scene.move_ego(x=0.0, y=0.0, yaw=0.0)
    scene.add("car", x=15.0, y=2.0, yaw=yaw, model_seed=4)
    poses = scene.sensor_poses()
    frame = scene.capture()
    (label,) = frame.labels
    assert (label.type, label.occluded, label.truncated) == ("Car", 0, 0.0)
    corners = corners_cam(box_cam(label))[0]
    world = corners @ poses["world_from_cam"][:3, :3].T + poses["world_from_cam"][:3, 3]
    assert np.allclose(world[:, :2].mean(axis=0), [15.0, 2.0], atol=0.02)
    heading = world[0, :2] + world[1, :2] - world[2, :2] - world[3, :2]
    assert np.cos(np.arctan2(heading[1], heading[0]) - yaw) > 0.9999
    assert abs(world[:4, 2].mean()) < 0.03, "it stands on the ground"


def test_planes_lie_on_the_road(street_frames: list[Sensed]) -> None:
    checked = 0
    for sensed in street_frames:
        frame = sensed.frame
        assert frame.depth is not None and frame.semantic is not None and frame.plane is not None
        assert np.linalg.norm(frame.plane[:3]) == pytest.approx(1) and frame.plane[1] < 0
        road = np.isin(frame.semantic, ROAD) & np.isfinite(frame.depth)
        rows, columns = np.nonzero(road)
        depth = frame.depth[rows, columns].astype(float)
        p2 = frame.calib.P2
        pixels = np.stack([columns, rows, np.ones(len(rows))], axis=1) * depth[:, None]
        points = (pixels - p2[:, 3]) @ np.linalg.inv(p2[:, :3]).T
        ahead = (points[:, 2] > 2) & (points[:, 2] < 20) & (np.abs(points[:, 0]) < 3)
        if ahead.sum() > 500:
            distance = points[ahead] @ frame.plane[:3] + frame.plane[3]
            assert np.quantile(np.abs(distance), 0.98) < 0.05, np.quantile(np.abs(distance), 0.98)
            checked += 1
    assert checked > 20


def test_objects_stand_before_dontcare_in_the_file_and_in_the_meta() -> None:
    scene = cadet.Scene.empty()
    scene.move_ego(x=0, y=0, yaw=0)
    # Too far to be labelled (1 and 3), near enough (2 and 4).
    for kind, x, y in [("car", 84, 5), ("car", 16, -4), ("car", 85, -9), ("pedestrian", 13, 3)]:
        scene.add(kind, x=x, y=y, yaw=1.5)
    files = encode_frame(scene.capture())
    lines = [line.split() for line in files["label_2"].decode().splitlines()]
    objects = json.loads(files["meta"])["objects"]
    assert [line[0] for line in lines] == ["Car", "Pedestrian", "DontCare", "DontCare"]
    assert [o["actor_id"] for o in objects] == [2, 4, 1, 3]
    for line, o in zip(lines[:2], objects[:2], strict=True):
        assert [float(v) for v in line[11:14]] == pytest.approx(o["location_cam"], abs=0.006)
