from __future__ import annotations

import numpy as np
import pytest

from cadet import Agent, KittiFormatError, Scan, Semantic
from cadet.formats.kitti.files.point_labels import (
    bytes_from_point_labels,
    point_labels,
    point_labels_from_bytes,
    point_times_from_bytes,
)


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
