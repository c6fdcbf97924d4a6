"""Headings by points along the line of sight: angles in closed form, what turning changes, and what is learned."""

from __future__ import annotations

import math

import torch

from avod.config import RefinementConfig
from avod.geometry.orientation import wrap_angle
from avod.model.box_points import BoxPoints
from avod.model.heading import NUM_HEADINGS, PointHeading, heading_loss, heading_vectors, reversals

CONFIG = RefinementConfig(max_points=64, channels=(32, 32, 64), hidden=(32,))


def people(count: int, seed: int) -> torch.Tensor:
    """Draw people of any heading, 5 to 35 m ahead: (N, 7)."""
    low = torch.tensor([-8.0, 1.65, 5.0, 0.8, 0.6, 1.75, -math.pi])
    high = torch.tensor([8.0, 1.65, 35.0, 0.8, 0.6, 1.75, math.pi])
    return low + (high - low) * torch.rand((count, 7), generator=torch.Generator().manual_seed(seed))


def near_points(truths: torch.Tensor, rotations_y: torch.Tensor, seed: int) -> BoxPoints:
    """Scatter 40 points over each person, most of the low ones in front, in frames of other headings (N,)."""
    generator = torch.Generator().manual_seed(seed)
    height = 0.15 + 1.6 * torch.rand((len(truths), 40), generator=generator)
    ahead = 0.15 * torch.randn((len(truths), 40), generator=generator) + torch.where(height < 0.8, 0.15, 0.0)
    aside = 0.12 * torch.randn((len(truths), 40), generator=generator)
    # A direction at rotation_y r lies at r' - r from the axis of a frame at r', towards `across`.
    angle = (rotations_y - truths[:, 6])[:, None]
    along = torch.cos(angle) * ahead - torch.sin(angle) * aside
    across = torch.sin(angle) * ahead + torch.cos(angle) * aside
    box = torch.arange(len(truths)).repeat_interleave(40)
    return BoxPoints(box, along.flatten(), across.flatten(), height.flatten(), len(truths))


def features(boxes_cam: torch.Tensor) -> torch.Tensor:
    """Give what `box_features` would, but for the direction to the sensor, which headings do not look at."""
    distance_m = torch.hypot(boxes_cam[:, 0], boxes_cam[:, 2]) / 40.0
    rest = boxes_cam.new_tensor([float("nan"), float("nan"), 0.74, 0.8, 0.6, 1.75, 0.0, 1.75])
    return torch.cat([distance_m[:, None], rest.repeat(len(boxes_cam), 1)], dim=1)


def test_what_is_least_wrong_of_a_heading_points_to_it() -> None:
    truths = people(50, seed=0)
    logits = torch.zeros((50, NUM_HEADINGS), requires_grad=True)
    heading_loss(logits, truths).sum().backward()  # type: ignore[no-untyped-call]
    assert logits.grad is not None
    wanted = 1.0 / NUM_HEADINGS - logits.grad  # A cross entropy's gradient is what is given less what is wanted.
    vectors = heading_vectors(torch.log(wanted), truths)
    error = wrap_angle(torch.atan2(vectors[:, 1], vectors[:, 0]) - truths[:, 6])
    assert error.abs().max() < math.radians(1.0)


def test_a_reversal_speaks_for_the_front_of_the_box_or_for_its_rear() -> None:
    boxes_cam = people(50, seed=1)
    for logit, turn in ((-3.0, 0.0), (3.0, math.pi)):
        vectors = heading_vectors(reversals(torch.full((50,), logit), boxes_cam), boxes_cam)
        error = wrap_angle(torch.atan2(vectors[:, 1], vectors[:, 0]) - boxes_cam[:, 6] - turn)
        assert error.abs().max() < math.radians(1.0)
    assert not reversals(torch.zeros(50), boxes_cam).any()


def test_headings_do_not_hang_on_the_found_ones_nor_on_where_the_person_stands() -> None:
    torch.manual_seed(0)
    stage = PointHeading(CONFIG)
    torch.nn.init.normal_(stage.head.outputs[0].weight)  # type: ignore[arg-type]
    truths = people(20, seed=2)
    truths[:, 4] = truths[:, 3]  # else another heading would take in other points
    logits = []
    for turn in (0.0, 0.7):
        # All turned about the sensor: rotation_y and the bearing change by as much.
        away = truths.clone()
        cos, sin = math.cos(turn), math.sin(turn)
        away[:, 0], away[:, 2] = cos * truths[:, 0] + sin * truths[:, 2], cos * truths[:, 2] - sin * truths[:, 0]
        away[:, 6] += turn
        for found in (0.0, math.pi / 2, math.pi):
            boxes_cam = away.clone()
            boxes_cam[:, 6] += found
            logits.append(stage(near_points(away, boxes_cam[:, 6], seed=3), boxes_cam, features(boxes_cam)))
    assert logits[0].std(dim=0).min() > 0.01, "people of other headings look otherwise"
    for other in logits[1:]:
        torch.testing.assert_close(other, logits[0], atol=1e-3, rtol=0)


def test_points_of_the_ground_and_of_others_are_not_looked_at() -> None:
    torch.manual_seed(0)
    stage = PointHeading(CONFIG)
    torch.nn.init.normal_(stage.head.outputs[0].weight)  # type: ignore[arg-type]
    truths = people(1, seed=4)
    near = near_points(truths, truths[:, 6], seed=5)
    box = torch.cat([near.box, torch.tensor([0, 0])])
    along, across = torch.cat([near.along, torch.tensor([0.0, 0.8])]), torch.cat([near.across, torch.zeros(2)])
    more = BoxPoints(box, along, across, torch.cat([near.height, torch.tensor([0.05, 1.0])]), 1)
    seen = features(truths)
    assert torch.equal(stage(more, truths, seen), stage(near, truths, seen))


def test_it_learns_headings_of_people_whose_boxes_say_nothing_of_them() -> None:
    torch.manual_seed(0)
    stage = PointHeading(CONFIG)
    optimizer = torch.optim.Adam(stage.parameters(), lr=3e-3)

    def look(seed: int) -> tuple[torch.Tensor, torch.Tensor]:
        truths, boxes_cam = people(48, seed), people(48, seed)
        boxes_cam[:, 6] = people(48, seed + 10_000)[:, 6]
        return stage(near_points(truths, boxes_cam[:, 6], seed), boxes_cam, features(boxes_cam)), truths

    for step in range(150):
        logits, truths = look(step)
        optimizer.zero_grad()
        heading_loss(logits, truths).mean().backward()  # type: ignore[no-untyped-call]
        optimizer.step()
    with torch.no_grad():
        logits, truths = look(5_000)
    vectors = heading_vectors(logits, truths)
    error = wrap_angle(torch.atan2(vectors[:, 1], vectors[:, 0]) - truths[:, 6])
    assert (error.abs() < math.pi / 4).float().mean() > 0.9
