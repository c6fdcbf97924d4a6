"""Labels against the pixels, the points and parry's rays of the same instant."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet.formats.kitti.boxes import corners_cam, points_in_boxes
from cadet.formats.kitti.dataset import encode_frame
from mesh_files.obj_meshes import WALL, assets_folder
from scans.sensed import Sensed, objects_of, sense

ROAD = (cadet.Semantic.ROAD, cadet.Semantic.ROAD_MARKING)


def labeled(sensed: Sensed) -> list[tuple[cadet.Label, dict[str, Any]]]:
    pairs = zip(sensed.frame.labels, objects_of(sensed.frame), strict=True)
    return [(label, meta) for label, meta in pairs if label.type != "DontCare"]


def is_alone(meta: dict[str, Any]) -> bool:
    """Whether nothing reaches beyond the box that is carried, pushed, led, or stands open."""
    return " with " not in meta["model"]


def box_cam(label: cadet.Label) -> NDArray[np.float64]:
    h, w, l = label.dimensions_hwl
    return np.array([[*label.location_cam, l, w, h, label.rotation_y]])


def test_there_is_something_to_look_at(street_frames: list[Sensed]) -> None:
    types = [label.type for s in street_frames for label, _ in labeled(s)]
    assert types.count("Car") > 60
    assert types.count("Pedestrian") > 5
    levels = {label.occluded for s in street_frames for label, _ in labeled(s)}
    assert levels == {0, 1, 2}


def test_boxes_contain_their_points(street_frames: list[Sensed]) -> None:
    inside = total = 0
    for sensed in street_frames:
        cam_from_velo = sensed.frame.calib.cam_from_velo
        points = sensed.scan.points_velo[:, :3].astype(float) @ cam_from_velo[:3, :3].T + cam_from_velo[:3, 3]
        for label, meta in labeled(sensed):
            own = points[sensed.scan.actor_id == meta["actor_id"]]
            assert len(own) == meta["num_points"]
            if len(own) >= 20 and is_alone(meta):
                kept = points_in_boxes(own, box_cam(label), 0.05).sum()
                inside, total = inside + kept, total + len(own)
                assert kept >= 0.9 * len(own), (meta["model"], kept, len(own))
    assert total > 5000
    assert inside >= 0.98 * total


def car_margins(boxes: Literal["kitti", "exact"]) -> NDArray[np.float64]:
    """Return how far points reach beyond the near end, the near side and the roof of lone cars, one row a car."""
    rows = []
    for seed in range(24):
        config = cadet.SceneConfig(label=cadet.LabelConfig(boxes=boxes))
        scene = cadet.Scene.empty(weather="clear_noon", config=config)
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        scene.add("car", x_m=11.0, y_m=3.5, yaw_rad=0.0 if seed % 2 else np.pi, model_seed=seed)
        frame = scene.capture()
        (label,) = frame.labels
        assert frame.meta is not None and frame.meta["boxes"] == boxes
        cam_from_velo = frame.calib.cam_from_velo
        points = frame.points_velo[:, :3].astype(float) @ cam_from_velo[:3, :3].T + cam_from_velo[:3, 3]
        height, width, length = label.dimensions_hwl
        d, c, s = points - label.location_cam, np.cos(label.rotation_y), np.sin(label.rotation_y)
        along, across, up = c * d[:, 0] - s * d[:, 2], s * d[:, 0] + c * d[:, 2], -d[:, 1]
        near = (abs(along) < length / 2 + 0.45) & (abs(across) < width / 2 + 0.35) & (up > 0.3) & (up < height + 0.4)
        x, _, z = label.location_cam
        end, side = np.sign(s * z - c * x), np.sign(-s * x - c * z)
        low = near & (up < 1.1)
        rows.append(
            [
                np.percentile(along[near] * end, 99) - length / 2,
                np.percentile(across[low] * side, 98) - width / 2,
                np.percentile(up[near], 99.5) - height,
            ]
        )
    return np.array(rows)


def test_kittis_boxes_begin_before_the_near_end() -> None:
    # The outermost returns stand out of the body's ends by the lasers' range errors.
    exact, kitti = car_margins("exact"), car_margins("kitti")
    assert np.median(exact, axis=0) == pytest.approx([0.03, -0.005, -0.02], abs=0.025)
    assert exact[:, 0].std() < 0.03
    # By 0.035 m where the rear is near, by 0.06 where the front is.
    assert np.median(kitti - exact, axis=0) == pytest.approx([-0.05, 0.0, 0.0], abs=0.04)
    # 16 to 84 % of KITTI's: 0.15 m at the end, 0.08 m at the side.
    spread = np.percentile(kitti, 84, axis=0) - np.percentile(kitti, 16, axis=0)
    assert 0.07 < spread[0] < 0.22
    assert 0.04 < spread[1] < 0.13


def test_an_actor_keeps_its_box_through_an_episode() -> None:
    scene = cadet.Scene.random(seed=5, weather="clear_noon")
    sizes: dict[int, set[tuple[float, ...]]] = {}
    for _ in range(3):
        for o in objects_of(scene.capture()):
            sizes.setdefault(o["actor_id"], set()).add(tuple(o["dimensions_hwl"]))
        scene.step(1.0)
    assert all(len(s) == 1 for s in sizes.values())
    assert len(set().union(*sizes.values())) == len(sizes), "every actor is of a size of its own"


def test_bbox_contains_the_silhouette_and_the_visible_pixels(street_frames: list[Sensed]) -> None:
    for sensed in street_frames:
        for label, meta in filter(lambda pair: is_alone(pair[1]), labeled(sensed)):
            rows, columns = np.nonzero(sensed.frame.instance == meta["actor_id"])
            assert len(rows) > 0, "a label needs visible pixels"
            u1, v1, u2, v2 = label.bbox
            # Mirrors stick out of KITTI's boxes, and a box has no pitch or roll.
            slack_u, slack_v = 2 + 0.08 * (u2 - u1), 2 + 0.06 * (v2 - v1)
            s1, t1, s2, t2 = meta["silhouette_bbox"]
            assert s1 >= u1 - slack_u and s2 <= u2 + slack_u, (meta["model"], label.bbox, meta["silhouette_bbox"])
            # KITTI's boxes of trams end at the roof; the pantograph reaches the wire.
            has_pantograph = label.type == "Tram"
            is_below = t1 >= v1 - slack_v or has_pantograph
            assert is_below and t2 <= v2 + slack_v, (meta["model"], label.bbox, meta["silhouette_bbox"])
            inside = (columns >= u1 - 1) & (columns <= u2 + 1) & (rows >= v1 - 1) & (rows <= v2 + 1)
            inside |= has_pantograph & (rows < v1)
            assert inside.mean() > 0.93


def test_boxes_fit_their_silhouettes(street_frames: list[Sensed]) -> None:
    overlaps = []
    for sensed in street_frames:
        for label, meta in labeled(sensed):
            if label.truncated > 0 or label.type != "Car":
                continue
            a, b = np.array(label.bbox), np.array(meta["silhouette_bbox"])
            lo, hi = np.maximum(a[:2], b[:2]), np.minimum(a[2:], b[2:])
            both = np.prod(np.maximum(hi - lo, 0))
            overlaps.append(both / (np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2]) - both))
    assert len(overlaps) > 30
    assert np.median(overlaps) > 0.8


def camera_center_world(sensed: Sensed) -> NDArray[np.float64]:
    p2 = sensed.frame.calib.P2
    center_cam = -np.linalg.solve(p2[:, :3], p2[:, 3])
    world_from_cam = np.linalg.inv(sensed.cam_from_world)
    center: NDArray[np.float64] = world_from_cam[:3, :3] @ center_cam + world_from_cam[:3, 3]
    return center


def test_pixels_of_labeled_actors_are_those_that_parry_meets() -> None:
    """Parry, which knows nothing of the kernel, must meet the labeled actor first along its pixels' rays."""
    scene = cadet.Scene.random(seed=3, weather="clear_noon")
    sensed = sense(scene)
    p2 = sensed.frame.calib.P2
    world_from_cam = np.linalg.inv(sensed.cam_from_world)
    origin = camera_center_world(sensed)
    checked = 0
    for _, meta in labeled(sensed):
        rows, columns = np.nonzero(sensed.frame.instance == meta["actor_id"])
        pixels = np.stack([columns, rows, np.ones(len(rows))], axis=1).astype(float)
        directions = pixels @ np.linalg.inv(p2[:, :3]).T @ world_from_cam[:3, :3].T
        _, actor_id, _ = scene.cast_rays(np.repeat(origin[None], len(pixels), axis=0), directions)
        assert (actor_id == meta["actor_id"]).mean() > 0.995
        checked += 1
    assert checked >= 1


def shares_in_sight(scene: cadet.Scene, sensed: Sensed) -> dict[int, float]:
    """Tell by parry which share of each actor's surface in the image is met first from the camera, or shows itself.

    A ray that ends on the actor itself, before the point or behind it, counts as in sight: only others hide.
    """
    vertices, faces, actor_ids = scene.triangles()
    frame, rng = sensed.frame, np.random.default_rng(0)
    height, width = frame.image.shape[:2]
    origin = camera_center_world(sensed)
    shares = {}
    for actor_id in np.unique(actor_ids[actor_ids > 0]).tolist():
        corners = vertices[faces[actor_ids == actor_id]].astype(np.float64)
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        chosen = rng.choice(len(corners), 300, p=areas / areas.sum())
        points_world = np.einsum("nk,nkd->nd", rng.dirichlet(np.ones(3), 300), corners[chosen])
        points_cam = points_world @ sensed.cam_from_world[:3, :3].T + sensed.cam_from_world[:3, 3]
        ahead = points_cam[:, 2] > 0.5
        uvw = points_cam[ahead] @ frame.calib.P2[:, :3].T + frame.calib.P2[:, 3]
        u, v = uvw[:, 0] / uvw[:, 2], uvw[:, 1] / uvw[:, 2]
        targets = points_world[ahead][(u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)]
        if len(targets) >= 30 and points_cam[ahead, 2].mean() < 80.0:
            hits = scene.cast_rays(np.repeat(origin[None], len(targets), axis=0), targets - origin)
            shares[actor_id] = float((hits.actor_id == actor_id).mean())
    return shares


def test_no_label_through_walls() -> None:
    """Of all actors before the camera, those that others hide from parry's rays have no label, and others have."""
    num_hidden = num_partly = num_plain = 0
    for seed in range(6):
        scene = cadet.Scene.random(seed=seed, weather="clear_noon")
        sensed = sense(scene)
        metas = {meta["actor_id"]: meta for _, meta in labeled(sensed)}
        shares = shares_in_sight(scene, sensed)
        hidden = {actor_id for actor_id, share in shares.items() if share == 0.0}
        assert not hidden & set(metas), (seed, [metas[actor_id] for actor_id in hidden & set(metas)])
        num_hidden += len(hidden)
        for actor_id in set(metas) & set(shares):
            assert abs(metas[actor_id]["visible_fraction"] - shares[actor_id]) < 0.25, (metas[actor_id], shares)
            num_partly += shares[actor_id] < 0.7
            num_plain += shares[actor_id] > 0.9
    assert num_hidden > 10 and num_partly > 5 and num_plain > 15, (num_hidden, num_partly, num_plain)


def pixels_of(frame: cadet.Frame, actor_id: int) -> int:
    assert frame.instance is not None
    return int((frame.instance == actor_id).sum())


def car_beside_a_van(y: float, *, has_van: bool) -> tuple[cadet.Frame, int]:
    """A car 24 m ahead, `y` to the left, broadside, and, 12 m ahead, perhaps a van."""
    scene = cadet.Scene.empty(weather="clear_noon")
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    car = scene.add("car", x_m=24.0, y_m=y, yaw_rad=np.pi / 2, model_seed=2)
    if has_van:
        scene.add("van", x_m=12.0, y_m=0.0, yaw_rad=np.pi / 2, model_seed=1)
    return scene.capture(), car


def test_a_car_behind_a_van_is_occluded_by_as_much_as_the_van_hides() -> None:
    """The share of its pixels that a second image, without the van, shows as well."""
    levels = set()
    for y in np.arange(0.0, 8.5, 0.5):
        frame, car = car_beside_a_van(y, has_van=True)
        alone, same = car_beside_a_van(y, has_van=False)
        assert car == same and pixels_of(alone, car) > 1500
        share = pixels_of(frame, car) / pixels_of(alone, car)
        (of_alone,) = (label for label in alone.labels if label.type == "Car")
        assert (of_alone.occluded, objects_of(alone)[0]["visible_fraction"]) == (0, 1.0)
        found = {meta["actor_id"]: (label, meta) for label, meta in zip(frame.labels, objects_of(frame), strict=True)}
        (van,) = (label for label in frame.labels if label.type == "Van")
        assert van.occluded == 0
        if car in found:
            assert found[car][1]["visible_fraction"] == pytest.approx(share, abs=0.02)
        if min(abs(share - limit) for limit in (0.1, 0.5, 0.8)) < 0.02:
            continue
        label = found[car][0] if car in found else None
        if share < 0.1:
            assert label is None or label.type == "DontCare", share
            levels.add(-1)
        else:
            assert label is not None and label.type == "Car"
            assert label.occluded == (0 if share > 0.8 else 1 if share > 0.5 else 2), share
            levels.add(label.occluded)
    assert levels == {-1, 0, 1, 2}


def test_what_is_behind_a_wall_has_no_label(tmp_path: Path) -> None:
    own = assets_folder(tmp_path / "own", WALL)
    types = {}
    for has_wall in (False, True):
        scene = cadet.Scene.empty(weather="clear_noon", assets=own)
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        for number, kind in enumerate(("car", "van", "pedestrian", "car", "pedestrian")):
            scene.add(kind, x_m=20.0 + 2.0 * number, y_m=6.0 - 3.0 * number, yaw_rad=0.7 * number, model_seed=number)
        if has_wall:
            scene.add("truck", x_m=14.0, y_m=0.0, yaw_rad=np.pi / 2, model="wall")
        types[has_wall] = sorted(label.type for label in scene.capture().labels)
    assert types[False] == ["Car", "Car", "Pedestrian", "Pedestrian", "Van"]
    assert types[True] == ["Truck"]


@pytest.mark.parametrize("yaw", [0.0, 0.5, np.pi / 2, 2.5, -1.2, np.pi])
def test_a_lone_car_is_labeled_where_it_was_put(yaw: float) -> None:
    config = cadet.SceneConfig(label=cadet.LabelConfig(boxes="exact"))
    scene = cadet.Scene.empty(weather="clear_noon", config=config)
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    scene.add("car", x_m=15.0, y_m=2.0, yaw_rad=yaw, model_seed=4)
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
            # A road falls to both sides by up to 2.5 %.
            assert np.quantile(np.abs(distance), 0.98) < 0.07, np.quantile(np.abs(distance), 0.98)
            checked += 1
    assert checked > 20


def test_objects_stand_before_dontcare_in_the_file_and_in_the_meta() -> None:
    scene = cadet.Scene.empty()
    scene.move_ego(x_m=0, y_m=0, yaw_rad=0)
    # Too far to be labeled (1 and 3), near enough (2 and 4).
    for kind, x, y in [("car", 84, 5), ("car", 16, -4), ("car", 85, -9), ("pedestrian", 13, 3)]:
        scene.add(kind, x_m=x, y_m=y, yaw_rad=1.5)
    files = encode_frame(scene.capture())
    lines = [line.split() for line in files["label_2"].decode().splitlines()]
    objects = json.loads(files["meta"])["objects"]
    assert [line[0] for line in lines] == ["Car", "Pedestrian", "DontCare", "DontCare"]
    assert [o["actor_id"] for o in objects] == [2, 4, 1, 3]
    for line, o in zip(lines[:2], objects[:2], strict=True):
        assert [float(v) for v in line[11:14]] == pytest.approx(o["location_cam"], abs=0.006)


def test_a_box_is_displaced_toward_who_labeled_it_first() -> None:
    """Annotators draw a box once a track, from the end that is near when they first see it."""

    def middle_world(scene: cadet.Scene) -> float:
        (label,) = scene.capture().labels
        x, y, z = label.location_cam
        place = scene.sensor_poses()["world_from_cam"] @ np.array([x, y - label.dimensions_hwl[0] / 2.0, z, 1.0])
        return float(place[0])

    def scene_with_car() -> cadet.Scene:
        scene = cadet.Scene.empty(weather="clear_noon")
        scene.add("car", x_m=20.0, y_m=0.0, yaw_rad=0.0, model_seed=3)
        return scene

    seen_from_behind, seen_from_the_front = scene_with_car(), scene_with_car()
    before = middle_world(seen_from_behind)
    for scene in (seen_from_behind, seen_from_the_front):
        scene.move_ego(x_m=45.0, y_m=0.0, yaw_rad=np.pi)
    assert middle_world(seen_from_behind) == pytest.approx(before, abs=1e-6)
    # Toward the front by 0.16 m, toward the rear by 0.135 m.
    assert middle_world(seen_from_the_front) - before == pytest.approx(0.295, abs=1e-3)
