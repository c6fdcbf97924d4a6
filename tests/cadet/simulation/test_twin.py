"""Twins: what is changed changes, and nothing else by a bit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

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


def test_a_change_that_is_none_is_refused() -> None:
    with pytest.raises(CadetError, match=r"twin\.change: expected a function that returns a cadet\.EpisodeSpec, got"):
        of(lambda spec: spec.weather)  # type: ignore[arg-type, return-value]
    with pytest.raises(CadetError, match=r"twin\.frame: expected a whole number from 0"):
        twin(lambda spec: spec, frame=-1)
