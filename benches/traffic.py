"""Faults of traffic: bodies in each other, off the ground, or standing for no end.

    python benches/traffic.py -n 200 --seconds 90 --workers 2
    python benches/traffic.py -n 20 --district motorway --district campus

lets so many episodes of the default policy run for a while, looks once a second, and prints the worst of each kind.
What is beyond its limit in an episode is printed at once.

* Overlap: how far one would have to be moved out of the other, boxes seen from above, agents whose heights overlap.
  Arms and legs that swing are in people's boxes, so pairs with people have a row of their own, as have the coupled cars
  of trams.
* Height: of the bottom over the ground beside the four corners and the middles of the sides, where that is even to 1
  cm: away from curbs, and from dips that a long vehicle stands across. Who sits on a chair is left out. Every five
  seconds.
* Standing: vehicles that have been seen to move, and stood since, by the reason at the head of the queue: who waits for
  another that stands waits for what that one waits for. A light and the end of a tram's line are reasons to stand for
  long; for other reasons it counts from when such a one was over.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

import cadet
from cadet.worlds.districts import District

PEOPLE = ("Pedestrian", "Person_sitting")
LONG_REASONS = ("light", "road end")
ABOVE_M = 1.0
BESIDE_M = 0.3
EVEN_M = 0.01
HEIGHTS_EVERY_S = 5
MOVING_MPS = 0.3
EGO = 0
CORNERS = [[1, 1], [-1, 1], [-1, -1], [1, -1]]
AROUND = [*CORNERS, [0, 1], [-1, 0], [0, -1], [1, 0]]


@dataclass
class Worst:
    """The worst of each kind so far, and where it was."""

    values: dict[str, float] = field(default_factory=dict)
    places: dict[str, str] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)

    def meet(self, kind: str, value: float, limit: float, place: str) -> None:
        """Take note of a value; what is beyond its limit is counted."""
        self.counts[kind] = self.counts.get(kind, 0) + (value > limit)
        if value > self.values.get(kind, -math.inf):
            self.values[kind], self.places[kind] = value, place

    def add(self, other: Worst) -> None:
        """Take over what another has met."""
        for kind, value in other.values.items():
            self.meet(kind, value, math.inf, other.places[kind])
            self.counts[kind] += other.counts[kind]

    def rows(self) -> Iterator[tuple[bool, str]]:
        """Yield a row of each kind, and whether something was beyond its limit."""
        for kind in sorted(self.values):
            count = self.counts[kind]
            yield count > 0, f"{kind:28} {self.values[kind]:8.3f}   {count:5} beyond its limit   {self.places[kind]}"


def around_world(agent: cadet.Agent, grown_m: float, places: list[list[int]]) -> NDArray[np.float64]:
    """Return places about a box's bottom, in half lengths and widths of the grown box: (places, 3)."""
    halves = np.asarray(agent.size_lwh[:2]) / 2 + grown_m
    local = np.concatenate([np.asarray(places) * halves, np.tile([0.0, 1.0], (len(places), 1))], axis=1)
    return (local @ agent.world_from_agent.T)[:, :3]


def overlap_m(a: cadet.Agent, b: cadet.Agent) -> float:
    """Return how far two rectangles reach into each other along the axis where it is least; below 0 apart."""
    rectangles = [around_world(agent, 0.0, CORNERS)[:, :2] for agent in (a, b)]
    least = math.inf
    for agent in (a, b):
        for axis in (agent.world_from_agent[:2, 0], agent.world_from_agent[:2, 1]):
            spans = [rectangle @ (axis / np.linalg.norm(axis)) for rectangle in rectangles]
            least = min(least, min(span.max() for span in spans) - max(span.min() for span in spans))
    return least


def near_pairs(agents: tuple[cadet.Agent, ...]) -> Iterator[tuple[cadet.Agent, cadet.Agent]]:
    """Yield pairs whose circles touch and whose heights overlap."""
    centers = np.array([agent.world_from_agent[:3, 3] for agent in agents])
    reaches = np.array([math.hypot(*agent.size_lwh[:2]) / 2 for agent in agents])
    for i, j in combinations(range(len(agents)), 2):
        if abs(centers[i, 0] - centers[j, 0]) > reaches[i] + reaches[j]:
            continue
        low = max(centers[i, 2], centers[j, 2])
        high = min(centers[i, 2] + agents[i].size_lwh[2], centers[j, 2] + agents[j].size_lwh[2])
        if low < high and math.dist(centers[i, :2], centers[j, :2]) < reaches[i] + reaches[j]:
            yield agents[i], agents[j]


def heights_m(scene: cadet.Scene, agents: list[cadet.Agent]) -> Iterator[tuple[cadet.Agent, float]]:
    """Yield agents that stand on even ground, and how far their bottoms are above it."""
    if not agents:
        return
    beside = np.concatenate([around_world(agent, BESIDE_M, AROUND) for agent in agents])
    origins = beside + [0.0, 0.0, ABOVE_M]
    hits = scene.cast_rays(origins, np.tile([0.0, 0.0, -1.0], (len(origins), 1)))
    above_m = np.where(hits.actor_id == 0, hits.range_m - ABOVE_M, np.nan).reshape(-1, len(AROUND))
    for agent, heights in zip(agents, above_m, strict=True):
        if np.ptp(heights) < 2 * EVEN_M:
            yield agent, float(heights.mean())


def kind_of(a: cadet.Agent, b: cadet.Agent) -> str:
    """Name the row that a pair's overlap belongs to."""
    if a.type == b.type == "Tram":
        return "overlap of trams' cars, m"
    return "overlap with people, m" if a.type in PEOPLE or b.type in PEOPLE else "overlap of vehicles, m"


def reason(agent: cadet.Agent, scene: cadet.Scene, agents: dict[int, cadet.Agent]) -> str:
    """Return what the head of an agent's queue waits for; "each other" where the queue bites its tail."""
    waits = {other.id: (other.brakes_for, other.brakes_for_id) for other in agents.values() if is_slow(other)}
    waits[EGO] = scene.ego_brakes_for or (None, None)
    seen, (why, ahead) = [agent.id], (agent.brakes_for, agent.brakes_for_id)
    while ahead in waits:
        if ahead in seen:
            return "each other"
        seen.append(ahead)
        why, ahead = waits[ahead]
    return why or "nothing"


def is_slow(agent: cadet.Agent) -> bool:
    """Return whether an agent stands, or nearly."""
    return agent.speed_mps <= MOVING_MPS


def watch(seed: int, seconds: int, policy: cadet.ResetPolicy) -> Worst:
    """Let an episode run and look once a second."""
    worst = Worst()
    scene = cadet.Scene.random(seed=seed, policy=policy)
    last_moved_s: dict[int, float] = {}
    since_s: dict[int, float] = {}
    for second in range(seconds):
        place = f"seed {seed}, second {second}: "
        agents = scene.agents
        for a, b in near_pairs(agents):
            worst.meet(kind_of(a, b), overlap_m(a, b), 0.02, f"{place}{a.id} ({a.model}) and {b.id} ({b.model})")
        standing = [agent for agent in agents if agent.type != "Person_sitting"]
        for agent, height_m in heights_m(scene, standing) if second % HEIGHTS_EVERY_S == 0 else ():
            kind = "above the ground, m" if height_m > 0 else "below the ground, m"
            worst.meet(kind, abs(height_m), 0.03, f"{place}{agent.id} ({agent.model})")
        by_id = {agent.id: agent for agent in agents}
        for agent in agents:
            if not is_slow(agent):
                last_moved_s[agent.id] = since_s[agent.id] = second
            elif agent.id in last_moved_s and agent.type not in PEOPLE:
                why = reason(agent, scene, by_id)
                is_long = why in LONG_REASONS
                stood_s = second - (last_moved_s if is_long else since_s)[agent.id]
                if is_long:
                    since_s[agent.id] = second
                limit_s = math.inf if is_long else 60.0
                worst.meet(f"standing for {why}, s", stood_s, limit_s, f"{place}{agent.id} ({agent.model})")
        scene.step(1.0)
    return worst


def main() -> None:
    """Watch the episodes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", dest="count", type=int, default=200, help="episodes")
    parser.add_argument("--seconds", type=int, default=90)
    parser.add_argument("--seed", type=int, default=0, help="of the first episode")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--district", action="append", help="instead of the policy's; several times for several")
    options = parser.parse_args()
    policy = cadet.ResetPolicy.kitti()
    if options.district:
        policy = replace(policy, districts=tuple((District.named(name), 1.0) for name in options.district))
    seeds = range(options.seed, options.seed + options.count)
    worst = Worst()
    with ProcessPoolExecutor(options.workers) as pool:
        episodes = pool.map(partial(watch, seconds=options.seconds, policy=policy), seeds)
        for seed, episode in zip(seeds, episodes, strict=True):
            worst.add(episode)
            beyond = [row for is_beyond, row in episode.rows() if is_beyond and "people" not in row]
            print("\n".join([f"seed {seed}", *beyond]), file=sys.stderr, flush=True)
    for _, row in worst.rows():
        print(row)


if __name__ == "__main__":
    main()
