"""What a rig captured at one instant: neutral facts, from which every dataset's format is made."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.checks import as_tuple, check_number, is_one_of, known_names, shown
from cadet._util.summary import counts, summary
from cadet.errors import CadetError
from cadet.sensors.rig import Rig

MATERIALS = tuple(_cadet.Lidar.materials())
"""What `ScanSurfaces.material` counts."""


class ScanSurfaces(NamedTuple):
    """The surfaces that returned a scan's points; for what fog, drops and flakes returned NaN and -1.

    Attributes:
        cos_incidence: (N,) float32, of the angle between the beam and the normal, 0 to 1.
        reflectance: (N,) float32 back to the sensor, against a white diffuse surface that faces it, with what panes,
            water, snow and other parts of a split beam leave of it; of a retroreflector hundreds.
        normal_velo: (N, 3) float32, unit length, towards the sensor as it stood when the laser fired.
        material: (N,) int8, an index into `cadet.MATERIALS`.
    """

    cos_incidence: NDArray[np.float32]
    reflectance: NDArray[np.float32]
    normal_velo: NDArray[np.float32]
    material: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Scan:
    """One turn of a LIDAR, ring-major, azimuth rising counter-clockwise from forward.

    An ideal scan has one row for each of `Lidar.rays()`, in the same order; a normal one only its returns.

    Attributes:
        points_velo: (N, 4) float32 [x, y, z, intensity], meters in the velo frame.
        ring: (N,) int32, 0 at the top.
        column: (N,) int32, 0 forward.
        actor_id: (N,) int32, as in `Frame.instance`; -1 for a miss.
        semantic: (N,) uint8, values of `cadet.Semantic`; sky for a miss, and for what fog, drops and flakes return.
        range_m: (N,) float64 from the laser's origin; inf for a miss.
        time_s: (N,) float32, when it fired, seconds from the image's instant; 0 where `Lidar.rolling` is off.
        echo: (N,) uint8, its number among the echoes of its pulse that are detected, the nearest 1; 0 for a miss.
        surfaces: what returned each point, if it was asked for.
    """

    points_velo: NDArray[np.float32]
    ring: NDArray[np.int32]
    column: NDArray[np.int32]
    actor_id: NDArray[np.int32]
    semantic: NDArray[np.uint8]
    range_m: NDArray[np.float64]
    time_s: NDArray[np.float32]
    echo: NDArray[np.uint8]
    surfaces: ScanSurfaces | None = None

    def __repr__(self) -> str:
        rings, hits = len(np.unique(self.ring)), int((self.actor_id >= 0).sum())
        return summary(self, f"{rings} rings", f"{hits} hits", points_velo=self.points_velo)


MORE_MAPS: Final = ("normals", "optical_flow", "scene_flow", "radiance")
"""The maps of an image that are made on demand; see `Maps`."""
_FLOW_S: Final = 0.1
"""The time between KITTI's images."""
_FLOW_LIMITS_S: Final = (1e-3, 10.0)


def scan_from_native(native: Mapping[str, Any]) -> Scan:
    """Return the scan that the core took."""
    surfaces = native["surfaces"]
    return Scan(**{**native, "surfaces": None if surfaces is None else ScanSurfaces(**surfaces)})


@dataclass(frozen=True)
class Wanted:
    """What each sample has besides the first camera's image and the first LIDAR's scan; all else costs nothing."""

    sensors: tuple[str, ...] | None = None
    """More sensors of the rig by name; None for all of `Rig.more`."""
    maps: bool = True
    """Depth, instances and classes of every image."""
    labels: bool = True
    """What every camera sees of agents, not the first one alone."""
    more_maps: tuple[str, ...] = ()
    """Some of `MORE_MAPS`, of every image; they come with the other maps."""
    flow_s: float | None = None
    """The time of the optical flow; None for that to the next sample of a sequence, and 0.1 s elsewhere."""
    shares: bool = False
    """How much of each agent the images show."""

    def __post_init__(self) -> None:
        for name in self.more_maps:
            if not is_one_of(name, MORE_MAPS):
                raise CadetError(f"more_maps: unknown map {shown(name)}; {known_names(name, MORE_MAPS)}")
        if self.flow_s is not None:
            check_number("", "flow_s", self.flow_s, *_FLOW_LIMITS_S)

    @classmethod
    def all_of(
        cls, sensors: Iterable[str] | None, more_maps: Iterable[str] = (), flow_s: float | None = None
    ) -> Wanted:
        """Return these sensors with their maps.

        Raises:
            CadetError: an unknown map, or a time out of range.
        """
        names = as_tuple("", "more_maps", more_maps, "maps' names")
        return cls(sensors=None if sensors is None else tuple(sensors), more_maps=names, flow_s=flow_s)

    def optical_flow_s(self, time_step_s: float | None) -> float | None:
        """Return the time of the optical flow, None if it is not wanted; `time_step_s` is a sequence's."""
        return float(self.flow_s or time_step_s or _FLOW_S) if "optical_flow" in self.more_maps else None


class Maps(NamedTuple):
    """What the pixels' centers of an image show. What is None was not asked for.

    Both flows are those of the motion at the image's instant, with velocities and angular velocities kept: exact for
    what moves steadily. Actors are rigid: how limbs swing and wheels turn is left out. Under a rolling shutter each
    row's motion begins at its own time.

    Attributes:
        depth: (H, W) float32, meters along the optical axis, of a fisheye from the optical center; inf for sky.
        instance: (H, W) int32: -1 sky, 0 static world, >= 1 agents.
        semantic: (H, W) uint8, values of `cadet.Semantic`.
        normals: (H, W, 3) float32, unit normals of the triangles, toward the camera, in the axes of its frame (x right,
            y down, z forward); 0 for sky.
        optical_flow: (H, W, 2) float32, columns and rows by which what a pixel shows moves until the next image; NaN
            for sky and for what comes behind the camera.
        scene_flow: (H, W, 3) float32, velocity over the ground in m/s, in the same axes as the normals; 0 for the
            static world and the sky.
        radiance: (H, W, 3) float32, linear RGB light in shares of the image's white, which may be far above 1: what the
            lens lets through, exposed and balanced as the image is, without the sensor's color filters, noise,
            clipping, and response.
    """

    depth: NDArray[np.float32]
    instance: NDArray[np.int32]
    semantic: NDArray[np.uint8]
    normals: NDArray[np.float32] | None = None
    optical_flow: NDArray[np.float32] | None = None
    scene_flow: NDArray[np.float32] | None = None
    radiance: NDArray[np.float32] | None = None


@dataclass(frozen=True, eq=False)
class Agent:
    """A vehicle or a person around the ego, seen or not.

    Attributes:
        id: at least 1, the same for as long as it lives.
        type: its class, such as "Car".
        model: its model's name.
        size_lwh: length, width and height in meters.
        world_from_agent: (4, 4) float64: x forward, y left, z up, origin in the middle of its bottom.
        velocity_world: m/s.
        visible_share: of its outline in all images of the sample, the share that is seen; None unless asked for, and
            where no image shows a part of the outline.
        brakes_for: what its driver brakes or waits for most: "vehicle", "obstacle" (it stands for good), "person",
            "light", "junction" (others go first), "road end"; None where the way is free, and if nobody drives it.
        brakes_for_id: the `id` of that vehicle, or of who goes first at the junction, 0 for the ego;
            None if there is none.
    """

    id: int
    type: str
    model: str
    size_lwh: tuple[float, float, float]
    world_from_agent: NDArray[np.float64]
    velocity_world: tuple[float, float, float]
    visible_share: float | None
    brakes_for: str | None = None
    brakes_for_id: int | None = None

    def __repr__(self) -> str:
        x, y, z = (round(value, 2) for value in self.position_world)
        return summary(self, id=self.id, type=self.type, model=self.model, position_world=(x, y, z))

    @property
    def position_world(self) -> tuple[float, float, float]:
        """The middle of its bottom, meters."""
        x, y, z = self.world_from_agent[:3, 3].tolist()
        return x, y, z

    @property
    def speed_mps(self) -> float:
        """Speed in m/s."""
        # Not NumPy's norm: its last bit differs between processors, and datasets record this number.
        x, y, z = self.velocity_world
        return math.sqrt(x * x + y * y + z * z)


class Sample:
    """Time, ego, agents, and captures of one instant, in no dataset's format.

    Attributes:
        rig: the sensors, on the car as it was loaded.
        origin: what the episode knows of it: seed, episode, sample and so on; and, for every format's records,
            `map_offset_m` of a map that lies far from 0, and `map_geo_reference` of one that says where on the earth it
            lies: its PROJ string, and what its header's `<offset>` adds.
    """

    def __init__(self, native: _cadet.Capture, rig: Rig, origin: Mapping[str, Any]) -> None:
        """Wrap what the core captured."""
        self._native = native
        self.rig = rig
        self.origin = dict(origin)
        if any(self.map_offset_m):
            self.origin["map_offset_m"] = self.map_offset_m
        if native.map_geo_reference is not None:
            projection, offset_m, heading_rad = native.map_geo_reference
            self.origin["map_geo_reference"] = {
                "projection": projection,
                "offset_m": offset_m,
                "heading_rad": heading_rad,
            }

    def __repr__(self) -> str:
        return summary(
            self,
            time_s=self.time_s,
            image_names=self.image_names,
            scan_names=self.scan_names,
            agents=counts(agent.type for agent in self.agents),
        )

    @property
    def time_s(self) -> float:
        """Seconds since the scene's start."""
        return self._native.time_s

    @cached_property
    def world_from_ego(self) -> NDArray[np.float64]:
        """(4, 4) float64: x forward, y left, z up from the road under the middle of the car."""
        return np.array(self._native.world_from_ego)

    @property
    def ego_speed_mps(self) -> float:
        """The ego's speed."""
        return self._native.ego_speed_mps

    @property
    def ego_velocity_world(self) -> tuple[float, float, float]:
        """The velocity of the ego's origin, m/s."""
        vx, vy, vz = self._native.ego_velocity_world
        return vx, vy, vz

    @property
    def ego_angular_velocity_world(self) -> tuple[float, float, float]:
        """The ego's angular velocity, rad/s."""
        wx, wy, wz = self._native.ego_angular_velocity_world
        return wx, wy, wz

    @property
    def map(self) -> str:
        """The map's name."""
        return self._native.map

    @property
    def map_offset_m(self) -> tuple[float, float]:
        """What places in the world frame lack of the map's own x and y; (0, 0) unless those are far from 0."""
        x, y = self._native.map_offset_m
        return x, y

    @property
    def weather(self) -> str:
        """The weather's name."""
        return self._native.weather

    @property
    def sun_rad(self) -> tuple[float, float]:
        """The sun's elevation and azimuth."""
        return self._native.sun_rad

    @property
    def boxes(self) -> str:
        """Which boxes the sightings hold: "kitti" or "exact"."""
        return self._native.boxes

    @property
    def ego_from_velo(self) -> list[list[float]]:
        """Rows of the first LIDAR's pose."""
        return self._native.ego_from_velo

    @cached_property
    def plane(self) -> NDArray[np.float64]:
        """(4,) float64: the road's plane in the first camera's frame, unit normal, b < 0."""
        return self._native.plane

    @cached_property
    def agents(self) -> tuple[Agent, ...]:
        """Every agent around the ego, by rising id."""
        return tuple(agent_from_native(native) for native in self._native.agents)

    def _sightings(self, name: str | None = None) -> list[_cadet.Sighting] | None:
        """Return what a camera, the first one if None, sees of agents: those with a label by id, then the others.

        None unless asked for; the first camera always is.
        """
        return self._native.sightings(_index(self.image_names, name))

    @cached_property
    def image_names(self) -> tuple[str, ...]:
        """The cameras that took an image, the rig's first one first."""
        return tuple(self._native.names[0])

    @cached_property
    def scan_names(self) -> tuple[str, ...]:
        """The LIDARs that took a scan, the rig's first one first."""
        return tuple(self._native.names[1])

    def image(self, name: str | None = None) -> NDArray[np.uint8]:
        """Return a camera's image, the first one's if None: (H, W, 3) uint8, RGB."""
        return self._native.image(_index(self.image_names, name))

    def png(self, name: str | None = None) -> bytes:
        """Return the same as a PNG file, encoded by the core that made it."""
        return self._native.png(_index(self.image_names, name))

    def maps(self, name: str | None = None) -> Maps | None:
        """Return depth, instances and classes of an image; None unless asked for."""
        index = _index(self.image_names, name)
        maps = self._native.maps(index)
        return None if maps is None else Maps(**maps, radiance=self._native.radiance(index))

    def scan(self, name: str | None = None) -> Scan:
        """Return a LIDAR's scan, the first one's if None."""
        return scan_from_native(self._native.scan(_index(self.scan_names, name)))


def _index(names: tuple[str, ...], name: str | None) -> int:
    return 0 if name is None else names.index(name)


def agent_from_native(native: _cadet.Agent) -> Agent:
    """Return what the core knows of an agent."""
    share = None
    if native.pixels is not None and native.pixels[0] > 0.0:
        share = native.pixels[1] / native.pixels[0]
    length, width, height = native.size_lwh
    cause, cause_id = native.brakes_for or (None, None)
    vx, vy, vz = native.velocity_world
    return Agent(
        id=native.id,
        type=native.class_name,
        model=native.model,
        size_lwh=(length, width, height),
        world_from_agent=np.array(native.world_from_agent),
        velocity_world=(vx, vy, vz),
        visible_share=share,
        brakes_for=cause,
        brakes_for_id=cause_id,
    )
