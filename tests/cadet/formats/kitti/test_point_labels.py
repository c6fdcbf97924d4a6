from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet import Agent, KittiFormatError, Scan, Semantic
from cadet.formats.kitti.files.point_labels import (
    bytes_from_point_labels,
    point_labels,
    point_labels_from_bytes,
    point_times_from_bytes,
)

NUM_LEARNED = 20
LEARNED = (
    {0: 0, 1: 0, 10: 1, 11: 2, 13: 5, 15: 3, 16: 5, 18: 4, 20: 5, 30: 6, 31: 7, 32: 8, 40: 9, 44: 10, 48: 11, 49: 12}
    | {50: 13, 51: 14, 52: 0, 60: 9, 70: 15, 71: 16, 72: 17, 80: 18, 81: 19, 99: 0}
    | {252: 1, 253: 7, 254: 6, 255: 8, 256: 5, 257: 5, 258: 4, 259: 5}
)
"""The class that is learned for each id of SemanticKITTI's labels: `learning_map` of its API; 0 is ignored."""


def make_scan(seen: list[tuple[int, Semantic]]) -> Scan:
    zeros = np.zeros(len(seen), np.int32)
    return Scan(
        points_velo=np.zeros((len(seen), 4), np.float32),
        ring=zeros,
        column=zeros,
        actor_id=np.array([actor for actor, _ in seen], np.int32),
        semantic=np.array([kind for _, kind in seen], np.uint8),
        range_m=zeros.astype(np.float64),
        time_s=zeros.astype(np.float32),
        echo=np.ones(len(seen), np.uint8),
    )


def make_agent(number: int, kind: str, speed_mps: float) -> Agent:
    return Agent(number, kind, "", (4.0, 1.8, 1.5), np.eye(4), (speed_mps, 0.0, 0.0), None)


def test_classes_and_instances_are_semantickittis() -> None:
    """By the table of SemanticKITTI's API: 40 road, 1 outlier, 10 car, 252 moving car, 254 moving person."""
    seen = [(0, Semantic.ROAD), (0, Semantic.SKY), (3, Semantic.CAR), (4, Semantic.VAN), (5, Semantic.PERSON)]
    agents = [make_agent(3, "Car", 0.0), make_agent(4, "Van", 8.0), make_agent(5, "Pedestrian", 1.3)]
    labels = point_labels(make_scan(seen), agents)
    assert labels.dtype == np.uint32
    assert (labels & 0xFFFF).tolist() == [40, 1, 10, 252, 254]
    assert (labels >> 16).tolist() == [0, 0, 3, 4, 5]


def test_every_class_of_ours_has_one_of_theirs() -> None:
    labels = point_labels(make_scan([(0, kind) for kind in Semantic]), [])
    assert (labels > 0).all()


def test_what_semantickitti_learns_of_them() -> None:
    """Every id is in its tables, and what moves is learned as the class that it has when it stands."""
    scan = make_scan(list(enumerate(Semantic, start=1)))
    still, moving = (
        [LEARNED[number] for number in (point_labels(scan, agents) & 0xFFFF).tolist()]
        for agents in ([], [make_agent(number, "", 5.0) for number in range(1, len(Semantic) + 1)])
    )
    assert still == moving
    bicycle, motorcycle, motorcyclist, parking, other_ground, trunk = 2, 3, 8, 10, 12, 16
    never = {bicycle, motorcycle, motorcyclist, parking, other_ground, trunk}
    assert set(still) == set(range(NUM_LEARNED)) - never
    # Its mean takes a class that is not there as 0.
    truth = np.array(still)
    assert mean_iou(truth, truth) == pytest.approx((NUM_LEARNED - 1 - len(never)) / (NUM_LEARNED - 1))
    assert mean_iou(np.roll(truth, 1), truth) < 0.1


def mean_iou(found: NDArray[np.int64], truth: NDArray[np.int64]) -> float:
    """Evaluate as SemanticKITTI's API: points whose true class is 0 are left out."""
    found, truth = found[truth > 0], truth[truth > 0]
    classes = np.arange(1, NUM_LEARNED)
    is_found, is_true = found == classes[:, None], truth == classes[:, None]
    either = (is_found | is_true).sum(axis=1)
    return float(((is_found & is_true).sum(axis=1) / np.maximum(either, 1)).mean())


def test_files_come_back_and_damaged_ones_are_refused() -> None:
    labels = np.array([40, 10 | 3 << 16], np.uint32)
    data = bytes_from_point_labels(labels)
    assert data == b"\x28\x00\x00\x00\x0a\x00\x03\x00"
    np.testing.assert_array_equal(point_labels_from_bytes(data), labels)
    with pytest.raises(KittiFormatError, match="7 bytes are not a whole number of labels"):
        point_labels_from_bytes(data[:-1])
    np.testing.assert_array_equal(point_times_from_bytes(b"\x00\x00\x00\xbf"), np.array([-0.5], np.float32))
    with pytest.raises(KittiFormatError, match="3 bytes are not a whole number of times"):
        point_times_from_bytes(b"abc")
