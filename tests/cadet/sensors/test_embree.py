"""The ideal scan against Intel's Embree, a ray tracer that shares no line with ours, on `scene.triangles()`."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet

pytest.importorskip("embreex", reason="embreex is not installed: it has wheels for x86-64 alone")

from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

Rays = tuple[NDArray[np.float64], NDArray[np.float64]]


def rays_world(scene: cadet.Scene, lidar: cadet.Lidar) -> Rays:
    """Give the beams of a LIDAR in the world: origins and unit directions."""
    origins, directions, _, _ = lidar.rays()
    world_from_velo = scene.sensor_poses()["world_from_velo"]
    return origins @ world_from_velo[:3, :3].T + world_from_velo[:3, 3], directions @ world_from_velo[:3, :3].T


def embree_range_m(scene: cadet.Scene, rays: Rays) -> NDArray[np.float64]:
    """Trace rays by Embree; inf for a miss.

    Embree computes in single precision, so the world is moved until the sensor stands in its origin.
    """
    vertices, faces, _ = scene.triangles()
    center = scene.sensor_poses()["world_from_velo"][:3, 3]
    embree = EmbreeScene(robust=True)
    TriangleMesh(embree, (vertices - center).astype(np.float32), faces.astype(np.int32))
    origins, directions = (rays[0] - center).astype(np.float32), rays[1].astype(np.float32)
    found = embree.run(origins, directions, query="INTERSECT", output=True)
    return np.where(found["primID"] < 0, np.inf, found["tfar"].astype(np.float64))


def agree(a_m: NDArray[np.float64], b_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell where two answers lie within 1 mm, or are both a miss."""
    with np.errstate(invalid="ignore"):
        agreed: NDArray[np.bool_] = (a_m == b_m) | (np.abs(a_m - b_m) <= 1e-3)
    return agreed


@pytest.mark.parametrize("seed", [0, 2])
@pytest.mark.parametrize("lidar", [cadet.Lidar.hdl64e_kitti(), cadet.Lidar.hdl64e_uniform(), cadet.Lidar.cadet()])
def test_an_ideal_scan_agrees_with_embree_on_9999_of_10000_rays(seed: int, lidar: cadet.Lidar) -> None:
    scene = cadet.Scene.random(seed=seed)
    rays = rays_world(scene, lidar)
    range_m = scene.scan(lidar, ideal=True).range_m
    by_embree_m = embree_range_m(scene, rays)
    assert len(range_m) == len(rays[0])
    hits = np.isfinite(range_m)
    assert 0.3 < hits.mean() < 1.0, "a street has ground and sky"
    agreed = agree(range_m, by_embree_m)
    # Where they differ, double precision (parry's trees) says who is right.
    differing = ~agreed
    by_parry_m, _, _ = scene.cast_rays(rays[0][differing], rays[1][differing])
    for_kernel = agree(range_m[differing], by_parry_m).sum()
    summary = f"{differing.sum()} of {len(agreed)} differ, {for_kernel} of them as in double precision"
    assert agreed.mean() >= 0.9999, summary
    assert for_kernel >= 0.5 * differing.sum(), summary
