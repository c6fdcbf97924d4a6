"""An environment for Gymnasium: drive through generated streets by speed and lateral offset, see what the rig sees.

Importing this module needs Gymnasium (`pip install 'cadet-sim[gym]'`) and registers "cadet/Driving-v0".
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.checks import check_number, is_one_of, shown
from cadet.errors import CadetError
from cadet.formats.kitti import Frame
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Sample
from cadet.simulation.environment import Environment
from cadet.worlds.assets import Assets
from cadet.worlds.config import SceneConfig
from cadet.worlds.policy import ResetPolicy
from cadet.worlds.policy_choice import choose_policy
from cadet.worlds.road_map import RoadMap
from cadet.worlds.weather import Weather

try:
    import gymnasium
    from gymnasium import spaces
except ModuleNotFoundError as error:
    if error.name != "gymnasium":
        raise
    raise CadetError("cadet.simulation.gym needs gymnasium: pip install 'cadet-sim[gym]'") from None

Observation: TypeAlias = dict[str, NDArray[Any]]
Reward: TypeAlias = Callable[[Sample, Sample], float]

_MARGIN_M: Final = 10.0
"""Noise and the lasers' places may take a point past the LIDAR's range."""
_RENDER_MODES: Final = ("rgb_array",)


def meters_forward(before: Sample, after: Sample) -> float:
    """Return how far the ego has gone between two samples, in the direction in which it stood before."""
    moved = after.world_from_ego[:3, 3] - before.world_from_ego[:3, 3]
    return float(moved @ before.world_from_ego[:3, 0])


class DrivingEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """Episodes of some seconds in generated streets.

    An action is (target speed in m/s, offset to the left of the lane's middle in m), reached by the pedals and the
    steering of a car and held whatever others, signals, and bends are; None lets the driver drive. The way through
    junctions is drawn. Nothing ends an episode early: `terminated` is always false, and `truncated` is true with the
    last sample. A task's own end is a wrapper's to decide, who finds all facts in `sample`.

    Observations: "image" (H, W, 3) uint8 RGB; "points_velo" (N, 4) float32 [x, y, z, intensity] in the velo frame, one
    row for each ray of the LIDAR, those without a return 0 and last; "speed_mps" (1,) float32. `info` has "time_s",
    "seed", "episode_number", "sample", "map", "weather", "num_points", and "labels", the frame's `cadet.Label`s.

    Args:
        hz: steps a second; it divides the 60 steps of physics.
        length_s: length of an episode in seconds.
        policy: how worlds are drawn, as in `cadet.Environment`.
        rig: the sensors of all episodes; the policy's first if None.
        map: an OpenDRIVE file, or one that was read; the policy's maps, or generated suburbs, if None.
        weather: a preset, or numbers; drawn if None.
        config: how full every scene is; what it was not given is drawn.
        assets: the user's own meshes.
        max_speed_mps: the action space's greatest speed.
        max_lateral_m: the action space's greatest offset to either side.
        reward: what a step is worth, from the samples before and after it; `meters_forward` by default.
        render_mode: "rgb_array", or None.

    Raises:
        CadetError: as `cadet.Environment`, or a rate, length, limit, or render mode that is out of range.
    """

    metadata: dict[str, Any] = {"render_modes": list(_RENDER_MODES)}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(
        self,
        *,
        hz: float = 10.0,
        length_s: float = 20.0,
        policy: ResetPolicy | str | None = None,
        rig: Rig | None = None,
        map: RoadMap | str | Path | None = None,
        weather: Weather | str | None = None,
        config: SceneConfig | None = None,
        assets: Assets | str | Path | None = None,
        max_speed_mps: float = 20.0,
        max_lateral_m: float = 2.0,
        reward: Reward = meters_forward,
        render_mode: str | None = None,
    ) -> None:
        limits = _cadet.limits()
        check_number("DrivingEnv", "max_speed_mps", max_speed_mps, 0.1, limits["speed_mps"][1])
        check_number("DrivingEnv", "max_lateral_m", max_lateral_m, 0.0, limits["lateral_m"][1])
        if render_mode is not None and not is_one_of(render_mode, _RENDER_MODES):
            raise CadetError(f"DrivingEnv.render_mode: expected None or 'rgb_array', got {shown(render_mode)}")
        chosen = choose_policy(policy, map=map, weather=weather, rig=rig, assets=assets)
        self.rig = chosen.rigs[0][0] if rig is None else rig
        self._policy = chosen.with_rig(self.rig).as_sequence(hz=hz, length_s=length_s)
        if self._policy.samples_per_episode < 2:
            raise CadetError(f"DrivingEnv.length_s: expected at least {2 / hz:g} s for a step, got {length_s:g}")
        self._environment = Environment(policy=self._policy, config=config, sensors=())
        self._reward = reward
        self._num_rays = len(self.rig.lidar.rays()[0])
        self._frame: Frame | None = None
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": hz}
        least, most = [0.0, -max_lateral_m], [max_speed_mps, max_lateral_m]
        self.action_space = self._actions = spaces.Box(np.array(least, np.float32), np.array(most, np.float32))
        self.observation_space = self._observations()

    @property
    def sample(self) -> Sample:
        """What was captured last: ego, agents, image, and scan.

        Raises:
            CadetError: `reset` was not called.
        """
        sample = self._now().sample
        assert sample is not None
        return sample

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: starts its episode 0: the first view is that of `cadet gen --hz 2 --seed` with the same policy and
                rig. None goes on to the next episode of the seed, which is drawn if none was given yet.
            options: {"episode": N} names the episode; none else is known.

        Raises:
            CadetError: a bad seed or an unknown option.
        """
        super().reset(seed=seed)
        episode = None
        for name, value in (options or {}).items():
            if name != "episode":
                raise CadetError(f"reset.options: unknown option {shown(name)}; known: episode")
            episode = value
        self._environment.reset(seed=seed, episode=episode)
        self._frame = self._environment.step()
        return self._observe(), self._info()

    def step(self, action: NDArray[np.float32] | None) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive on for a step.

        Args:
            action: (2,) speed in m/s and offset in m, within the action space; None for the driver.

        Returns:
            Observation, reward, terminated (never), truncated (at the episode's last sample), and info.

        Raises:
            CadetError: `reset` was not called, the episode is over, or an action outside the action space.
        """
        before = self.sample
        if self._is_over():
            raise CadetError("step: the episode is over: call reset()")
        if action is None:
            self._frame = self._environment.step()
        else:
            speed_mps, lateral_m = self._checked(action)
            self._frame = self._environment.step(speed_mps=speed_mps, lateral_m=lateral_m)
        reward = float(self._reward(before, self.sample))
        return self._observe(), reward, False, self._is_over(), self._info()

    def render(self) -> NDArray[np.uint8] | None:
        """Return the camera's image, (H, W, 3) uint8, with render mode "rgb_array"; else None."""
        return self._now().image.copy() if self.render_mode == "rgb_array" else None

    def _observations(self) -> spaces.Space[Observation]:
        camera, lidar = self.rig.camera, self.rig.lidar
        reach_m = lidar.range_m()[1] + _MARGIN_M
        low, high = (
            np.tile(np.array(row, np.float32), (self._num_rays, 1))
            for row in ([-reach_m] * 3 + [0], [reach_m] * 3 + [1])
        )
        found = spaces.Dict(
            {
                "image": spaces.Box(0, 255, (camera.height, camera.width, 3), np.uint8),
                "points_velo": spaces.Box(low, high, dtype=np.float32),
                "speed_mps": spaces.Box(0.0, _cadet.limits()["speed_mps"][1], (1,), np.float32),
            }
        )
        return cast("spaces.Space[Observation]", found)

    def _observe(self) -> Observation:
        frame = self._now()
        points = np.zeros((self._num_rays, 4), np.float32)
        points[: len(frame.points_velo)] = frame.points_velo
        speed_mps = np.array([self.sample.ego_speed_mps], np.float32)
        return {"image": frame.image, "points_velo": points, "speed_mps": speed_mps}

    def _info(self) -> dict[str, Any]:
        frame, sample = self._now(), self.sample
        return {
            "time_s": sample.time_s,
            "seed": self._environment.seed,
            "episode_number": self._environment.episode,
            "sample": self._environment.sample,
            "map": sample.map,
            "weather": sample.weather,
            "num_points": len(frame.points_velo),
            "labels": frame.labels,
        }

    def _now(self) -> Frame:
        if self._frame is None:
            raise CadetError("step: call reset() first")
        return self._frame

    def _is_over(self) -> bool:
        return self._environment.sample == self._policy.samples_per_episode - 1

    def _checked(self, action: object) -> tuple[float, float]:
        try:
            values = np.asarray(action, np.float32)
        except (TypeError, ValueError):
            raise CadetError(f"step.action: expected two numbers or None, got {shown(action)}") from None
        if not self._actions.contains(values):
            speed_mps, lateral_m = self._actions.high.tolist()
            expected = f"a speed from 0 to {speed_mps:g} m/s and an offset of at most {lateral_m:g} m"
            raise CadetError(f"step.action: expected {expected}, got {shown(action)}")
        speed_mps, lateral_m = values.tolist()
        return speed_mps, lateral_m


gymnasium.register("cadet/Driving-v0", entry_point="cadet.simulation.gym:DrivingEnv")
