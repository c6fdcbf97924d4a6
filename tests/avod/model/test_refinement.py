"""The stage that corrects boxes by their points: its geometry in closed form, and that it learns."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import torch

from avod.config import RefinementConfig
from avod.data.sample import Sample
from avod.geometry.orientation import wrap_angle
from avod.model.box_points import points_near
from avod.model.refinement import PointRefinement, _headed, _overlap, corrected, corrections_to, point_features
from cadet.evaluation import box_iou_3d

FLAT = torch.tensor([0.0, -1.0, 0.0, 1.65])
TILTED = torch.tensor([0.05, -1.0, 0.03, 1.6]) / math.sqrt(1.0 + 0.05**2 + 0.03**2)
CONFIG = RefinementConfig(max_points=32, channels=(16, 16, 32), hidden=(32,))


def sample_of(points_cam: torch.Tensor, boxes_cam: torch.Tensor, plane: torch.Tensor = FLAT) -> Sample:
    none = torch.zeros((0, 6))
    return Sample(
        "000000",
        bev=none,
        image=none,
        anchors=none,
        points_cam=points_cam,
        plane=plane,
        projection=torch.zeros((3, 4)),
        image_size=(8, 8),
        boxes_cam=boxes_cam,
        classes=torch.ones(len(boxes_cam), dtype=torch.int64),
        ignored_cam=torch.zeros((0, 7)),
    )


def boxes(count: int, seed: int) -> torch.Tensor:
    """Draw cars that stand on the flat ground, 8 to 30 m ahead."""
    low = torch.tensor([-8.0, 1.65, 8.0, 3.5, 1.5, 1.4, -math.pi])
    high = torch.tensor([8.0, 1.65, 30.0, 4.5, 1.8, 1.7, math.pi])
    return low + (high - low) * torch.rand((count, 7), generator=torch.Generator().manual_seed(seed))


def surface_points(boxes_cam: torch.Tensor, count: int, seed: int) -> torch.Tensor:
    """Scatter points over the sides and the top of boxes, most in front and on one side: (N * count, 3)."""
    generator = torch.Generator().manual_seed(seed)
    place = torch.rand((len(boxes_cam), count, 3), generator=generator) - 0.5
    side = torch.randint(3, (len(boxes_cam), count, 1), generator=generator)
    place = torch.where(torch.arange(3) == side, torch.where(place > -0.4, 0.5, -0.5), place)
    place[..., 1] = torch.where(side[..., 0] == 1, -1.0, place[..., 1] - 0.5)
    u, y, v = (place * boxes_cam[:, None, [3, 5, 4]]).unbind(dim=2)
    cos, sin = torch.cos(boxes_cam[:, 6:]), torch.sin(boxes_cam[:, 6:])
    local = torch.stack([cos * u + sin * v, y, -sin * u + cos * v], dim=2)
    return (local + boxes_cam[:, None, :3]).reshape(-1, 3)


def beside(boxes_cam: torch.Tensor, seed: int) -> torch.Tensor:
    """Put boxes where no object is, 3 m behind those."""
    generator = torch.Generator().manual_seed(seed)
    moved = boxes_cam.clone()
    moved[:, 2] += 3.0 + torch.rand(len(moved), generator=generator)
    return moved


def beside_points(boxes_cam: torch.Tensor) -> torch.Tensor:
    """Scatter points in boxes."""
    return surface_points(boxes_cam, 20, seed=3)


@pytest.mark.parametrize("plane", [FLAT, TILTED])
def test_applied_corrections_give_the_other_box_and_keep_the_end_that_is_the_front(plane: torch.Tensor) -> None:
    found, truths = boxes(50, seed=0), boxes(50, seed=1)
    truths[:, :3] = found[:, :3] + 0.3 * torch.randn((50, 3), generator=torch.Generator().manual_seed(2))
    now = corrected(found, corrections_to(found, truths, plane), plane)
    torch.testing.assert_close(now[:, :6], truths[:, :6], atol=1e-5, rtol=0)
    torch.testing.assert_close(torch.sin(2.0 * now[:, 6]), torch.sin(2.0 * truths[:, 6]), atol=1e-5, rtol=0)
    assert bool((torch.cos(now[:, 6] - found[:, 6]) > -1e-5).all())


def test_points_are_seen_from_the_box_and_those_beyond_the_margin_are_not() -> None:
    # Headed along -z: its right-hand side in the cam frame is at +x... of its own frame, `across` is there.
    box = torch.tensor([[2.0, 1.65, 20.0, 4.0, 1.6, 1.5, math.pi / 2]])
    front_corner = [2.8, 1.65 - 0.5, 18.0]
    beyond = [2.0, 1.0, 20.0 + 2.0 + 0.8]
    points = torch.tensor([front_corner, beyond, [2.0, 1.65 + 0.4, 20.0], [2.0, 1.65 - 3.3, 20.0]])
    gathered = points_near(sample_of(points, box), box, CONFIG.margin_m)
    assert gathered.counts.tolist() == [1] and gathered.box.tolist() == [0]
    features = point_features(gathered, box)
    torch.testing.assert_close(features[0], torch.tensor([2.0, 0.8, 0.5, 1.0, 1.0, 0.0, 0.0]), atol=1e-5, rtol=0)


def test_of_many_points_as_many_as_there_is_room_for_are_taken_evenly() -> None:
    box = torch.tensor([[0.0, 1.65, 10.0, 4.0, 1.6, 1.5, 0.0]]).repeat(2, 1)
    box[1, 2] = 40.0
    along = torch.linspace(-2.0, 2.0, 1000)
    points = torch.stack([along, torch.full_like(along, 1.0), torch.full_like(along, 10.0)], dim=1)
    gathered = points_near(sample_of(points, box), box, CONFIG.margin_m)
    assert gathered.counts.tolist() == [1000, 0]
    assert gathered.at_most(32).counts.tolist() == [32, 0]
    gaps = gathered.at_most(32).along.diff()
    assert gaps.min() > 0.0 and gaps.max() < 2.0 * 4.0 / 32


def test_boxes_of_hardly_a_point_stay_as_they_are() -> None:
    stage = PointRefinement(CONFIG)
    torch.nn.init.constant_(stage.head.outputs[0].bias, 1.0)  # type: ignore[arg-type]
    truths = boxes(2, seed=3)
    points = torch.cat([surface_points(truths[:1], 50, seed=0), truths[1:, :3] - torch.tensor([0.0, 0.5, 0.0])])
    now, qualities = stage(sample_of(points, truths), truths)
    assert torch.equal(now[1], truths[1]) and not torch.equal(now[0], truths[0])
    assert qualities[1] == 0.0 < qualities[0]
    none, no_qualities = stage(sample_of(points, truths), truths[:0])
    assert none.shape == (0, 7) and no_qualities.shape == (0,)


def test_copies_and_found_boxes_are_compared_with_their_objects() -> None:
    truths = boxes(3, seed=4)
    truths[:, [0, 2]] = torch.tensor([[-6.0, 10.0], [0.0, 16.0], [6.0, 24.0]])
    points = surface_points(truths, 80, seed=1)
    found = torch.cat([truths[1:2], beside(truths, 0)])
    stage = PointRefinement(dataclasses.replace(CONFIG, copies=2))
    outputs = stage.learned(sample_of(torch.cat([points, beside_points(found)]), truths), found, torch.Generator())
    assert outputs.has_object.tolist() == [True] * 7 + [False] * 3
    # The untrained stage corrects nothing: a true box keeps its full overlap.
    assert outputs.qualities[6] == 1.0 and not outputs.qualities[7:].any()
    torch.testing.assert_close(outputs.wanted[6], torch.zeros(7), atol=1e-5, rtol=0)
    nothing = sample_of(beside_points(found), truths[:0])
    assert not stage.learned(nothing, found, torch.Generator()).has_object.any()


def test_copies_of_small_boxes_lie_off_by_as_many_meters_as_those_of_large_ones() -> None:
    truths = torch.tensor([[-4.0, 1.65, 12.0, 4.0, 1.6, 1.5, 0.3], [4.0, 1.65, 12.0, 1.0, 0.6, 1.8, 0.3]])
    stage = PointRefinement(dataclasses.replace(CONFIG, copies=1024, max_points=256))
    sample = sample_of(surface_points(truths, 200, seed=1), truths)
    wanted = stage.learned(sample, truths[:0], torch.Generator().manual_seed(0)).wanted
    # Of the car's copies and of the person's; what is wanted of sizes and turns is relative to a box.
    car, person = (copies[:, 3:].std(dim=0) for copies in wanted.reshape(2, -1, 7))
    torch.testing.assert_close(person / car, torch.tensor([4.0, 1.6 / 0.6, 1.5 / 1.8, 4.0]), rtol=0.15, atol=0)


def test_the_overlap_is_exact_where_headings_are_equal() -> None:
    truths, moved = boxes(30, seed=8), boxes(30, seed=9)
    moved[:, [0, 2]] = truths[:, [0, 2]] + 0.8 * torch.randn((30, 2), generator=torch.Generator().manual_seed(0))
    moved[:, 6] = truths[:, 6]
    exact = np.diag(box_iou_3d(moved.double().numpy(), truths.double().numpy()))
    np.testing.assert_allclose(_overlap(moved, truths).numpy(), exact, atol=1e-4)
    assert 0.0 < np.median(exact) < 0.9


@pytest.mark.parametrize(
    ("size", "turns"), [((4.0, 1.6), (0, 0, 180, 180, 0)), ((0.8, 0.6), (0, 90, 90, 180, -90))], ids=["car", "person"]
)
def test_a_front_is_any_side_of_a_person_but_an_end_of_a_car(size: tuple[float, float], turns: tuple[int, ...]) -> None:
    boxes_cam = torch.tensor([[2.0, 1.65, 10.0, *size, 1.6, 0.3]]).repeat(5, 1)
    to = boxes_cam[:, 6] + torch.deg2rad(torch.tensor([5.0, 70.0, 110.0, 170.0, -70.0]))
    now = _headed(boxes_cam, torch.stack([torch.cos(to), torch.sin(to)], dim=1))
    wanted = torch.deg2rad(torch.tensor(turns, dtype=torch.float32))
    torch.testing.assert_close(wrap_angle(now[:, 6] - 0.3 - wanted), torch.zeros(5), atol=1e-5, rtol=0)
    # The rectangle stays where it is.
    across = torch.sin(wanted).abs() > 0.5
    torch.testing.assert_close(now[:, 3], torch.where(across, size[1], size[0]))
    torch.testing.assert_close(now[:, 4], torch.where(across, size[0], size[1]))
    assert torch.equal(now[:, :3], boxes_cam[:, :3])


def test_it_learns_where_boxes_stand_and_which_end_is_the_front() -> None:
    torch.manual_seed(0)
    stage = PointRefinement(dataclasses.replace(CONFIG, copies=8))
    optimizer = torch.optim.Adam(stage.parameters(), lr=5e-3)
    for step in range(300):
        truths = boxes(12, seed=step)
        sample = sample_of(surface_points(truths, 60, seed=step), truths)
        outputs = stage.learned(sample, beside(truths, step), torch.Generator().manual_seed(step))
        optimizer.zero_grad()
        outputs.loss().backward()  # type: ignore[no-untyped-call]
        optimizer.step()
    truths = boxes(40, seed=1000)
    sample = sample_of(surface_points(truths, 60, seed=1000), truths)
    noise = torch.tensor([0.3, 0.15, 0.1, 0.08, 0.06, 0.06, 0.08])
    moved = corrected(truths, noise * torch.randn((40, 7), generator=torch.Generator().manual_seed(5)), FLAT)
    moved[::2, 6] += math.pi
    with torch.no_grad():
        now, qualities = stage(sample, moved)
        empty = beside(truths, 7)
        empty = empty[torch.from_numpy(box_iou_3d(empty.double().numpy(), truths.double().numpy()).max(axis=1) == 0.0)]
        _, empty_qualities = stage(sample, empty)

    def overlap(found: torch.Tensor) -> float:
        return float(np.median(np.diag(box_iou_3d(found.double().numpy(), truths.double().numpy()))))

    assert overlap(moved) < 0.7 and overlap(now) > overlap(moved) + 0.08, (overlap(moved), overlap(now))
    assert qualities.median() > empty_qualities.median() + 0.3
    assert (torch.cos(now[:, 6] - truths[:, 6]) > 0.0).float().mean() > 0.75
