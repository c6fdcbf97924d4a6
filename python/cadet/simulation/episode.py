"""One reset and its samples: draws the world, drives, and looks until something labeled is in view."""

from __future__ import annotations

from collections.abc import Callable
from operator import methodcaller
from typing import Any

from cadet import _cadet
from cadet._util.checks import check_number
from cadet._util.notices import notice
from cadet.errors import CadetError
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Sample, Wanted
from cadet.worlds.policy import EpisodeSpec, ResetPolicy
from cadet.worlds.weather import weather_names


def build_scene(spec: EpisodeSpec) -> _cadet.Scene:
    """Build the core's scene of a draw, settled and ready to sense.

    Raises:
        CadetError: a map that can't be read or driven.
    """
    scene = _cadet.Scene.random(
        spec.seed,
        spec.episode,
        spec.attempt,
        map_name=None if spec.road_map is None else spec.road_map.name,
        map_xodr=None if spec.road_map is None else spec.road_map.xodr,
        weather=spec.weather._to_native(),
        rig=spec.mounted_rig._to_native(),
        config=spec.config.scaled(spec.rig.camera.image_scale)._to_native(),
        assets=None if spec.assets is None else spec.assets._to_native(),
    )
    if spec.road_map is not None:
        notice(scene.map_warnings(), about=spec.road_map)
    for name, asked, placed in scene.shortfalls():
        if name in spec.given:
            line = f"config.{name}: {placed} of {asked} find room (seed {spec.seed}, episode {spec.episode})"
            notice([line], about="shortfall", key=name)
    return scene


def request(rig: Rig, number: int, wanted: Wanted, time_step_s: float | None = None) -> _cadet.Request:
    """Return what the core is to capture.

    Args:
        rig: the sensors.
        number: names the noise.
        wanted: what each sample has.
        time_step_s: the time to the next sample of a sequence.

    Raises:
        CadetError: the rig lacks a sensor that is wanted.
    """
    cameras, lidars = rig.wanted(wanted.sensors)
    return _cadet.Request(
        number,
        maps=wanted.maps or bool(wanted.more_maps),
        normals="normals" in wanted.more_maps,
        scene_flow="scene_flow" in wanted.more_maps,
        optical_flow_s=wanted.optical_flow_s(time_step_s),
        radiance="radiance" in wanted.more_maps,
        pixels=wanted.shares,
        sightings=wanted.labels,
        cameras=cameras,
        lidars=lidars,
    )


def as_command(owner: str, speed_mps: float, lateral_m: float) -> tuple[float, float]:
    """Return what the core takes as a command to the ego.

    Raises:
        CadetError: a number that is out of range.
    """
    limits = _cadet.limits()
    check_number(owner, "speed_mps", speed_mps, *limits["speed_mps"])
    check_number(owner, "lateral_m", lateral_m, *limits["lateral_m"])
    return float(speed_mps), float(lateral_m)


class Episode:
    """The samples of one episode, in order. The same arguments give the same frames.

    Args:
        policy: draws world and rig, and says how far apart views are.
        seed: the dataset's seed.
        episode: the episode's number.
        draw: replaces the policy's own draw.
        wanted: what each sample has; by default all sensors that are mounted, with their maps.
    """

    def __init__(
        self,
        policy: ResetPolicy,
        seed: int,
        episode: int,
        draw: Callable[[int, int, int], EpisodeSpec] | None = None,
        *,
        wanted: Wanted | None = None,
    ) -> None:
        self.policy = policy
        self.seed = seed
        self.number = episode
        self.scene: _cadet.Scene | None = None
        self.command: tuple[float, float] | None = None
        """Speed in m/s and offset to the left of the lane's middle in meters, for the ego to drive from now on; None
        lets its driver drive."""
        self._commanded: tuple[float, float] | None = None
        self._draw = draw or policy.draw
        self._wanted = wanted or Wanted()
        self._attempt = 0
        self._num_empty = 0
        self._num_vain = 0
        self._spec: EpisodeSpec | None = None
        self._moves: list[Callable[[_cadet.Scene], None]] = []
        """What was done to the world since it was built."""
        self._last = 0

    def next_sample(self, number: int) -> Sample:
        """Drive on and return the next view with a labeled object as sample `number` of the episode.

        In a sequence (`ResetPolicy.time_step_s`) this holds for the first sample; the others follow by time.
        The first view of a world is taken where the ego stands. Where its road ends, another world begins; in a
        sequence it stands there, and a warning says so. A view in which nothing has moved since the last one
        (docs/labels.md) is passed over like one without a labeled object, and both count toward the world's redraw.

        Raises:
            CadetError: no world showed a labeled object.
        """
        self._last = number
        while True:
            scene, spec = self._advance(number)
            if self._is_in_sequence(number):
                self._note_road_end(scene, spec)
                taken = scene.capture(self._request(spec, number))
                return Sample(taken, spec.mounted_rig, self._origin(number, spec))
            captured = scene.capture_labeled(self._request(spec, number))
            if captured is None:
                self._num_empty += 1
                if self._num_empty >= self.policy.empty_views_limit:
                    self._redraw()
                continue
            self._num_empty = self._num_vain = 0
            return Sample(captured, spec.mounted_rig, self._origin(number, spec))

    def otherwise(
        self,
        change: Callable[[EpisodeSpec], EpisodeSpec],
        retouch: Callable[[_cadet.Scene], None] = lambda scene: None,
        noise: int = 0,
    ) -> Sample:
        """Return the last sample once more, from a world that is drawn otherwise and driven as far.

        Args:
            change: from the world's draw to another.
            retouch: shows the sensors other actors, once all have been driven.
            noise: names the sensors' random streams; 0 for the sample's own.

        Raises:
            CadetError: there is no last sample, or what is changed is refused.
        """
        if self._spec is None:
            raise CadetError("otherwise: expected a sample before it")
        spec = change(self._spec)
        scene = build_scene(spec)
        for move in self._moves:
            move(scene)
        retouch(scene)
        asked = self._request(spec, self._last + (noise << 32))
        return Sample(scene.capture(asked), spec.mounted_rig, self._origin(self._last, spec))

    def _is_in_sequence(self, number: int) -> bool:
        """Tell whether the sample follows another one by time alone."""
        return self.policy.time_step_s is not None and number > 0

    def _request(self, spec: EpisodeSpec, number: int) -> _cadet.Request:
        return request(spec.mounted_rig, number, self._wanted, self.policy.time_step_s)

    def _origin(self, number: int, spec: EpisodeSpec) -> dict[str, Any]:
        flow_s = self._wanted.optical_flow_s(self.policy.time_step_s)
        return {
            "seed": self.seed,
            "episode": self.number,
            "sample": number,
            "attempt": self._attempt,
            "policy": self.policy.name,
            "district": spec.district,
            **({} if flow_s is None else {"flow_s": flow_s}),
            **({} if spec.weather.name in weather_names() else {"weather_numbers": spec.weather.numbers()}),
        }

    def _advance(self, number: int) -> tuple[_cadet.Scene, EpisodeSpec]:
        if self.scene is None or self._spec is None:
            self._spec = self._draw(self.seed, self.number, self._attempt)
            self.scene = build_scene(self._spec)
            self._commanded = None
            self._moves = []
            return self.scene, self._spec
        if self.command != self._commanded:
            self._move(self.scene, methodcaller("command_ego", self.command))
            self._commanded = self.command
        if self._is_in_sequence(number):
            self._move(self.scene, methodcaller("step", float(self.policy.time_step_s or 0.0)))
        else:
            drive = methodcaller("drive", float(self.policy.distance_m), float(self.policy.blocked_s))
            self._move(self.scene, drive)
            if self.scene.ego_is_at_road_end:
                self._redraw()
                return self._advance(number)
        return self.scene, self._spec

    def _move(self, scene: _cadet.Scene, move: Callable[[_cadet.Scene], None]) -> None:
        move(scene)
        self._moves.append(move)

    def _note_road_end(self, scene: _cadet.Scene, spec: EpisodeSpec) -> None:
        """Warn of an ego that stands at its road's end for the rest of a sequence."""
        if scene.ego_is_at_road_end and spec.road_map is not None:
            line = (
                f"{spec.road_map.name}: the ego came to the end of its road and stands there for the rest of episode "
                f"{self.number} (and of others, which are not said); take shorter sequences, or a map with longer roads"
            )
            notice([line], about=spec.road_map, key="road end")

    def _redraw(self) -> None:
        self.scene = None
        self._num_empty = 0
        self._attempt += 1
        self._num_vain += 1
        if self._num_vain >= self.policy.attempts_limit:
            roads = ", or take a map with longer roads" if self.policy.maps else ""
            raise CadetError(
                f"episode {self.number}: no labeled object in sight in {self._num_vain} worlds of "
                f"{self.policy.empty_views_limit} views each; allow more traffic or labels{roads}"
            )
