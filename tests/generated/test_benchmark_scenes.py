"""The scenes that timings are taken on: seeds 0 to 9 of the default policy, full enough to mean something."""

from __future__ import annotations

import numpy as np
import pytest

import cadet

NEAR_M = 80.0


def count_near_triangles(scene: cadet.Scene) -> int:
    """Count the triangles with a corner within 80 m of the LIDAR."""
    vertices, faces, _ = scene.triangles()
    velo = scene.sensor_poses()["world_from_velo"][:3, 3]
    return int((np.linalg.norm(vertices[faces[:, 0]] - velo, axis=1) < NEAR_M).sum())


def count_near_actors(scene: cadet.Scene) -> int:
    """Count the actors whose triangles' middle lies within 80 m of the LIDAR, seen from above."""
    vertices, faces, actor_ids = scene.triangles()
    ego = scene.sensor_poses()["world_from_velo"][:2, 3]
    moving = actor_ids > 0
    middles = vertices[faces[moving]].mean(axis=1)[:, :2].astype(np.float64)
    _, actor = np.unique(actor_ids[moving], return_inverse=True)
    middle = np.stack([np.bincount(actor, middles[:, i]) for i in range(2)], axis=1) / np.bincount(actor)[:, None]
    return int((np.linalg.norm(middle - ego, axis=1) < NEAR_M).sum())


@pytest.fixture(scope="module")
def scenes() -> list[cadet.Scene]:
    return [cadet.Scene.random(seed=seed) for seed in range(10)]


def test_every_scene_has_300_000_triangles_near_the_ego_and_few_far_away(scenes: list[cadet.Scene]) -> None:
    near = [count_near_triangles(scene) for scene in scenes]
    assert min(near) >= 300_000, near
    everywhere = [scene.num_triangles for scene in scenes]
    assert np.median(everywhere) <= 700_000, everywhere


def test_every_scene_has_thirty_actors_near_the_ego(scenes: list[cadet.Scene]) -> None:
    counts = [count_near_actors(scene) for scene in scenes]
    assert min(counts) >= 30, counts
