"""The class and the instance of every point of a scan, as SemanticKITTI's `labels` have them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import check_array
from cadet.errors import CadetError, KittiFormatError
from cadet.sensors.sample import Agent, Scan
from cadet.sensors.semantic import Semantic

MOVING_MPS: Final = 0.5
"""Agents that are at least this fast get the class of what moves."""

_CLASSES: Final = {
    # What fog, drops and flakes return is SemanticKITTI's "outlier".
    Semantic.SKY: 1,
    Semantic.ROAD: 40,
    Semantic.ROAD_MARKING: 60,
    Semantic.SIDEWALK: 48,
    Semantic.TERRAIN: 72,
    Semantic.BUILDING: 50,
    Semantic.FENCE: 51,
    Semantic.VEGETATION: 70,
    Semantic.POLE: 80,
    Semantic.TRAFFIC_SIGN: 81,
    Semantic.FURNITURE: 99,
    # Its cars include vans.
    Semantic.CAR: 10,
    Semantic.VAN: 10,
    Semantic.TRUCK: 18,
    Semantic.PERSON: 30,
    Semantic.CYCLIST: 31,
    Semantic.TRAM: 16,
    Semantic.OTHER_VEHICLE: 20,
}
_MOVING: Final = {10: 252, 18: 258, 30: 254, 31: 253, 16: 256, 20: 259}
_MAX_INSTANCE: Final = 0xFFFF
_BYTES: Final = 4


def point_labels(scan: Scan, agents: Iterable[Agent]) -> NDArray[np.uint32]:
    """Label every point: SemanticKITTI's class in the lower 16 bits, the instance in the upper ones.

    Args:
        scan: a scan with returns.
        agents: those of the scan's instant: who moves has another class. Instances are their ids, and 0 elsewhere.

    Returns:
        (N,) uint32, in the order of `scan.points_velo`.

    Raises:
        CadetError: an agent whose id is above 65535.
    """
    table = np.zeros(max(_CLASSES) + 1, np.uint32)
    table[list(_CLASSES)] = list(_CLASSES.values())
    classes = table[scan.semantic]
    moving = [agent.id for agent in agents if agent.speed_mps >= MOVING_MPS]
    is_moving = np.isin(scan.actor_id, moving)
    for still, moved in _MOVING.items():
        classes[is_moving & (classes == still)] = moved
    instances = np.maximum(scan.actor_id, 0).astype(np.uint32)
    if instances.size and int(instances.max()) > _MAX_INSTANCE:
        raise CadetError(f"point_labels: expected ids up to {_MAX_INSTANCE}, got {int(instances.max())}")
    return classes | (instances << np.uint32(16))


def bytes_from_point_labels(labels: NDArray[np.uint32]) -> bytes:
    """Return the bytes of a label file: little-endian uint32.

    Raises:
        ShapeError: not (N,) uint32.
    """
    check_array(labels, "point_labels", ("N",), np.uint32)
    return labels.astype("<u4").tobytes()


def point_labels_from_bytes(data: bytes, file: str = "point_labels") -> NDArray[np.uint32]:
    """Read a label file: (N,) uint32.

    Raises:
        KittiFormatError: not a whole number of labels.
    """
    return np.frombuffer(_whole(data, "labels", file), "<u4").astype(np.uint32)


def point_times_from_bytes(data: bytes, file: str = "point_times") -> NDArray[np.float32]:
    """Read a file of `Scan.time_s`: (N,) float32, seconds.

    Raises:
        KittiFormatError: not a whole number of times.
    """
    return np.frombuffer(_whole(data, "times", file), "<f4").astype(np.float32)


def _whole(data: bytes, what: str, file: str) -> bytes:
    if len(data) % _BYTES:
        raise KittiFormatError(f"{len(data)} bytes are not a whole number of {what} of {_BYTES} bytes", file)
    return data
