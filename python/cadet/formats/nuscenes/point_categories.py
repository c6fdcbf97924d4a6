"""The category of every point of a scan, as nuScenes-lidarseg has it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.formats.nuscenes.classes import CATEGORIES, category
from cadet.sensors.sample import Agent, Scan
from cadet.sensors.semantic import Semantic

_INDEX: Final = {name: index for index, name in enumerate(CATEGORIES)}
_OF_SEMANTIC: Final = {
    Semantic.SKY: "noise",
    Semantic.ROAD: "flat.driveable_surface",
    Semantic.ROAD_MARKING: "flat.driveable_surface",
    Semantic.SIDEWALK: "flat.sidewalk",
    Semantic.TERRAIN: "flat.terrain",
    Semantic.BUILDING: "static.manmade",
    Semantic.FENCE: "static.manmade",
    Semantic.VEGETATION: "static.vegetation",
    Semantic.POLE: "static.manmade",
    Semantic.TRAFFIC_SIGN: "static.manmade",
    Semantic.FURNITURE: "static.manmade",
    Semantic.CAR: "vehicle.car",
    Semantic.VAN: "vehicle.car",
    Semantic.TRUCK: "vehicle.truck",
    Semantic.PERSON: "human.pedestrian.adult",
    Semantic.CYCLIST: "vehicle.bicycle",
    Semantic.TRAM: "vehicle.bus.rigid",
    # What is parked without being an agent: bicycles.
    Semantic.OTHER_VEHICLE: "vehicle.bicycle",
}
"""Of points that are no agent's."""


def point_categories(scan: Scan, agents: Iterable[Agent]) -> NDArray[np.uint8]:
    """Return the index of every point's category.

    Args:
        scan: a scan with returns.
        agents: those of the scan's instant: their points have the category of their annotation, but for what people
            lead, push, or pull.

    Returns:
        (N,) uint8, in the order of `scan.points_velo`.
    """
    table = np.zeros(max(_OF_SEMANTIC) + 1, np.uint8)
    table[list(_OF_SEMANTIC)] = [_INDEX[name] for name in _OF_SEMANTIC.values()]
    indices = table[scan.semantic]
    seen = set(np.unique(scan.actor_id).tolist())
    is_thing = scan.semantic == Semantic.FURNITURE
    for agent in agents:
        if agent.id not in seen:
            continue
        name = category(agent.type, agent.model)
        is_its = scan.actor_id == agent.id
        indices[is_its] = _INDEX[name]
        if name in ("human.pedestrian.adult", "human.pedestrian.child"):
            words = agent.model.rpartition("/")[0].split(" ")
            indices[is_its & is_thing] = _INDEX["animal" if "dog" in words else "movable_object.pushable_pullable"]
    return indices
