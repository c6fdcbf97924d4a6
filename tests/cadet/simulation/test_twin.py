"""Twins: what is changed changes, and nothing else by a bit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet import CadetError, EpisodeSpec, Frame, Lidar, Weather, twin
from small_runs import small_policy

POLICY = small_policy()
FRAME = 2


def of(change: Callable[[EpisodeSpec], EpisodeSpec], *, is_sequence: bool = False) -> tuple[Frame, Frame]:
    policy = replace(POLICY, time_step_s=0.5) if is_sequence else POLICY
    return twin(change, policy=policy, seed=3, frame=FRAME)


def alike(pair: tuple[Frame, Frame]) -> set[str]:
    """Name what of two frames is the same to the bit."""
    first, second = pair
    found = {name for name in ("image", "depth", "instance", "points_velo") if _is_same(first, second, name)}
    lines = [[label.to_line() for label in frame.labels] for frame in pair]
    return found | ({"labels"} if lines[0] == lines[1] else set())


def _is_same(first: Frame, second: Frame, name: str) -> bool:
    return np.array_equal(getattr(first, name), getattr(second, name))


def box_of(frame: Frame, actor_id: int) -> NDArray[np.float64]:
    """The location and rotation_y of a labeled object."""
    (found,) = [item for item in objects_of(frame) if item["actor_id"] == actor_id]
    return np.array([*found["location_cam"], found["rotation_y"]])


ALL = {"image", "depth", "instance", "points_velo", "labels"}
CHANGES: dict[str, tuple[Callable[[EpisodeSpec], EpisodeSpec], set[str]]] = {
    "nothing": (lambda spec: spec, set()),
    "the weather": (lambda spec: replace(spec, weather=Weather.preset("snow")), {"image", "points_velo"}),
    "the sun": (lambda spec: replace(spec, config=replace(spec.config, sun_elevation_deg=10.0)), {"image"}),
    "boxes": (
        lambda spec: replace(spec, config=replace(spec.config, label=replace(spec.config.label, boxes="exact"))),
        {"labels"},
    ),
    "the LIDAR": (lambda spec: replace(spec, rig=spec.rig.with_lidar(Lidar("os1_64"))), {"points_velo"}),
}


@pytest.mark.parametrize("name", CHANGES)
def test_one_cause_changes_what_it_should(name: str) -> None:
    change, changed = CHANGES[name]
    pair = of(change)
    # Boxes as annotators draw them depend on the returns, too.
    assert changed <= ALL - alike(pair) <= changed | ({"labels"} if name == "the LIDAR" else set())
    assert [label.type for label in pair[0].labels if not label.is_dont_care]


@pytest.mark.parametrize("is_sequence", [False, True])
def test_the_first_of_a_pair_is_the_datasets(is_sequence: bool) -> None:
    from cadet import Environment

    first, _ = of(lambda spec: spec, is_sequence=is_sequence)
    environment = Environment(policy=replace(POLICY, time_step_s=0.5) if is_sequence else POLICY)
    environment.reset(seed=3)
    frames = [environment.step() for _ in range(FRAME + 1)]
    assert alike((frames[FRAME], first)) == ALL
    assert alike((frames[FRAME - 1], first)) == set()


def test_agents_move_alike_in_another_weather() -> None:
    first, second = of(lambda spec: replace(spec, weather=Weather.preset("clear_sunset")), is_sequence=True)
    assert first.meta is not None and second.meta is not None
    for name in ("time_s", "world_from_ego", "objects"):
        assert first.meta[name] == second.meta[name]


def objects_of(frame: Frame) -> list[dict[str, Any]]:
    assert frame.meta is not None
    objects: list[dict[str, Any]] = frame.meta["objects"]
    return objects


def first_labeled() -> tuple[Frame, dict[str, Any]]:
    """The frame, and what is known of its largest labeled object."""
    first, _ = of(lambda spec: spec)
    return first, max(objects_of(first), key=lambda item: int((first.instance == item["actor_id"]).sum()))


def test_an_actor_is_not_there_and_others_stay_where_they_are() -> None:
    first, gone = first_labeled()
    _, second = twin(without=[gone["actor_id"]], policy=POLICY, seed=3, frame=FRAME)
    assert first.instance is not None and second.instance is not None and second.meta is not None
    assert (first.instance == gone["actor_id"]).sum() > 100 and not (second.instance == gone["actor_id"]).any()
    # Where it did not stand, surfaces are what they were, and every return that has not met it is there to the bit.
    assert first.depth is not None and second.depth is not None
    elsewhere = first.instance != gone["actor_id"]
    np.testing.assert_array_equal(second.instance[elsewhere], first.instance[elsewhere])
    np.testing.assert_array_equal(second.depth[elsewhere], first.depth[elsewhere])
    rows = [set(map(bytes, points.view("V16").ravel())) for points in (first.points_velo, second.points_velo)]
    assert 0 < len(rows[0] - rows[1]) < 0.2 * len(rows[0])
    places = [{item["actor_id"]: item["location_cam"] for item in objects_of(frame)} for frame in (first, second)]
    assert gone["actor_id"] not in places[1]
    assert all(places[1][actor_id] == place for actor_id, place in places[0].items() if actor_id in places[1])


def test_an_actor_is_moved_in_its_own_frame() -> None:
    first, chosen = first_labeled()
    actor_id = chosen["actor_id"]
    _, second = twin(moved={actor_id: (0.0, 0.0, 90.0)}, policy=POLICY, seed=3, frame=FRAME)
    _, third = twin(moved={actor_id: (0.6, 0.8, 0.0)}, policy=POLICY, seed=3, frame=FRAME)
    before, turned, shifted = (box_of(frame, actor_id) for frame in (first, second, third))
    assert (turned[3] - before[3]) % math.tau == pytest.approx(math.tau * 3 / 4, abs=0.02)
    assert math.dist(shifted[:3], before[:3]) == pytest.approx(1.0, abs=0.02)
    # KITTI's rotation_y turns to the right from the camera's x axis: forward is (cos, -sin) in x and z.
    ahead = np.array([math.cos(before[3]), -math.sin(before[3])])
    assert (shifted[[0, 2]] - before[[0, 2]]) @ ahead == pytest.approx(0.6, abs=0.02)


def test_other_noise_changes_what_sensors_add_and_nothing_else() -> None:
    first, second = twin(noise=1, policy=POLICY, seed=3, frame=FRAME)
    assert ALL - alike((first, second)) >= {"image", "points_velo"}
    assert {"depth", "instance"} <= alike((first, second))
    assert len(second.points_velo) == pytest.approx(len(first.points_velo), rel=0.02)
    _, again = twin(noise=1, policy=POLICY, seed=3, frame=FRAME)
    assert alike((second, again)) == ALL


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"without": [10_000_000]}, "no actor but the ego has the id 10000000"),
        ({"without": [0]}, r"twin\.actor id: expected a whole number from 1"),
        ({"moved": {1: (1.0, 2.0)}}, r"twin\.moved: expected \(forward m, left m, degrees\), got"),
        ({"moved": {1: (1e9, 0.0, 0.0)}}, r"twin\.moved\.forward: expected a number from -250 to 250"),
        ({"noise": -1}, r"twin\.noise: expected a whole number from 0"),
    ],
)
def test_what_cannot_be_changed_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(CadetError, match=message):
        twin(policy=POLICY, seed=3, frame=0, **given)


def test_a_change_that_is_none_is_refused() -> None:
    with pytest.raises(CadetError, match=r"twin\.change: expected a function that returns a cadet\.EpisodeSpec, got"):
        of(lambda spec: spec.weather)  # type: ignore[arg-type, return-value]
    with pytest.raises(CadetError, match=r"twin\.frame: expected a whole number from 0"):
        twin(lambda spec: spec, frame=-1)
