"""The environment for Gymnasium, by Gymnasium's own checks and against `cadet.Environment`."""

from __future__ import annotations

import subprocess
import sys
import warnings
from typing import Any

import numpy as np
import pytest

import cadet

SMALL = cadet.Rig(camera=cadet.Camera.kitti().resized(310, 94), lidar=cadet.Lidar.vlp16())
SHORT: dict[str, Any] = {"rig": SMALL, "hz": 5, "length_s": 1.0}


def make(**changes: Any) -> Any:
    pytest.importorskip("gymnasium", reason="needs gymnasium, the extra gym")
    from cadet.simulation.gym import DrivingEnv

    return DrivingEnv(**{**SHORT, **changes})


def test_gymnasiums_own_checks_pass() -> None:
    make()
    import gymnasium
    from gymnasium.utils.env_checker import check_env

    env = gymnasium.make("cadet/Driving-v0", render_mode="rgb_array", **SHORT)
    with warnings.catch_warnings():
        # It would have every action between -1 and 1; meters and seconds are what this one is about.
        warnings.filterwarnings("ignore", message=".*we recommend using a symmetric and normalized space.*")
        check_env(env.unwrapped)
    env.close()


def test_stable_baselines3_own_checks_pass() -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker", reason="needs stable-baselines3")
    with warnings.catch_warnings():
        # Its advice: actions between -1 and 1, and one image alone for its own networks.
        warnings.simplefilter("ignore")
        checker.check_env(make(render_mode="rgb_array"), skip_render_check=False)


@pytest.mark.parametrize("is_vector", [False, True])
def test_gymnasiums_statistics_count_each_episode(is_vector: bool) -> None:
    make()
    import gymnasium
    from gymnasium.wrappers import RecordEpisodeStatistics, vector

    if is_vector:
        envs = gymnasium.make_vec("cadet/Driving-v0", num_envs=2, vectorization_mode="sync", **SHORT)
        env: Any = vector.RecordEpisodeStatistics(envs)
    else:
        env = RecordEpisodeStatistics(gymnasium.make("cadet/Driving-v0", **SHORT))
    _, info = env.reset(seed=4)
    reserved = {"episode", "final_info", "final_obs"}
    assert not {name.removeprefix("_") for name in info} & reserved
    reward = 0.0
    for _ in range(4):
        _, one, _, truncated, info = env.step(np.broadcast_to(np.array([3.0, 0.0], np.float32), env.action_space.shape))
        reward += one
    assert np.all(truncated) and np.all(info["episode"]["l"] == 4)
    np.testing.assert_allclose(info["episode"]["r"], reward, rtol=1e-5)
    # Steps go on through the next episode's reset.
    env.reset() if not is_vector else env.step(env.action_space.sample())
    env.close()


def test_the_drivers_episode_is_the_environments() -> None:
    env = make()
    policy = cadet.ResetPolicy.kitti().with_rig(SMALL).as_sequence(hz=5, length_s=1.0)
    expected = cadet.Environment(policy=policy)
    expected.reset(seed=4)
    seen = [env.reset(seed=4)]
    ends = []
    for _ in range(4):
        observation, reward, terminated, truncated, info = env.step(None)
        seen.append((observation, info))
        ends.append((terminated, truncated))
        assert isinstance(reward, float)
    assert ends == [(False, False)] * 3 + [(False, True)]
    for observation, info in seen:
        frame = expected.step()
        np.testing.assert_array_equal(observation["image"], frame.image)
        count = info["num_points"]
        np.testing.assert_array_equal(observation["points_velo"][:count], frame.points_velo)
        assert not observation["points_velo"][count:].any()
        assert info["labels"] == frame.labels and frame.meta is not None
        assert observation["speed_mps"][0] == np.float32(frame.meta["ego_speed_mps"])
    with pytest.raises(cadet.CadetError, match=r"step: the episode is over: call reset\(\)"):
        env.step(None)


def test_actions_are_obeyed_and_the_reward_is_the_way_forward() -> None:
    env = make(length_s=8.0)
    env.reset(seed=4)
    total_m = 0.0
    speeds = []
    start = env.sample.world_from_ego[:2, 3]
    for _ in range(30):
        observation, reward, *_ = env.step(np.array([3.0, 0.0], np.float32))
        total_m += reward
        speeds.append(float(observation["speed_mps"][0]))
    np.testing.assert_allclose(speeds[-5:], 3.0, atol=0.2)
    # Speed summed over time is the way, and the way is no shorter than the straight line.
    assert total_m == pytest.approx(sum(speeds) / 5, rel=0.1)
    assert total_m >= np.linalg.norm(env.sample.world_from_ego[:2, 3] - start) - 0.1
    assert env.render() is None


def test_seeds_name_episodes_and_resets_go_on_to_the_next() -> None:
    env = make()
    first, _ = env.reset(seed=4)
    _, info = env.reset()
    assert info["episode_number"] == 1
    _, info = env.reset(options={"episode": 7})
    assert info["episode_number"] == 7
    again, info = env.reset(seed=4)
    assert info["episode_number"] == 0
    np.testing.assert_array_equal(first["image"], again["image"])
    mine = make(reward=lambda before, after: after.time_s - before.time_s)
    mine.reset(seed=4)
    assert mine.step(None)[1] == pytest.approx(0.2)


def test_what_makes_no_sense_is_one_clear_line() -> None:
    env = make()
    with pytest.raises(cadet.CadetError, match=r"^step: call reset\(\) first$"):
        env.step(None)
    env.reset(seed=1)
    for action in ([25.0, 0.0], [1.0], "fast", [float("nan"), 0.0], [5.0, -2.5]):
        with pytest.raises(cadet.CadetError, match=r"^step\.action: expected "):
            env.step(action)
    with pytest.raises(cadet.CadetError, match=r"unknown option 'episodes'; known: episode"):
        env.reset(options={"episodes": 1})
    with pytest.raises(cadet.CadetError, match="expected None or 'rgb_array', got 'human'"):
        make(render_mode="human")
    with pytest.raises(cadet.CadetError, match=r"length_s: expected at least 0\.4 s for a step, got 0\.2"):
        make(length_s=0.2)


def test_without_gymnasium_the_module_says_what_it_needs() -> None:
    code = "import sys; sys.modules['gymnasium'] = None; import cadet.simulation.gym"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert done.stderr.splitlines()[-1].endswith(
        "CadetError: cadet.simulation.gym needs gymnasium: pip install 'cadet-sim[gym]'"
    )
