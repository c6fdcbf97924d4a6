"""The ideal LIDAR scan against Embree and parry: `make bench-peers`, or `python benches/peers.py [--seeds 0 1 2]`.

The same triangles (`scene.triangles()`) and the same 133,312 rays (`Lidar.hdl64e_uniform()`), one thread, over the
benchmark's scenes: seeds 0 to 9 of the default policy, as they come. Processor time of the thread, the three by turns,
medians.

What counts:
    cadet: `scene.scan(lidar, ideal=True)` right after the world moved, so with the instant's poses, levels of detail
        and posing, and with the arrays that Python gets: points, ring, column, actor, range.
    Embree's single rays and packets: `rtcIntersect1` and `rtcIntersect16` of the library that `embreex` brings, the
        latter of 16 neighbors in azimuth that Embree is told are coherent; trace alone. The tree was built before (also
        printed). A compiled loop copies each ray from numpy into Embree's structure, and distance and triangle back.
    Embree, same arrays: its packets, and numpy's work for what Python gets of cadet.
    parry: `scene.cast_rays`, its trees built before; with actor and normal of each hit.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from embree_library import EmbreeLibrary
from numpy.typing import NDArray

import cadet

PEERS = ("cadet", "single rays", "packets", "same arrays", "parry")
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
    rays = origins_world.astype(np.float32), directions_world.astype(np.float32)
    start = time.thread_time()
    embree = EmbreeLibrary(vertices, faces)
    build_ms = (time.thread_time() - start) * 1e3

    def same_arrays() -> tuple[NDArray[np.generic], ...]:
        distances, triangles = embree.trace(*rays, packets=True)
        is_hit = np.isfinite(distances)
        points = np.zeros((len(distances), 4), np.float32)
        points[:, :3] = origins + directions * np.where(is_hit, distances, np.nan)[:, None]
        points[~is_hit] = np.nan
        actor = actor_of[np.where(is_hit, triangles, len(faces))]
        return points, ring.copy(), column.copy(), actor, distances.astype(np.float64)

    near_triangles, near_actors = count_near(scene)
    row = {"triangles": float(len(faces)), "near": float(near_triangles), "actors": float(near_actors)}
    row |= {"rays": float(len(origins)), "embree build": build_ms}
    times: dict[str, list[float]] = {peer: [] for peer in PEERS}
    for _ in range(rounds):
        scene.step(0.0)  # no time passes, but what was posed is forgotten
        times["cadet"].append(time_ms(lambda: scene.scan(lidar, ideal=True)))
        times["single rays"].append(time_ms(lambda: embree.trace(*rays, packets=False)))
        times["packets"].append(time_ms(lambda: embree.trace(*rays, packets=True)))
        times["same arrays"].append(time_ms(same_arrays))
        scene.cast_rays(origins_world[:1], directions_world[:1])  # builds parry's trees
        times["parry"].append(time_ms(lambda: scene.cast_rays(origins_world, directions_world)))
    embree.close()
    return row | {peer: float(np.median(times[peer])) for peer in PEERS}


def main() -> None:
    """Print a row for each scene and the medians."""
    parser = argparse.ArgumentParser(description="Time the ideal scan against Embree and parry on the same triangles.")
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(10)))
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args()
    print("Milliseconds of a scan, and how many times cadet's they are")
    print("  seed triangles  in 80 m actors" + "".join(f"{peer:>20}" for peer in PEERS) + "  (Embree's build)")
    rows = []
    for name in [*args.seeds, "median"]:
        if name != "median":
            row = compare(name, args.rounds)
            rows.append(row | {f"to {peer}": row[peer] / row["cadet"] for peer in PEERS})
            row = rows[-1]
        else:
            row = {key: float(np.median([r[key] for r in rows])) for key in rows[0]}
        print(
            f"{name:>6} {row['triangles']:9.0f} {row['near']:8.0f} {row['actors']:6.0f}"
            + "".join(f"{row[peer]:12.2f} {row[f'to {peer}']:6.2f}x" for peer in PEERS)
            + f"  {row['embree build']:16.0f}",
            flush=True,
        )
    rates = ", ".join(f"{peer} {row['rays'] / row[peer] / 1e3:.2f}" for peer in PEERS)
    print(f"Million rays a second, by the medians: {rates}")


if __name__ == "__main__":
    main()
