from __future__ import annotations

import itertools
import pickle
from dataclasses import asdict, fields, replace
from typing import Any, cast

import numpy as np
import pytest

from cadet import (
    CadetError,
    Camera,
    Environment,
    Frame,
    LabelConfig,
    Lidar,
    PropConfig,
    ResetPolicy,
    Rig,
    Scene,
    SceneConfig,
    weather_names,
)
from cadet.simulation import episode
from cadet.worlds.policy import EpisodeSpec
from cadet.worlds.policy_choice import draw_with
from small_runs import ROAD, SmallPolicy, small_policy

RIG = Rig(camera=Camera.kitti().resized(64, 32), lidar=Lidar.vlp16())
NO_LABELS = LabelConfig(min_points=10**6)


def make(**policy: Any) -> Environment:
    return Environment(policy=replace(small_policy(), **policy), rig=RIG)


def same(a: Frame, b: Frame) -> bool:
    return a.meta == b.meta and a.labels == b.labels and np.array_equal(a.image, b.image)


def test_samples_and_episodes_are_numbered_and_frames_carry_them() -> None:
    env = make(samples_per_episode=3)
    env.reset(seed=1)
    assert (env.episode, env.sample) == (0, 0)
    seen = []
    for _ in range(7):
        frame = env.step()
        assert frame.meta is not None
        assert (frame.meta["episode"], frame.meta["sample"]) == (env.episode, env.sample)
        seen.append((env.episode, env.sample))
    assert seen == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0)]


@pytest.mark.parametrize("policy", ["kitti", "paper"])
@pytest.mark.parametrize(
    "config",
    [
        SceneConfig(num_cars=5),
        # As given as any other number, though it is the default.
        SceneConfig(num_cars=SceneConfig().num_cars),
        SceneConfig(props=PropConfig(clutter=0.25), label=LabelConfig(min_points=7)),
        pickle.loads(pickle.dumps(SceneConfig(num_cars=5))),
        SceneConfig(),
    ],
    ids=str,
)
def test_of_a_configuration_only_what_was_given_takes_the_place_of_the_draw(policy: str, config: SceneConfig) -> None:
    chosen = ResetPolicy.named(policy)
    draw = draw_with(chosen, config)
    for seed in range(50):
        plain, drawn = asdict(chosen.draw(seed, 0).config), asdict(draw(seed, 0, 0).config)
        expected = {**plain, **({"num_cars": config.num_cars} if "num_cars" in config.given else {})}
        if "props" in config.given:
            expected["props"] = {**plain["props"], "clutter": 0.25}
            expected["label"] = {**plain["label"], "min_points": 7}
        assert drawn == expected, seed


def test_a_configuration_of_ones_own_reaches_the_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[EpisodeSpec] = []
    original = episode.build_scene

    def build(spec: EpisodeSpec) -> Any:
        built.append(spec)
        return original(spec)

    monkeypatch.setattr(episode, "build_scene", build)
    policy = replace(ResetPolicy.paper(), samples_per_episode=1, maps=(ROAD,))
    env = Environment(policy=policy, rig=RIG, config=SceneConfig(num_cars=3))
    env.reset(seed=np.int64(1))  # type: ignore[arg-type]
    frames = [env.step() for _ in range(3)]
    assert [(spec.config.num_cars, spec.config.vehicle_shares) for spec in built] == [(3, {"Car": 1.0})] * 3
    assert env.episode == 2 and frames[0].meta is not None
    assert (frames[0].meta["seed"], frames[0].meta["district"]) == (1, built[0].district)
    with pytest.raises(CadetError, match=r"^config: expected a SceneConfig, got 'full'$"):
        Environment(config=cast(Any, "full"))


def test_without_a_seed_one_is_drawn_kept_and_gone_on_with() -> None:
    env = make(samples_per_episode=2)
    assert env.seed is None
    env.reset()
    seed = env.seed
    assert seed is not None and 0 <= seed < 2**32 and f"seed={seed}" in repr(env)
    frames = [env.step() for _ in range(3)]
    assert [frame.meta and (frame.meta["seed"], frame.meta["episode"]) for frame in frames] == [
        (seed, 0),
        (seed, 0),
        (seed, 1),
    ]
    env.reset()
    assert (env.seed, env.episode) == (seed, 2)
    env.reset(episode=7)
    assert (env.seed, env.episode) == (seed, 7)
    env.reset(seed=seed)
    assert env.episode == 0 and same(env.step(), frames[0])
    other = make()
    other.reset()
    assert other.seed != seed


def test_the_same_seed_gives_the_same_frames_and_another_does_not() -> None:
    one, two = make(samples_per_episode=2), make(samples_per_episode=2)
    one.reset(seed=4)
    first = [one.step() for _ in range(5)]
    one.reset(seed=4)
    two.reset(seed=4)
    assert all(same(a, one.step()) and same(a, two.step()) for a in first)
    two.reset(seed=5)
    assert not same(first[0], two.step())


def test_a_reset_to_an_episode_skips_those_before() -> None:
    one, two = make(samples_per_episode=2), make(samples_per_episode=2)
    one.reset(seed=4)
    two.reset(seed=4, episode=1)
    frames = [one.step() for _ in range(3)]
    assert same(frames[2], two.step())


def test_only_views_with_an_object_come_out_and_the_ego_drives_on_past_the_others() -> None:
    # A label takes more points than most views offer.
    env = make(distance_m=10.0, label=LabelConfig(min_points=60), samples_per_episode=20, attempts_limit=50)
    env.reset(seed=3)
    frames = [env.step() for _ in range(8)]
    assert all(any(not label.is_dont_care for label in frame.labels) for frame in frames)
    metas = [frame.meta for frame in frames if frame.meta is not None]
    assert [meta["sample"] for meta in metas] == list(range(8))
    places = [(meta["attempt"], np.array(meta["world_from_ego"])[:2, 3]) for meta in metas]
    driven_m = [
        float(np.linalg.norm(here - there))
        for (attempt, there), (same, here) in itertools.pairwise(places)
        if attempt == same
    ]
    # Some views were driven past, and samples count on.
    assert driven_m and max(driven_m) > 15.0
    assert all(abs(way_m / 10.0 - round(way_m / 10.0)) < 0.1 for way_m in driven_m), driven_m


class Blank(SmallPolicy):
    """A policy whose first two worlds of an episode show nothing that gets a label."""

    def draw(self, seed: int, episode: int, attempt: int = 0) -> EpisodeSpec:
        spec = super().draw(seed, episode, attempt)
        return replace(spec, config=replace(spec.config, label=NO_LABELS)) if attempt < 2 else spec


def test_after_empty_views_the_world_is_redrawn_inside_the_episode() -> None:
    small = small_policy()
    policy = Blank(**{f.name: getattr(small, f.name) for f in fields(small)})
    env = Environment(policy=replace(policy, empty_views_limit=3), rig=RIG)
    env.reset(seed=3)
    frame = env.step()
    assert frame.meta is not None
    assert (frame.meta["episode"], frame.meta["sample"], frame.meta["attempt"]) == (0, 0, 2)


def test_an_episode_without_objects_ends_in_an_error() -> None:
    env = make(empty_views_limit=3, attempts_limit=2, label=NO_LABELS)
    env.reset(seed=1)
    with pytest.raises(CadetError) as caught:
        env.step()
    assert str(caught.value) == (
        "episode 0: no labeled object in sight in 2 worlds of 3 views each; allow more traffic or labels, "
        "or take a map with longer roads"
    )


def test_a_random_scene_is_the_first_sample() -> None:
    env = make()
    for seed in range(4):
        env.reset(seed=seed)
        scene = Scene.random(seed=seed, rig=RIG, policy=small_policy())
        assert same(env.step(), scene.capture())


@pytest.mark.parametrize(
    ("use", "message"),
    [
        (lambda: make().step(), "step: call reset() first"),
        (lambda: make().reset(seed=-1), "seed: expected a whole number from 0 to 2**63 - 1, got -1"),
        (lambda: make().reset(seed=cast(int, "1")), "seed: expected a whole number from 0 to 2**63 - 1, got '1'"),
        (
            lambda: make().reset(seed=0, episode=cast(int, 1.5)),
            "reset.episode: expected a whole number from 0 to 1000000000, got 1.5",
        ),
        (
            lambda: Environment(policy="nuscenes"),
            "unknown policy 'nuscenes'; known: kitti, paper, or the path of a file that ends in .toml",
        ),
        (
            lambda: Environment(policy=cast(ResetPolicy, 3)),
            "policy: expected a ResetPolicy or one of kitti, paper, got 3",
        ),
        (lambda: Environment(weather="hail"), f"unknown weather 'hail'; known: {', '.join(weather_names())}"),
        (lambda: Environment(rig=cast(Rig, "kitti")), "rig: expected a Rig, got 'kitti'"),
    ],
)
def test_misuse_is_refused_in_one_line(use: Any, message: str) -> None:
    with pytest.raises(CadetError) as caught:
        use()
    assert str(caught.value) == message
