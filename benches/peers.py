"""The ideal LIDAR scan against Embree and parry: `make bench-peers`, or `python benches/peers.py [--seeds 0 1 2]`.

The same triangles (`scene.triangles()`) and the same 133,312 rays (`Lidar.hdl64e_uniform()`), one thread, over the
benchmark's scenes: seeds 0 to 9 of the default policy, as they come. Processor time of the thread, the three by turns,
medians.

What counts:
    cadet: `scene.scan(lidar, ideal=True)` right after the world moved, so with the instant's poses, levels of detail
        and posing, and with the arrays that Python gets: points, ring, column, actor, range.
    Embree: `EmbreeScene.run(..., query="DISTANCE")`, trace alone. Its tree was built before (also printed). `embreex`
        offers single rays alone, no packets; a compiled loop copies each ray from numpy into Embree's structure, calls
        `rtcIntersect1` and copies the distance back.
    Embree, same arrays: with the triangle of each hit, and numpy's work for what Python gets of cadet: points, ring,
        column, actor, range. Its tree is still the one that was built before.
    parry: `scene.cast_rays`, its trees built before; with actor and normal of each hit.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

import cadet

PEERS = ("cadet", "embree", "same arrays", "parry")
NEAR_M = 80.0


def time_ms(work: Callable[[], object]) -> float:
    """Measure the processor time of this thread over one call, in milliseconds."""
    start = time.thread_time()
    work()
    return (time.thread_time() - start) * 1e3


def count_near(scene: cadet.Scene) -> tuple[int, int]:
    """Count triangles with a corner, and actors with their triangles' middle, within 80 m of the LIDAR."""
    vertices, faces, actor_ids = scene.triangles()
    velo = scene.sensor_poses()["world_from_velo"][:3, 3]
    near = np.linalg.norm(vertices[faces[:, 0]] - velo, axis=1) < NEAR_M
    middles = vertices[faces].mean(axis=1)[:, :2].astype(np.float64)
    actors = [id_ for id_ in np.unique(actor_ids) if id_ > 0]
    distances = [np.linalg.norm(middles[actor_ids == id_].mean(axis=0) - velo[:2]) for id_ in actors]
    return int(near.sum()), int((np.array(distances) < NEAR_M).sum())


def compare(seed: int, rounds: int) -> dict[str, float]:
    """Time one scene's scan with each of the peers, by turns; medians in milliseconds, with counts and the build."""
    scene = cadet.Scene.random(seed=seed)
    lidar = cadet.Lidar.hdl64e_uniform()
    origins, directions, ring, column = lidar.rays()
    world_from_velo = scene.sensor_poses()["world_from_velo"]
    origins_world = origins @ world_from_velo[:3, :3].T + world_from_velo[:3, 3]
    directions_world = directions @ world_from_velo[:3, :3].T
    vertices, faces, actor_ids = scene.triangles()
    actor_of = np.append(actor_ids, -1)  # by the number of a triangle, -1 for a miss
    embree = EmbreeScene()
    origins_f32, directions_f32 = origins_world.astype(np.float32), directions_world.astype(np.float32)

    def build() -> None:
        TriangleMesh(embree, vertices, faces.astype(np.int32))
        embree.run(origins_f32[:1], directions_f32[:1], query="DISTANCE")  # the tree is built at the first ray

    def same_arrays() -> tuple[NDArray[np.generic], ...]:
        hits = embree.run(origins_f32, directions_f32, query="INTERSECT", output=1)
        is_hit = hits["primID"] >= 0
        range_m = np.where(is_hit, hits["tfar"], np.inf).astype(np.float64)
        points = np.zeros((len(range_m), 4), np.float32)
        points[:, :3] = origins + directions * hits["tfar"][:, None]
        points[~is_hit] = np.nan
        return points, ring.copy(), column.copy(), actor_of[hits["primID"]], range_m

    near_triangles, near_actors = count_near(scene)
    row = {"triangles": float(len(faces)), "near": float(near_triangles), "actors": float(near_actors)}
    row |= {"embree build": time_ms(build)}
    times: dict[str, list[float]] = {peer: [] for peer in PEERS}
    for _ in range(rounds):
        scene.step(0.0)  # no time passes, but what was posed is forgotten
        times["cadet"].append(time_ms(lambda: scene.scan(lidar, ideal=True)))
        times["embree"].append(time_ms(lambda: embree.run(origins_f32, directions_f32, query="DISTANCE")))
        times["same arrays"].append(time_ms(same_arrays))
        scene.cast_rays(origins_world[:1], directions_world[:1])  # builds parry's trees
        times["parry"].append(time_ms(lambda: scene.cast_rays(origins_world, directions_world)))
    return row | {peer: float(np.median(times[peer])) for peer in PEERS}


def main() -> None:
    """Print a row for each scene and the medians."""
    parser = argparse.ArgumentParser(description="Time the ideal scan against Embree and parry on the same triangles.")
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(10)))
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args()
    print(
        "  seed triangles  in 80 m actors   cadet  embree  same arrays   parry"
        "  embree/cadet  same arrays/cadet  parry/cadet  (embree's build)"
    )
    rows = []
    for name in [*args.seeds, "median"]:
        if name != "median":
            row = compare(name, args.rounds)
            row |= {f"to {peer}": row[peer] / row["cadet"] for peer in PEERS}
            rows.append(row)
        else:
            row = {key: float(np.median([r[key] for r in rows])) for key in rows[0]}
        print(
            f"{name:>6} {row['triangles']:9.0f} {row['near']:8.0f} {row['actors']:6.0f}"
            f" {row['cadet']:7.2f} {row['embree']:7.2f} {row['same arrays']:12.2f} {row['parry']:7.2f}"
            f" {row['to embree']:12.2f}x {row['to same arrays']:17.2f}x {row['to parry']:11.2f}x"
            f"  {row['embree build']:12.0f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
