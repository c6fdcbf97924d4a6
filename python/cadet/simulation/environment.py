"""Frame after frame from newly drawn streets: what `cadet-gen` writes, in memory."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from cadet._util.checks import MAX_EPISODE, as_seed, check_number, fresh_seed
from cadet._util.summary import summary
from cadet.errors import CadetError
from cadet.formats.kitti import Frame, frame_from_sample
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Wanted
from cadet.simulation.episode import Episode, as_command
from cadet.worlds.assets import Assets
from cadet.worlds.config import SceneConfig
from cadet.worlds.policy import ResetPolicy
from cadet.worlds.policy_choice import choose_policy, draw_with
from cadet.worlds.road_map import RoadMap
from cadet.worlds.weather import Weather


class Environment:
    """Drives through generated worlds and captures a frame at set distances.

    The n-th frame after `reset(seed=s)` is the n-th frame of `cadet-gen --seed s` with the same policy and rig.

    Args:
        policy: how worlds are drawn, or the name of a preset, "kitti" or "paper"; `ResetPolicy.kitti()` if None.
        rig: the sensors; the policy's if None.
        map: an OpenDRIVE file, or one that was read; the policy's maps, or suburbs that are generated, if None.
        weather: a preset of `weather_names()`, or numbers; drawn if None.
        config: how full every scene is, and what gets a label; what it was not given is drawn.
        assets: the user's own meshes, or their folder; the policy's if None.
        sensors: names of sensors besides the first camera and LIDAR; None for all that the rig has in `more`.
        more_maps: as for `Scene.capture`; the optical flow leads to the next frame of a sequence, or over 0.1 s.

    Raises:
        CadetError: an unknown policy, weather, or name of `more_maps`, no rig or configuration, a map that can't be
            read, or bad assets.
        MissingFileError: there is no such map, or no such assets.
    """

    def __init__(
        self,
        *,
        policy: ResetPolicy | str | None = None,
        rig: Rig | None = None,
        map: RoadMap | str | Path | None = None,
        weather: Weather | str | None = None,
        config: SceneConfig | None = None,
        assets: Assets | str | Path | None = None,
        sensors: Iterable[str] | None = None,
        more_maps: Iterable[str] = (),
    ) -> None:
        self.policy = choose_policy(policy, map=map, weather=weather, rig=rig, assets=assets)
        self._draw = draw_with(self.policy, config)
        self._wanted = Wanted.all_of(sensors, more_maps)
        for rig_of_policy, _ in self.policy.rigs:
            rig_of_policy.wanted(self._wanted.sensors)
        self._current: Episode | None = None
        self._next_sample = 0

    def __repr__(self) -> str:
        return summary(self, policy=self.policy.name, seed=self.seed, episode=self.episode, sample=self.sample)

    def reset(self, *, seed: int | None = None, episode: int | None = None) -> None:
        """Start an episode, as Gymnasium's environments do: give a seed at first, and none from then on.

        Args:
            seed: names every random draw that follows. None keeps the seed of before; the first time it draws a fresh
                one, which `seed` then tells.
            episode: the episode to begin with; if None, the first one of a seed that is given or drawn, and the next
                one of a seed that is kept.

        Raises:
            CadetError: an invalid seed, or an episode that is not a whole number from 0 to `MAX_EPISODE`.
        """
        before = self._current
        if seed is None and before is not None:
            seed, next_episode = before.seed, before.number + 1
        else:
            seed, next_episode = fresh_seed() if seed is None else as_seed(seed), 0
        episode = next_episode if episode is None else episode
        check_number("reset", "episode", episode, 0, MAX_EPISODE, whole=True)
        self._current = Episode(self.policy, seed, int(episode), self._draw, wanted=self._wanted)
        self._next_sample = 0

    def step(self, *, speed_mps: float | None = None, lateral_m: float = 0.0) -> Frame:
        """Drive the policy's distance or time and return what the rig sees; the episode's end leads into the next one.

        The first frame of an episode shows where the ego stands.

        Args:
            speed_mps: speed that the ego reaches and keeps, however others, signals, and bends are; its driver drives
                if None.
            lateral_m: meters to the left of the lane's middle that it keeps then, reached at 1 m/s.

        Raises:
            CadetError: `reset` was not called, no world of the episode showed a labeled object, or a command that is
                out of range or where there is no lane.
        """
        command = None if speed_mps is None else as_command("step", speed_mps, lateral_m)
        if self._current is None:
            raise CadetError("step: call reset() first")
        if self._next_sample == self.policy.samples_per_episode:
            self.reset()
        self._current.command = command
        sample = self._current.next_sample(self._next_sample)
        self._next_sample += 1
        return frame_from_sample(sample)

    @property
    def seed(self) -> int | None:
        """The seed of the frames, given or drawn; None before the first reset."""
        return None if self._current is None else self._current.seed

    @property
    def episode(self) -> int:
        """The episode of the frame that `step` returned last; after a reset, the one to come."""
        return 0 if self._current is None else self._current.number

    @property
    def sample(self) -> int:
        """The sample within the episode of the frame that `step` returned last; 0 after a reset."""
        return max(self._next_sample - 1, 0)
