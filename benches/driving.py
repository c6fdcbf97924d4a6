"""How traffic drives: braking, jerks, and headways, beside published ones.

    python benches/driving.py -n 40 --seconds 60

lets episodes of the default policy run and looks ten times a second at every vehicle that moves. Accelerations are
those of speeds smoothed over a second, jerks those of accelerations smoothed likewise. Headways are of vehicles faster
than 5 m/s that follow another in their lane: from bumper to bumper, over the own speed.
"""

from __future__ import annotations

import argparse
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from cadet.simulation.episode import Episode
from cadet.worlds.policy import ResetPolicy

EVERY_S = 0.1
SMOOTH = np.ones(10) / 10
MOVES_MPS = 0.5
FOLLOWS_MPS = 5.0
FARTHEST_S = 4.0
BESIDE_M = 1.2
ALIGNED = 0.97
CLASSES = ("Car", "Van", "Truck", "Tram", "Cyclist")


def headways(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the headways (s) of those who follow another; rows are x, y, cos, sin, speed (m/s), length (m)."""
    xy, along, speed, length = states[:, :2], states[:, 2:4], states[:, 4], states[:, 5]
    to = xy[None] - xy[:, None]
    ahead = np.einsum("ijk,ik->ij", to, along)
    aside = to[..., 1] * along[:, None, 0] - to[..., 0] * along[:, None, 1]
    gap = ahead - (length[:, None] + length[None]) / 2
    follows = (gap > 0) & (np.abs(aside) < BESIDE_M) & (along @ along.T > ALIGNED)
    nearest = np.where(follows, gap, np.inf).min(axis=1)
    moves = (speed > FOLLOWS_MPS) & (nearest < FARTHEST_S * speed)
    gaps_s: NDArray[np.float64] = nearest[moves] / speed[moves]
    return gaps_s


def main() -> None:
    """Print a row per class: shares of accelerations and jerks, then headways."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=40, metavar="COUNT", help="episodes")
    parser.add_argument("--seconds", type=float, default=60.0)
    args = parser.parse_args()
    speeds: dict[str, list[list[float]]] = defaultdict(list)
    gaps_s: list[NDArray[np.float64]] = []
    for seed in range(args.n):
        episode = Episode(ResetPolicy.kitti(), seed, 0)
        episode.next_sample(0)
        scene, tracks = episode.scene, defaultdict(list)
        assert scene is not None
        for _ in range(round(args.seconds / EVERY_S)):
            scene.step(EVERY_S)
            states = []
            for agent in scene.agents:
                if agent.class_name not in CLASSES:
                    continue
                pose, velocity = np.asarray(agent.world_from_agent), np.asarray(agent.velocity_world)
                along = pose[:2, 0] / np.linalg.norm(pose[:2, 0])
                speed = float(velocity[:2] @ along)
                tracks[agent.class_name, agent.id].append(speed)
                states.append([*pose[:2, 3], *along, speed, agent.size_lwh[0]])
            gaps_s.append(headways(np.array(states)))
        for (name, _), track in tracks.items():
            speeds[name].append(track)
    print(
        f"{'':8} {'vehicles':>8} {'braking: 1 of 10':>17} {'of 100':>8} {'of 1000, m/s2':>14} {'jerk: 95 %, m/s3':>17}"
    )
    for name in CLASSES:
        braking, jerks = [], []
        for track in speeds[name]:
            if len(track) < 60 or max(track) < MOVES_MPS:
                continue
            smooth = np.convolve(track, SMOOTH, "valid")
            accelerations = np.diff(smooth) / EVERY_S
            braking.append(-accelerations[(smooth[1:] > MOVES_MPS) & (accelerations < -0.2)])
            jerks.append(np.abs(np.diff(np.convolve(accelerations, SMOOTH, "valid")) / EVERY_S))
        if braking:
            of_10, of_100, of_1000 = np.quantile(np.concatenate(braking), [0.9, 0.99, 0.999])
            jerk = np.quantile(np.concatenate(jerks), 0.95)
            print(f"{name:8} {len(braking):8} {of_10:17.2f} {of_100:8.2f} {of_1000:14.2f} {jerk:17.2f}")
    gaps = np.concatenate(gaps_s)
    low, half, high = np.quantile(gaps, [0.05, 0.5, 0.95])
    print(f"headways: {len(gaps)}, 5 % {low:.2f}, 50 % {half:.2f}, 95 % {high:.2f} s")


if __name__ == "__main__":
    main()
