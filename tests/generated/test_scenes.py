"""What the benchmark's scenes hold."""

from __future__ import annotations

import numpy as np
import pytest

import cadet


@pytest.mark.parametrize("seed", range(10))
def test_thirty_actors_are_within_eighty_metres(seed: int) -> None:
    scene = cadet.Scene.random(seed=seed)
    vertices, faces, actor_id = scene.triangles()
    meta = scene.capture().meta
    assert meta is not None
    position = np.array(meta["world_from_ego"])[:2, 3]
    middles = vertices[faces].mean(axis=1)[:, :2]
    actors = np.unique(actor_id[actor_id > 0])
    near = [np.linalg.norm(middles[actor_id == actor].mean(axis=0) - position) < 80.0 for actor in actors]
    assert sum(near) >= 30
