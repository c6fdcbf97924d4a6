"""What formats of sequences share: their clock, and the agents that they annotate."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from cadet.sensors.sample import Agent, Sample

_EPOCH_US: Final = 1_577_836_800_000_000
"""1 January 2020: when the first episode begins."""
_EPISODE_US: Final = 3_600_000_000
"""Episodes begin an hour after each other."""
_LEAST_SHARE: Final = 0.1
"""An agent without returns is annotated if the images show at least this share of it."""
_FARTHEST_M: Final = 80.0
"""An agent without returns is annotated up to this distance from the ego."""


def time_us(episode: int, time_s: float) -> int:
    """Return the Unix time of a sample in microseconds."""
    return _EPOCH_US + episode * _EPISODE_US + round(time_s * 1e6)


def seen_agents(sample: Sample) -> Iterator[tuple[Agent, int]]:
    """Yield the agents that the first LIDAR hits or the images show, each with its number of returns."""
    ids = sample.scan().actor_id
    counts = np.bincount(np.maximum(ids, 0)) if len(ids) else np.zeros(1, np.int64)
    here = sample.world_from_ego[:3, 3]
    for agent in sample.agents:
        num_points = int(counts[agent.id]) if agent.id < len(counts) else 0
        x, y, z = (agent.world_from_agent[:3, 3] - here).tolist()
        distance_m = math.sqrt(x * x + y * y + z * z)
        is_seen = (agent.visible_share or 0.0) >= _LEAST_SHARE and distance_m <= _FARTHEST_M
        if num_points > 0 or is_seen:
            yield agent, num_points
