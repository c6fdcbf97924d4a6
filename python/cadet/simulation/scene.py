"""Scenes: a town, its traffic and a rig, to step, to look at and to cast rays into."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.arrays import as_array
from cadet._util.checks import as_seed, check_flag, check_kind, check_number, check_text, fresh_seed, is_one_of, shown
from cadet._util.notices import notice
from cadet._util.summary import summary
from cadet.errors import CadetError
from cadet.formats.kitti import Frame, frame_from_sample
from cadet.sensors.lidar import Lidar
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Agent, Sample, Scan, Wanted, agent_from_native, scan_from_native
from cadet.simulation.episode import Episode, as_command, request
from cadet.worlds.assets import Assets, as_assets
from cadet.worlds.config import SceneConfig
from cadet.worlds.policy import ResetPolicy
from cadet.worlds.policy_choice import choose_policy, draw_with
from cadet.worlds.road_map import RoadMap, as_road_map
from cadet.worlds.weather import Weather, as_weather

_MAX_PLACE_M = 1e6


class RayHits(NamedTuple):
    """What rays hit first; unpacks into its three arrays.

    Attributes:
        range_m: (N,) float64 along the ray of unit direction; inf for a miss.
        actor_id: (N,) int32, as in `Frame.instance`; -1 for a miss.
        normal_world: (N, 3) float64 unit normals facing the ray; NaN for a miss.
    """

    range_m: NDArray[np.float64]
    actor_id: NDArray[np.int32]
    normal_world: NDArray[np.float64]

    def __repr__(self) -> str:
        hits = int((self.actor_id >= 0).sum())
        return summary(self, f"{hits} hits", range_m=self.range_m, normal_world=self.normal_world)


class Scene:
    """A town with traffic and sensors. Make one with `Scene.random` or `Scene.empty`.

    Frames: world is x east, y north, z up; velo is x forward, y left, z up; cam is the rectified camera 0, x right,
    y down, z forward. Meters, radians and seconds throughout.
    """

    def __init__(self, native: _cadet.Scene, rig: Rig, first: Sample | None = None) -> None:
        """Wrap the core's scene; users call `random` or `empty`."""
        self._native = native
        self._rig = rig
        self._first = first
        # What a capture of the very first instant says of itself beyond what the core knows.
        self._origin = {} if first is None else first.origin
        self._num_moves = 0
        self._seed: int | None = self._origin.get("seed")

    @classmethod
    def random(
        cls,
        *,
        seed: int | None = None,
        map: RoadMap | str | Path | None = None,
        weather: Weather | str | None = None,
        rig: Rig | None = None,
        config: SceneConfig | None = None,
        policy: ResetPolicy | str | None = None,
        assets: Assets | str | Path | None = None,
    ) -> Scene:
        """Draw a suburb with traffic in which at least one labeled object is in view.

        `Scene.random(seed=s)` is episode 0, sample 0 of `cadet-gen --seed s`.

        Args:
            seed: names every random draw; None draws a fresh one, which `seed` and the metadata then tell.
            map: an OpenDRIVE file, or one that was read; a suburb is generated if None and the policy has no maps.
            weather: a preset of `weather_names()`, or numbers; drawn if None.
            rig: the sensors; the policy's if None.
            config: how full the scene is; what it was not given is drawn.
            policy: draws what is not given, or the name of a preset, "kitti" or "paper"; `ResetPolicy.kitti()` if None.
            assets: the user's own meshes, or their folder; the policy's if None.

        Raises:
            CadetError: a map that can't be read or driven, an unknown weather, bad assets, or no labeled object to be
                found.
            MissingFileError: there is no such map, or no such assets.
        """
        chosen = choose_policy(policy, map=map, weather=weather, rig=rig, assets=assets)
        episode = Episode(chosen, fresh_seed() if seed is None else as_seed(seed), 0, draw_with(chosen, config))
        first = episode.next_sample(0)
        assert episode.scene is not None
        return cls(episode.scene, first.rig, first)

    @classmethod
    def empty(
        cls,
        *,
        map: RoadMap | str | Path | None = None,
        weather: Weather | str = "clear_noon",
        rig: Rig | None = None,
        config: SceneConfig | None = None,
        assets: Assets | str | Path | None = None,
    ) -> Scene:
        """Make a scene without traffic to script, the ego on a lane of the map.

        Args:
            map: an OpenDRIVE file, or one that was read; None is a level square of 400 m that looks like a road of two
                lanes along x between lawns. The ego stands at the origin, in the right one; since nothing can be driven
                along there, `command_ego` needs a map.
            weather: a preset of `weather_names()`, or numbers.
            rig: the sensors; `Rig.kitti()` if None.
            config: its `label` says what gets a label.
            assets: the user's own meshes, or their folder, for `add`.

        Raises:
            CadetError: a map that can't be read or driven, an unknown weather, or bad assets.
            MissingFileError: there is no such map, or no such assets.
        """
        rig = Rig.kitti() if rig is None else rig
        check_kind("", "rig", rig, Rig)
        config = SceneConfig() if config is None else config
        check_kind("", "config", config, SceneConfig)
        own, given = as_assets(assets), as_weather(weather)
        road_map = None if map is None else as_road_map(map)
        native = _cadet.Scene.empty(
            map_name=None if road_map is None else road_map.name,
            map_xodr=None if road_map is None else road_map.xodr,
            weather=given._to_native(),
            rig=rig._to_native(),
            config=given._sun_of(config).scaled(rig.camera.image_scale)._to_native(),
            assets=None if own is None else own._to_native(),
        )
        if road_map is not None:
            notice(native.map_warnings(), about=road_map)
        return cls(native, rig)

    def __repr__(self) -> str:
        return summary(
            self, seed=self.seed, time_s=self.time_s, num_actors=self.num_actors, num_triangles=self.num_triangles
        )

    @property
    def seed(self) -> int | None:
        """What `random` was given or has drawn; None for an empty scene."""
        return self._seed

    @property
    def time_s(self) -> float:
        """Seconds of physics since the scene was made."""
        return self._native.time_s

    @property
    def num_triangles(self) -> int:
        """Triangles that the sensors see, the ego's excluded."""
        return self._native.num_triangles

    @property
    def num_actors(self) -> int:
        """Actors besides the ego, parked ones too."""
        return self._native.num_actors

    @property
    def agents(self) -> tuple[Agent, ...]:
        """Every agent around the ego now, parked vehicles too, by rising id; no sensor is asked."""
        return tuple(agent_from_native(native) for native in self._native.agents)

    @property
    def ego_brakes_for(self) -> tuple[str, int | None] | None:
        """What the ego's driver brakes or waits for, and whose id: an agent's `brakes_for` and `brakes_for_id`."""
        return self._native.ego_brakes_for

    def add(
        self,
        kind: str,
        *,
        x_m: float | None = None,
        y_m: float | None = None,
        yaw_rad: float | None = None,
        model_seed: int = 0,
        model: str | None = None,
        speed_mps: float | None = None,
        path: Sequence[Sequence[float]] | NDArray[np.float64] | None = None,
        overlap: str = "refuse",
    ) -> int:
        """Put an actor on the ground: one that stands at a place, goes straight on from there, or follows a path.

        A moving actor ignores all others; cars brake for it, and people walk around it.

        Args:
            kind: "car", "van", "truck", "tram" (one car with a cab at both ends), "misc" (a trailer or a motorbike),
                "pedestrian", "person_sitting" (who sits at a chair's height and does not move), or "cyclist", in any
                letter case; with `model` that mesh's class.
            x_m: world frame: the middle of its box. Left out with a path, as are the next two.
            y_m: world frame.
            yaw_rad: counter-clockwise from east; 0 if None: along the road of an empty scene without a map.
            model_seed: draws its shape and color, for a person who moves one that walks.
            model: the name of one of the scene's own meshes (`assets`), in place of a drawn shape. It is rigid: people
                glide.
            speed_mps: along `yaw_rad`, held to the edge of the ground: at most 70, 12 for a person, and 20 for a
                cyclist.
            path: rows of (t, x, y), t in seconds from now and rising. Between two of them it goes straight at a
                constant speed, heading where it goes; before the first and after the last it stands.
            overlap: "refuse" a place where another actor or the ego stands, or "allow" it; where it starts is what
                counts, not its way.

        Returns:
            Its actor id, as in `Frame.instance`.

        Raises:
            CadetError: an unknown kind or model, a kind without a shape or not the model's, a number that is not
                finite or out of range, a place off the ground or where another stands, or a path that makes no sense.
        """
        check_text("add", "kind", kind)
        if model is not None:
            check_text("add", "model", model)
        check_number("add", "model_seed", model_seed, 0, 2**63 - 1, whole=True)
        place, points = None, None
        if path is None:
            if x_m is None or y_m is None:
                raise CadetError("add: expected x_m and y_m, where the actor stands, or a path")
            place = _place("add", x_m, y_m, 0.0 if yaw_rad is None else yaw_rad)
        elif any(value is not None for value in (x_m, y_m, yaw_rad, speed_mps)):
            raise CadetError(
                "add.path: it says where the actor goes and how fast; leave out x_m, y_m, yaw_rad and speed_mps"
            )
        else:
            points = _vectors("path", path)
        if speed_mps is not None:
            check_number("add", "speed_mps", speed_mps, *_cadet.limits()["speed_mps"])
            speed_mps = float(speed_mps)
        may_overlap = _may_overlap("add", overlap)
        self._forget_first()
        return self._native.add(kind, int(model_seed), model, place, speed_mps, points, may_overlap)

    def move_ego(self, *, x_m: float, y_m: float, yaw_rad: float = 0.0, overlap: str = "refuse") -> None:
        """Put the ego on the ground at a place, at rest.

        Args:
            x_m: world frame: the middle of the car.
            y_m: world frame.
            yaw_rad: counter-clockwise from east.
            overlap: "refuse" a place where an actor stands, or "allow" it.

        Raises:
            CadetError: a number that is not finite, or a place off the ground or where an actor stands.
        """
        place, may_overlap = _place("move_ego", x_m, y_m, yaw_rad), _may_overlap("move_ego", overlap)
        self._forget_first()
        self._native.move_ego(*place, may_overlap)

    def command_ego(self, *, speed_mps: float | None, lateral_m: float = 0.0) -> None:
        """Drive the ego along its lane from the next step on, whatever others, signals, and bends are.

        Args:
            speed_mps: speed to reach and keep, by the pedals of its driver; None lets its driver drive.
            lateral_m: meters to the left of the lane's middle to reach at 1 m/s and keep.

        Raises:
            CadetError: a number out of range, or the ego stands on no lane, as in an empty scene without a map.
        """
        self._native.command_ego(None if speed_mps is None else as_command("command_ego", speed_mps, lateral_m))

    def step(self, seconds: float) -> None:
        """Let physics run, rounded to whole steps of 1/60 s.

        Where a road ends with the map, who drives leaves and comes in elsewhere; so does an ego on its own.

        Raises:
            CadetError: a time that is negative, not finite or longer than an hour.
        """
        check_number("step", "seconds", seconds, *_cadet.limits()["step_s"])
        self._forget_first()
        self._native.step(float(seconds), True)

    def capture(
        self, *, sensors: Iterable[str] | None = None, more_maps: Iterable[str] = (), flow_s: float = 0.1
    ) -> Frame:
        """Return what the rig sees now. At the same instant it returns the same frame, noise and `meta` included.

        Args:
            sensors: names of sensors besides the first camera and LIDAR; None for all that the rig has in `more`. The
                right color camera, "image_3", must be named. What is not asked for is not rendered.
            more_maps: some of "normals", "optical_flow", "scene_flow", and "radiance", of every image, beside its
                depth, instances, and classes; see `cadet.Maps`.
            flow_s: the time of the optical flow.

        Raises:
            CadetError: the rig has no sensor of a name, an unknown map, or a time out of range.
        """
        wanted = Wanted.all_of(sensors, more_maps, flow_s)
        if sensors is None and not wanted.more_maps and self._first is not None:
            sample, self._first = self._first, None
            return frame_from_sample(sample)
        native = self._native.capture(request(self._rig, self._num_moves, wanted))
        over_s = wanted.optical_flow_s(None)
        flow = {} if over_s is None else {"flow_s": over_s}
        return frame_from_sample(Sample(native, self._rig, (self._origin or {"sample": self._num_moves}) | flow))

    def scan(self, lidar: Lidar | None = None, *, ideal: bool = False, surfaces: bool = False) -> Scan:
        """Take a scan with a LIDAR.

        Args:
            lidar: the rig's own if None.
            ideal: every triangle opaque, every hit returned, no noise, drop-out, weather or rounding; all rays at one
                instant and as thin as lines, whatever the LIDAR's `rolling` and `divergence_mrad`.
            surfaces: tell in `Scan.surfaces` what returned each point; not for ideal scans.

        Raises:
            CadetError: surfaces of an ideal scan.
        """
        if lidar is not None:
            check_kind("", "lidar", lidar, Lidar)
        check_flag("scan", "ideal", ideal)
        native = None if lidar is None else lidar._to_native()
        check_flag("scan", "surfaces", surfaces)
        if ideal and surfaces:
            raise CadetError("scan.surfaces: an ideal scan has none, every hit is returned as it is; leave ideal out")
        how = {"ideal": bool(ideal), "surfaces": bool(surfaces)}
        return scan_from_native(self._native.scan(native, **how, sample=self._num_moves))

    def cast_rays(
        self,
        origins_world: NDArray[np.float64] | list[list[float]],
        directions_world: NDArray[np.float64] | list[list[float]],
    ) -> RayHits:
        """Cast arbitrary rays at the triangles that the sensors see.

        Args:
            origins_world: (N, 3) float64 array, or a list of lists.
            directions_world: (N, 3) float64 array, or a list of lists; any length but 0.

        Raises:
            ShapeError: another shape or dtype.
            NonFiniteError: NaN or infinity.
            CadetError: a direction of length 0.
        """
        origins = _vectors("origins_world", origins_world)
        directions = _vectors("directions_world", directions_world)
        return RayHits(*self._native.cast_rays(origins, directions))

    def triangles(self) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.int32]]:
        """Return the triangles that the sensors see, the ego excluded.

        Returns:
            vertices_world (V, 3) float32, of which several may share a place; faces (F, 3) uint32; actor_id (F,) int32,
            as in `Frame.instance`.
        """
        return self._native.triangles()

    def sensor_poses(self) -> dict[str, NDArray[np.float64]]:
        """Return "world_from_velo" and "world_from_cam" (camera 0), (4, 4) float64 each."""
        velo, cam = self._native.sensor_poses()
        return {"world_from_velo": velo, "world_from_cam": cam}

    def _forget_first(self) -> None:
        self._first = None
        self._origin = {}
        self._num_moves += 1


def _place(owner: str, x_m: float, y_m: float, yaw_rad: float) -> tuple[float, float, float]:
    for name, value in (("x_m", x_m), ("y_m", y_m), ("yaw_rad", yaw_rad)):
        check_number(owner, name, value, -_MAX_PLACE_M, _MAX_PLACE_M)
    return float(x_m), float(y_m), float(yaw_rad)


def _may_overlap(owner: str, overlap: object) -> bool:
    if not is_one_of(overlap, ("refuse", "allow")):
        raise CadetError(f'{owner}.overlap: expected "refuse" or "allow", got {shown(overlap)}')
    return overlap == "allow"


def _vectors(name: str, values: NDArray[np.float64] | Sequence[Sequence[float]]) -> NDArray[np.float64]:
    return np.ascontiguousarray(as_array(values, name, ("n", 3), np.float64, finite=True))
