"""Mini-batches, targets and losses, on cases small enough to do by hand."""

from __future__ import annotations

import dataclasses
import math

import pytest
import torch

from avod.config import Config, RpnConfig, SecondStageConfig
from avod.data.order import torch_generator
from avod.data.sample import Sample
from avod.geometry.encoding import boxes_4c_from_anchors, boxes_4c_from_boxes, offsets_from_anchors
from avod.model.avod.losses import frame_losses, rpn_losses, second_stage_losses, smoothed_cross_entropy
from avod.model.avod.outputs import FrameOutputs
from avod.model.avod.targets import AnchorTargets, ProposalTargets, anchor_targets, sample_proposals, truth_proposals
from avod.ops import axis_aligned_iou

PLANE = torch.tensor([0.0, -1.0, 0.0, 1.65])
CAR = (0.0, 1.65, 20.0, 4.0, 2.0, 1.5, math.radians(10))


def make_sample(anchors: torch.Tensor, boxes: list[tuple[float, ...]], classes: list[int]) -> Sample:
    return Sample(
        frame_id="000000",
        bev=torch.zeros((6, 8, 8)),
        image=torch.zeros((3, 8, 8)),
        anchors=anchors,
        points_cam=torch.zeros((0, 3)),
        plane=PLANE,
        projection=torch.zeros((3, 4)),
        image_size=(8, 8),
        boxes_cam=torch.tensor(boxes).reshape(-1, 7),
        classes=torch.tensor(classes, dtype=torch.int64),
        ignored_cam=torch.zeros((0, 7)),
    )


def shifted(*shifts: float) -> torch.Tensor:
    """Make anchors of the car's size, each shifted along x: the overlap is (4 - s) / (4 + s)."""
    return torch.tensor([[s, 1.65, 20.0, 4.0, 1.5, 2.0] for s in shifts])


def test_thresholds_are_strict_and_overlaps_are_rounded() -> None:
    # Overlaps 1, 0.5 (neither), 0.5004 (rounds to 0.5: neither), 0.506 (positive), 0.3 (neither), 0.2996 (rounds), 0.
    shifts = [0.0, 4 / 3, 4 * (1 - 0.5004) / 1.5004, 4 * (1 - 0.506) / 1.506, 28 / 13, 4 * (1 - 0.2996) / 1.2996, 9.0]
    targets = anchor_targets(make_sample(shifted(*shifts), [CAR], [1]), RpnConfig(), torch_generator(0, "test"))
    labels = dict(zip(targets.chosen.tolist(), targets.is_object.tolist(), strict=True))
    assert labels == {0: True, 3: True, 6: False}


def test_offsets_lead_to_the_nearest_object_turned_to_the_axes() -> None:
    anchors = shifted(0.5, 30.0)
    targets = anchor_targets(make_sample(anchors, [CAR, (9.0, *CAR[1:])], [1, 1]), RpnConfig(), torch_generator(0, "t"))
    found = dict(zip(targets.chosen.tolist(), targets.offsets, strict=True))
    upright = torch.tensor([[0.0, 1.65, 20.0, 4.0, 1.5, 2.0]])
    torch.testing.assert_close(found[0], offsets_from_anchors(anchors[:1], upright)[0])
    assert (found[1] == 0).all(), "what overlaps nothing has no offsets"


@pytest.mark.parametrize(
    ("positive", "negative", "expected"), [(400, 900, (256, 256)), (10, 900, (10, 502)), (5, 20, (5, 20))]
)
def test_at_most_half_a_mini_batch_is_positive(positive: int, negative: int, expected: tuple[int, int]) -> None:
    anchors = torch.cat([shifted(*[0.0] * positive), shifted(*[9.0] * negative)])
    sample = make_sample(anchors, [CAR], [1])
    targets = anchor_targets(sample, RpnConfig(), torch_generator(0, "a"))
    assert (int(targets.is_object.sum()), int((~targets.is_object).sum())) == expected
    assert len(set(targets.chosen.tolist())) == len(targets.chosen)
    again = anchor_targets(sample, RpnConfig(), torch_generator(0, "a"))
    other = anchor_targets(sample, RpnConfig(), torch_generator(1, "a"))
    assert torch.equal(targets.chosen, again.chosen)
    assert not torch.equal(targets.chosen, other.chosen)


def test_proposals_take_the_class_and_corners_of_the_nearest_object() -> None:
    person = (9.0, 1.65, 20.0, 0.8, 0.6, 1.7, 0.3)
    sample = make_sample(shifted(0.0), [CAR, person], [1, 2])
    proposals = torch.cat([shifted(0.1, 1.0, 5.0), torch.tensor([[9.0, 1.6, 20.0, 0.8, 1.7, 0.6]])])
    chosen, targets = sample_proposals(proposals, sample, SecondStageConfig(), torch_generator(0, "p"))
    labels = dict(zip(chosen.tolist(), targets.labels.tolist(), strict=True))
    assert labels == {0: 1, 2: 0, 3: 2}, "an overlap of 0.6 is neither background nor object"
    row = chosen.tolist().index(3)
    torch.testing.assert_close(targets.boxes_4c[row], boxes_4c_from_boxes(torch.tensor([person]), PLANE)[0])
    torch.testing.assert_close(targets.vectors[row], torch.tensor([math.cos(0.3), math.sin(0.3)]))


def test_a_frame_without_objects_has_background_alone() -> None:
    sample = make_sample(shifted(0.0, 1.0), [], [])
    targets = anchor_targets(sample, RpnConfig(), torch_generator(0, "n"))
    assert len(targets.chosen) == 2 and not targets.is_object.any() and (targets.offsets == 0).all()
    chosen, proposals = sample_proposals(shifted(0.0, 1.0), sample, SecondStageConfig(), torch_generator(0, "n"))
    assert len(chosen) == 2 and (proposals.labels == 0).all()


def test_smoothed_cross_entropy_by_hand() -> None:
    logits = torch.tensor([[0.0, math.log(2.0), math.log(5.0)]])  # probabilities 1/8, 2/8, 5/8
    expected = -(0.999 * math.log(2 / 8) + 0.0005 * math.log(1 / 8) + 0.0005 * math.log(5 / 8))
    assert smoothed_cross_entropy(logits, torch.tensor([1]), 0.001).item() == pytest.approx(expected, rel=1e-6)


def first_stage(anchor_logits: torch.Tensor, anchor_offsets: torch.Tensor) -> FrameOutputs:
    empty = [torch.zeros((0, n)) for n in (6, 2, 10, 2)]
    return FrameOutputs(anchor_logits, anchor_offsets, empty[0], empty[1], empty[2], empty[3])


def test_first_stage_losses_by_hand() -> None:
    even = torch.zeros((3, 2))  # probability 1/2 each: every cross entropy is ln 2, however smoothed
    offsets = torch.tensor([[0.5, 0, 0, 0, 0, 0], [0, 3.0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 7.0]])
    targets = AnchorTargets(torch.tensor([0, 1]), torch.tensor([True, False]), torch.zeros((2, 6)))
    objectness, regression = rpn_losses(first_stage(even, offsets), targets, 0.001)
    assert objectness.item() == pytest.approx(math.log(2.0), rel=1e-6)
    # Smooth L1: 0.5 * 0.5^2 and 3 - 0.5, weighted 0.999 and 0.001.
    assert regression.item() == pytest.approx((0.999 * 0.125 + 0.001 * 2.5) / 1.0, rel=1e-6)
    negatives = dataclasses.replace(targets, is_object=torch.tensor([False, False]))
    _, regression = rpn_losses(first_stage(even, offsets), negatives, 0.001)
    assert regression.item() == pytest.approx((0.125 + 2.5) / 2, rel=1e-6), "without positives the weight cancels"


def test_second_stage_losses_by_hand() -> None:
    proposals = shifted(0.0, 0.0, 0.0)
    own = boxes_4c_from_anchors(proposals, PLANE)
    box = torch.zeros((3, 10))
    box[0, 0], box[1, 3], box[2, 0] = 0.5, 2.0, 99.0
    targets = ProposalTargets(torch.tensor([1, 1, 0]), own, torch.tensor([[1.0, 0.0]] * 3))
    vectors = torch.tensor([[1.0, 1.0], [1.0, 0.0], [50.0, 50.0]])
    found = FrameOutputs(
        torch.zeros((0, 2)), torch.zeros((0, 6)), proposals, torch.zeros((3, 2)), box, vectors, targets
    )
    classification, boxes, orientation = second_stage_losses(found, targets, PLANE, 0.001)
    assert classification.item() == pytest.approx(math.log(2.0), rel=1e-6)
    assert boxes.item() == pytest.approx((0.125 + 1.5) / 2, rel=1e-6), "background has no box"
    assert orientation.item() == pytest.approx(0.5 / 2, rel=1e-6)
    none = dataclasses.replace(targets, labels=torch.zeros(3, dtype=torch.int64))
    assert [x.item() for x in second_stage_losses(found, none, PLANE, 0.001)[1:]] == [0.0, 0.0]


def test_what_overlaps_an_ignored_object_is_no_background() -> None:
    anchors = shifted(0.0, 0.4, 9.0)
    sample = make_sample(anchors, [], [])
    ignoring = dataclasses.replace(sample, ignored_cam=torch.tensor([CAR]))
    config, generator = Config(), torch.Generator()
    assert anchor_targets(sample, config.rpn, generator).chosen.sort().values.tolist() == [0, 1, 2]
    assert anchor_targets(ignoring, config.rpn, generator).chosen.tolist() == [2]
    chosen, _ = sample_proposals(anchors, ignoring, config.second_stage, generator)
    assert chosen.tolist() == [2]


def test_losses_are_weighted() -> None:
    proposals = shifted(0.0)
    sample = make_sample(shifted(0.0, 9.0), [CAR], [1])
    targets = ProposalTargets(
        torch.tensor([1]), boxes_4c_from_anchors(proposals, PLANE) + 1.0, torch.tensor([[3.0, 0.0]])
    )
    found = FrameOutputs(
        torch.zeros((2, 2)),
        torch.ones((2, 6)),
        proposals,
        torch.zeros((1, 2)),
        torch.zeros((1, 10)),
        torch.zeros((1, 2)),
        targets,
    )
    chosen = AnchorTargets(torch.tensor([0]), torch.tensor([True]), torch.zeros((1, 6)))
    by_name = {name: value.item() for name, value in frame_losses(found, chosen, sample, Config()).by_name().items()}
    assert by_name == pytest.approx(
        {
            "objectness": math.log(2),
            "anchor": 5 * 6 * 0.5,
            "classification": math.log(2),
            "box": 5 * 10 * 0.5,
            "orientation": 2.5,
        },
        rel=1e-5,
    )


def test_proposals_about_the_truth_lie_on_it_or_hardly_overlap_it() -> None:
    sample = make_sample(shifted(30.0), [CAR, (9.0, *CAR[1:])], [1, 1])
    drawn = truth_proposals(sample, 200, torch_generator(0, "truths"))
    assert drawn.shape == (400, 6)
    for copies, x in ((drawn[:200], 0.0), (drawn[200:], 9.0)):
        truth = torch.tensor([[x - 2.0, 19.0, x + 2.0, 21.0]])
        half_x, half_z = copies[:, 3] / 2, copies[:, 5] / 2
        found = torch.stack(
            [copies[:, 0] - half_x, copies[:, 2] - half_z, copies[:, 0] + half_x, copies[:, 2] + half_z], dim=1
        )
        overlap = axis_aligned_iou(found, truth)[:, 0]
        # The second stage's threshold is 0.65: most copies are positive, some are not, some are nearly the truth.
        assert (overlap > 0.65).float().mean() > 0.6
        assert overlap.min() < 0.6 and overlap.max() > 0.95
    assert torch.equal(drawn, truth_proposals(sample, 200, torch_generator(0, "truths")))
    assert truth_proposals(make_sample(shifted(0.0), [], []), 8, torch_generator(0, "none")).shape == (0, 6)
