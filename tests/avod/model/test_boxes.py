"""Boxes of a frame and of its mirror image, joined."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from avod import Detector
from avod.config import Config, DetectionConfig
from avod.data.dataset import sample_from_frame
from avod.data.mirror import mirror_box_tensors, mirror_sample
from avod.model.boxes import Boxes, joined
from avod.results import detections
from avod.train.step import new_network
from cadet.errors import CadetError
from synthetic import make_frame

CENTER = Config.named(Path(__file__).parents[2] / "support" / "detector" / "center.toml")
DETECTION = DetectionConfig(nms_iou=0.2)
BOX = (1.0, 1.6, 20.0, 4.0, 1.6, 1.5, 0.3)


def boxes(*rows: tuple[float, ...], scores: tuple[float, ...], classes: tuple[int, ...] | None = None) -> Boxes:
    kinds = torch.tensor(classes or (1,) * len(rows), dtype=torch.int64)
    return Boxes(torch.tensor(rows).reshape(-1, 7), torch.tensor(scores), kinds)


def test_two_equal_looks_are_one() -> None:
    once = boxes(BOX, (-6.0, 1.7, 30.0, 3.5, 1.7, 1.4, -3.1), scores=(0.9, 0.6))
    found = joined(once, once, DETECTION)
    torch.testing.assert_close(found.boxes_cam, once.boxes_cam)
    torch.testing.assert_close(found.scores, once.scores)


def test_boxes_found_twice_become_their_mean_and_others_lose_half_of_their_score() -> None:
    moved = (1.4, 1.7, 20.4, 4.4, 1.7, 1.6, 0.1)
    alone, new = (-9.0, 1.7, 40.0, 4.0, 1.6, 1.5, 1.0), (9.0, 1.7, 9.0, 4.0, 1.6, 1.5, 2.0)
    found = joined(boxes(BOX, alone, scores=(0.9, 0.8)), boxes(new, moved, scores=(0.5, 0.3)), DETECTION)
    weighted = [0.75 * a + 0.25 * b for a, b in zip(BOX, moved, strict=True)]
    torch.testing.assert_close(found.boxes_cam, torch.tensor([weighted, alone, new]))
    torch.testing.assert_close(found.scores, torch.tensor([0.6, 0.4, 0.25]))


def test_headings_meet_across_the_wrap_and_the_surer_of_two_opposite_ones_counts() -> None:
    def heading(first: float, second: float, scores: tuple[float, float]) -> float:
        one, other = boxes((*BOX[:6], first), scores=scores[:1]), boxes((*BOX[:6], second), scores=scores[1:])
        return float(joined(one, other, DETECTION).boxes_cam[0, 6])

    assert math.cos(heading(3.1, -3.1, (0.5, 0.5))) == pytest.approx(-1.0)
    assert heading(0.1, 0.3 - math.pi, (0.6, 0.2)) == pytest.approx(0.15)
    assert heading(0.1, 0.3 - math.pi, (0.2, 0.6)) == pytest.approx(0.25 - math.pi)


def test_other_classes_and_looks_that_found_nothing_are_not_joined() -> None:
    one, other, nothing = boxes(BOX, scores=(0.8,)), boxes(BOX, scores=(0.6,), classes=(2,)), boxes(scores=())
    assert joined(one, other, replace(DETECTION, suppression="class")).scores.tolist() == pytest.approx([0.4, 0.3])
    for looks in ((one, nothing), (nothing, one)):
        assert joined(*looks, DETECTION).scores.tolist() == pytest.approx([0.4])
    assert not len(joined(nothing, nothing, DETECTION).scores)


def test_a_detector_that_looks_twice_finds_the_mirrored_objects_in_the_mirrored_frame() -> None:
    flip = replace(CENTER, detection=replace(CENTER.detection, flip=True, min_score=0.0, max_detections=20))
    detector, frame = Detector(new_network(flip, 0)), make_frame()
    sample = sample_from_frame(frame, "000000", flip)
    found = []
    for seen in (sample, mirror_sample(sample)):
        (outputs,) = detector.run([seen])
        labels = detections(detector.network, outputs, seen, frame.calib, replace(flip, ground="file"))
        found.append(torch.tensor([[*label.box_cam, label.score or 0.0] for label in labels]))
    assert len(found[0]) > 3
    mirrored = torch.cat([mirror_box_tensors(found[1][:, :7]), found[1][:, 7:]], dim=1)
    order = [torch.argsort(rows[:, 0]) for rows in (found[0], mirrored)]
    torch.testing.assert_close(found[0][order[0]], mirrored[order[1]], rtol=1e-3, atol=1e-3)


def test_maps_that_reach_farther_to_one_side_cannot_be_mirrored() -> None:
    lopsided = replace(CENTER.bev, x_m=(CENTER.bev.x_m[0], CENTER.bev.x_m[1] * 2.0))
    with pytest.raises(CadetError, match=r"detection\.flip: expected bev.x_m as far to both sides"):
        replace(CENTER, bev=lopsided, detection=replace(CENTER.detection, flip=True))
