"""What a large dataset takes on a cluster: a simulated schedule with stragglers and failures.

    python benches/schedule.py                      # the table of docs/measurements/performance.md
    python benches/schedule.py --samples 1000000 --nodes 16 --processors 64 --price 0.02

Episodes are handed out as `cadet-gen --engine ray` does: in their order, to whichever processor is free; what a dead
node was working on is handed out again.
"""

from __future__ import annotations

import argparse
import heapq
import random
from dataclasses import dataclass
from typing import Final

SAMPLES_PER_EPISODE: Final = 20
SAMPLES_PER_PROCESSOR_S: Final = 10.5 / 2
"""`cadet-gen -n 2000 --workers 2` on two processors (docs/performance.md), by each of them."""
BYTES_PER_SAMPLE: Final = 2.73e6
"""The mean of 1,200 samples of seed 100, all six files."""
OBJECTS_PER_SAMPLE: Final = 6
EPISODES_S: Final = (
    3.85,
    3.82,
    3.66,
    2.75,
    3.23,
    4.45,
    3.09,
    2.66,
    2.66,
    4.17,
    3.31,
    4.23,
    3.99,
    2.87,
    2.72,
    4.21,
    3.16,
    3.03,
    2.80,
    3.48,
    4.80,
    3.47,
    2.90,
    3.27,
    3.13,
    3.72,
    3.26,
    4.44,
    2.75,
    2.90,
    5.38,
    3.23,
    3.06,
    3.41,
    3.06,
    3.11,
    2.99,
    2.78,
    3.20,
    2.84,
    3.81,
    3.70,
    4.83,
    3.76,
    4.89,
    3.26,
    2.99,
    2.64,
    2.30,
    3.19,
    3.42,
    3.34,
    2.72,
    3.22,
    3.01,
    3.11,
    5.01,
    2.81,
    2.73,
    2.42,
)
"""Seconds of processor time of episodes 0 to 59 of seed 100 with one thread."""


@dataclass(frozen=True)
class Cluster:
    """Nodes and what befalls them."""

    num_nodes: int
    processors: int
    """Of each node."""
    num_slow: int = 0
    """Nodes that work at `slow_rate` of the others' rate: a noisy neighbor, a hot machine."""
    slow_rate: float = 0.5
    deaths_per_node_hour: float = 0.0
    """Of a node, without warning; another one takes its place after `restart_s`."""
    restart_s: float = 180.0


@dataclass(frozen=True)
class Outcome:
    """What a schedule came to."""

    end_s: float
    node_deaths: int
    lost_share: float
    """Work that dead nodes had begun, of all work."""
    idle_share: float
    """Processor time between a processor's last episode and the end, of all processor time."""


def simulate(durations_s: list[float], cluster: Cluster, seed: int = 0) -> Outcome:
    """Hand episodes out to the processors of a cluster and see when the last one is done.

    Args:
        durations_s: of each episode on a processor at full rate, in the order in which they are handed out.
        cluster: where.
        seed: names every draw of deaths.
    """
    draws = random.Random(seed)
    rates = [cluster.slow_rate if node < cluster.num_slow else 1.0 for node in range(cluster.num_nodes)]
    deaths_s = [_next_death(0.0, cluster, draws) for _ in rates]
    up_s = [0.0 for _ in rates]
    # Free processors by the time from when on they are free.
    free = [(0.0, node, processor) for node in range(cluster.num_nodes) for processor in range(cluster.processors)]
    again: list[float] = []
    left = iter(durations_s)
    end_s = lost_s = busy_s = 0.0
    num_deaths = 0
    last_s: dict[tuple[int, int], float] = {}
    # Work that is handed out again comes up when its node has died, before which nobody may take it.
    waiting: list[tuple[float, float]] = []
    while True:
        now_s, node, processor = heapq.heappop(free)
        if now_s >= deaths_s[node]:
            num_deaths += 1
            up_s[node] = deaths_s[node] + cluster.restart_s
            deaths_s[node] = _next_death(up_s[node], cluster, draws)
        if now_s < up_s[node]:
            heapq.heappush(free, (up_s[node], node, processor))
            continue
        while waiting and waiting[0][0] <= now_s:
            again.append(heapq.heappop(waiting)[1])
        duration_s = again.pop() if again else next(left, None)
        if duration_s is None:
            if not waiting:
                if not free:
                    break
                continue
            heapq.heappush(free, (waiting[0][0], node, processor))
            continue
        done_s = now_s + duration_s / rates[node]
        if done_s > deaths_s[node]:
            lost_s += deaths_s[node] - now_s
            heapq.heappush(waiting, (deaths_s[node], duration_s))
            heapq.heappush(free, (deaths_s[node], node, processor))
            continue
        busy_s += done_s - now_s
        end_s = max(end_s, done_s)
        last_s[node, processor] = done_s
        heapq.heappush(free, (done_s, node, processor))
    num_processors = cluster.num_nodes * cluster.processors
    idle_s = num_processors * end_s - sum(last_s.values())
    return Outcome(end_s, num_deaths, lost_s / (lost_s + busy_s), idle_s / (num_processors * end_s))


def _next_death(from_s: float, cluster: Cluster, draws: random.Random) -> float:
    rate = cluster.deaths_per_node_hour / 3600.0
    return from_s + draws.expovariate(rate) if rate > 0.0 else float("inf")


def durations(num_samples: int, order: str, seed: int = 0) -> list[float]:
    """Draw the episodes' durations from the measured ones, at the measured rate of `cadet-gen` as a whole."""
    draws = random.Random(seed)
    mean_s = sum(EPISODES_S) / len(EPISODES_S)
    scale = SAMPLES_PER_EPISODE / SAMPLES_PER_PROCESSOR_S / mean_s
    drawn = [scale * draws.choice(EPISODES_S) for _ in range(-(-num_samples // SAMPLES_PER_EPISODE))]
    return sorted(drawn, reverse=True) if order == "longest" else drawn


def _row(name: str, num_samples: int, cluster: Cluster, price_per_hour: float) -> str:
    outcome = simulate(durations(num_samples, "given"), cluster)
    hours = outcome.end_s / 3600.0
    num_processors = cluster.num_nodes * cluster.processors
    cells = (
        name,
        f"{hours:.2f}",
        f"{num_samples / outcome.end_s:,.0f}",
        f"{outcome.node_deaths}",
        f"{100.0 * outcome.lost_share:.2f} %",
        f"{100.0 * outcome.idle_share:.2f} %",
        f"{hours * num_processors * price_per_hour:,.0f}",
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=10_000_000)
    parser.add_argument("--nodes", type=int, default=4)
    parser.add_argument("--processors", type=int, default=64, help="of each node")
    parser.add_argument("--price", type=float, default=0.04, help="of a processor for an hour")
    options = parser.parse_args()
    heads = ("what happens", "hours", "samples a second", "nodes lost", "work lost", "idle at the end", "cost")
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    sizes = (options.nodes, options.processors)
    scenarios = {
        "nothing": Cluster(*sizes),
        "one node at half the rate": Cluster(*sizes, num_slow=1),
        "a node lives 24 hours": Cluster(*sizes, deaths_per_node_hour=1.0 / 24.0),
        "a node lives 1 hour, one at half the rate": Cluster(*sizes, num_slow=1, deaths_per_node_hour=1.0),
    }
    for name, cluster in scenarios.items():
        print(_row(name, options.samples, cluster, options.price))
    num_bytes, num_objects = options.samples * BYTES_PER_SAMPLE, options.samples * OBJECTS_PER_SAMPLE
    rate = SAMPLES_PER_PROCESSOR_S * BYTES_PER_SAMPLE
    print(f"\n{num_bytes / 1e12:.1f} TB in {num_objects / 1e6:,.0f} million objects, ", end="")
    print(f"{rate / 1e6:.1f} MB/s of each processor, {rate * options.processors * 8 / 1e9:.1f} Gbit/s of each node")
    print("\n| order | samples | processors | idle at the end |")
    print("|---|---|---|---|")
    for num_samples, processors in ((2_000, 2), (10_000, 2), (10_000, 64), (1_000_000, 2048)):
        for order in ("given", "longest"):
            seeds = [
                simulate(durations(num_samples, order, seed), Cluster(1, processors)).idle_share for seed in range(20)
            ]
            print(f"| {order} | {num_samples:,} | {processors} | {100.0 * sum(seeds) / len(seeds):.2f} % |")


if __name__ == "__main__":
    main()
