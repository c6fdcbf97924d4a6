"""The sensors and where they sit: any number of cameras and LIDARs on the car."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.checks import as_tuple, check_kind, check_number, check_text, check_three, is_one_of, make_plain, shown
from cadet._util.summary import summary
from cadet._util.toml_file import NamedFile
from cadet.errors import CadetError
from cadet.sensors.camera import Camera
from cadet.sensors.extrinsics import Extrinsics
from cadet.sensors.kitti_calibrations import KITTI_CALIBRATIONS, MOST_FREQUENT, Row3, kitti_calibration
from cadet.sensors.lidar import Lidar
from cadet.sensors.mounted import MountedCamera, MountedLidar
from cadet.sensors.pose import inverse, product, rotation_of_angles
from cadet.sensors.rig_file import fields_of_table, table_of_rig

_FILES = {path.stem: path for path in sorted((Path(__file__).parent / "presets" / "rigs").glob("*.toml"))}
RIG_PRESETS = ("kitti", "paper", "cadet", *_FILES)
"""The rigs with class methods of their own, then those that are data: a file is all that one more takes."""
RIGHT_CAMERA = "image_3"
GRAY_CAMERAS = ("image_0", "image_1")
"""The right color camera of a rig whose calibration has one: rendered where it is asked for by name."""

_DEFAULT = kitti_calibration(MOST_FREQUENT)


@dataclass(frozen=True, kw_only=True)
class Rig(NamedFile):
    """Named sensors on the ego vehicle: a LIDAR and a camera beside it, KITTI's by default, and any number more.

    The first camera and the first LIDAR give `Frame.image` and `Frame.points_velo`, and labels stand in that camera's
    frame. KITTI's calibration says how the two stand to each other; all others stand at poses of their own (`more`).

    Raises:
        CadetError: a number outside its range, or two sensors of a name.
    """

    _KIND = "rig"

    name: str = "custom"
    """For the metadata."""
    lidar: Lidar = Lidar("hdl64e_kitti")
    """The LIDAR."""
    camera: Camera = Camera.kitti()
    """The camera that renders the image."""
    extrinsics: Extrinsics = Extrinsics()
    """How the camera stands to the LIDAR, rotation included."""
    velo_in_ego_m: Row3 = (0.0, 0.0, 1.73)
    """The LIDAR in the ego's frame: forward, left, and up from the road."""
    velo_roll_pitch_yaw_deg: Row3 = (0.0, _DEFAULT.lidar_pitch_deg, 0.0)
    """How the LIDAR is turned there: about its own x axis (left side up), then y (nose down), then z (to the left)."""

    camera_name: str = "image_2"
    """Names the camera's images."""
    lidar_name: str = "velodyne"
    """Names the LIDAR's scans."""
    more: tuple[MountedCamera | MountedLidar, ...] = ()
    """More sensors, each with its name and its pose on the ego."""
    origin_in_ego_m: Row3 = (0.0, 0.0, 0.0)
    """Where the ego's frame begins by a dataset's convention, such as under the rear axle: exporters to such a format
    give the ego's pose there."""

    def __post_init__(self) -> None:
        for name, kind in (("lidar", Lidar), ("camera", Camera), ("extrinsics", Extrinsics)):
            check_kind("Rig", name, getattr(self, name), kind)
        if self.camera.model == "fisheye":
            raise CadetError(
                "Rig.camera: expected a pinhole camera, which KITTI's files need; mount a fisheye beside it"
            )
        for name in ("name", "camera_name", "lidar_name"):
            check_text("Rig", name, getattr(self, name))
        check_three("Rig", "velo_in_ego_m", self.velo_in_ego_m, 20)
        check_three("Rig", "origin_in_ego_m", self.origin_in_ego_m, 20)
        check_three("Rig", "velo_roll_pitch_yaw_deg", self.velo_roll_pitch_yaw_deg, 180)
        object.__setattr__(self, "more", as_tuple("Rig", "more", self.more, "MountedCamera and MountedLidar"))
        for mounted in self.more:
            if not isinstance(mounted, (MountedCamera, MountedLidar)):
                raise CadetError(f"Rig.more: expected MountedCamera or MountedLidar, got {shown(mounted)}")
        # Cameras first: what is one rig is equal, and reads alike.
        object.__setattr__(self, "more", tuple(sorted(self.more, key=lambda one: isinstance(one, MountedLidar))))
        make_plain(self)
        names = [self.camera_name, self.lidar_name, *(mounted.name for mounted in self.more)]
        for name in names:
            if names.count(name) > 1:
                raise CadetError(f"Rig: expected a different name for each sensor, got {shown(name)} twice")

    @classmethod
    def kitti(cls, *, calibration: str = MOST_FREQUENT) -> Rig:
        """KITTI's car: HDL-64E 1.73 m up, camera 0 0.27 m ahead of it and 0.07 m lower, the image from camera 2.

        Args:
            calibration: the recording day: "2011_09_26" (81 % of KITTI's frames), "2011_09_28" (10 %), "2011_09_29"
                (5 %) or "2011_10_03" (4 %). They differ in image size, intrinsics, and in how camera and LIDAR stand
                to each other and to the road. On the first the camera looks 0.23 degrees up and leans 0.61 degrees to
                the right, and the LIDAR, level across the road, looks 0.37 degrees down.

        Raises:
            CadetError: another calibration.
        """
        figures = kitti_calibration(calibration)
        return cls(
            name="kitti" if calibration == MOST_FREQUENT else f"kitti_{calibration}",
            camera=Camera.kitti(calibration=calibration),
            extrinsics=Extrinsics.kitti(calibration=calibration),
            velo_roll_pitch_yaw_deg=(0.0, figures.lidar_pitch_deg, 0.0),
        )

    @classmethod
    def every_kitti(cls) -> tuple[tuple[Rig, float], ...]:
        """Return the rigs of all KITTI's calibrations, each with its share of KITTI's frames."""
        num_frames = sum(figures.num_frames for figures in KITTI_CALIBRATIONS.values())
        return tuple(
            (cls.kitti(calibration=name), figures.num_frames / num_frames)
            for name, figures in KITTI_CALIBRATIONS.items()
        )

    @classmethod
    def paper(cls) -> Rig:
        """The 2019 paper's rig: LIDAR and camera in one point, KITTI's beams from one origin, no P2 offset."""
        seen = Camera.kitti()
        return cls(
            name="paper",
            lidar=Lidar("hdl64e_kitti", single_origin=True),
            camera=Camera(width=seen.width, height=seen.height, fx=seen.fx, fy=seen.fy, cx=seen.cx, cy=seen.cy),
            extrinsics=Extrinsics.aligned(),
            velo_roll_pitch_yaw_deg=(0.0, 0.0, 0.0),
        )

    @classmethod
    def cadet(cls) -> Rig:
        """The rig of the CADET tool as it was shipped: 1248 x 384 pixels over 90 degrees, 40 beams, all from 1.6 m."""
        return cls(
            name="cadet",
            lidar=Lidar.cadet(),
            camera=Camera.from_fov(1248, 384, horizontal_deg=90.0),
            extrinsics=Extrinsics.aligned(),
            velo_in_ego_m=(0.0, 0.0, 1.6),
            velo_roll_pitch_yaw_deg=(0.0, 0.0, 0.0),
        )

    @classmethod
    def nuscenes(cls) -> Rig:
        """NuScenes' car: six cameras of 1600 x 900 pixels all around, and the HDL-32E on the roof.

        The first camera is CAM_FRONT. Unlike nuScenes' own, the ego's frame begins under the middle of the car, ahead
        of the rear axle; `origin_in_ego_m` says where nuScenes' does.
        """
        return cls.read(_FILES["nuscenes"])

    @classmethod
    def _presets(cls) -> Mapping[str, Callable[[], Rig]]:
        own = {"kitti": cls.kitti, "paper": cls.paper, "cadet": cls.cadet}
        return {**own, **{name: partial(cls.read, file) for name, file in _FILES.items()}}

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> Rig:
        return cls(**fields_of_table(table, folder))

    def _table(self) -> dict[str, Any]:
        return table_of_rig(self)

    def __repr__(self) -> str:
        return summary(
            self,
            name=self.name,
            lidar=self.lidar,
            camera=self.camera,
            velo_in_ego_m=self.velo_in_ego_m,
            velo_roll_pitch_yaw_deg=self.velo_roll_pitch_yaw_deg,
            more=[mounted.name for mounted in self.more] or None,
        )

    def with_sensors(self, *sensors: MountedCamera | MountedLidar) -> Rig:
        """Return the rig with more sensors.

        Raises:
            CadetError: what is no mounted sensor, or a name that another one has.
        """
        return replace(self, more=self.more + sensors)

    def with_lidar(self, lidar: Lidar) -> Rig:
        """Return the rig with another LIDAR in the place of its first, and another sensor's name behind its own."""
        check_kind("Rig", "lidar", lidar, Lidar)
        is_same = lidar.name == self.lidar.name
        return replace(self, lidar=lidar, name=self.name if is_same else f"{self.name}_{lidar.name}")

    def with_each_lidar(self, change: Callable[[Lidar], Lidar]) -> Rig:
        """Return the rig with each of its LIDARs changed."""
        more = tuple(
            replace(mounted, lidar=change(mounted.lidar)) if isinstance(mounted, MountedLidar) else mounted
            for mounted in self.more
        )
        return replace(self, lidar=change(self.lidar), more=more)

    def with_image_size(self, width: int, height: int) -> Rig:
        """Return the rig with the image of its first camera scaled, in pixels.

        Raises:
            CadetError: a size that is out of range.
        """
        return replace(self, camera=self.camera.resized(width, height))

    def pitched(self, angle_deg: float) -> Rig:
        """Return the rig on a car that stands `angle_deg` deeper in front than behind.

        Raises:
            CadetError: an angle that is not a number from -90 to 90.
        """
        check_number("", "angle_deg", angle_deg, -90, 90)
        roll, pitch, yaw = self.velo_roll_pitch_yaw_deg
        pitched = replace(self, velo_roll_pitch_yaw_deg=(roll, pitch + angle_deg, yaw))
        # The sensors keep their places to each other.
        turned = product(pitched._ego_from_velo(), inverse(self._ego_from_velo()))
        more = tuple(replace(mounted, pose=mounted.pose.carried_by(turned)) for mounted in self.more)
        return replace(pitched, more=more)

    @property
    def has_right_camera(self) -> bool:
        """Whether there is a right color camera, `image_3`: KITTI's, rectified with the left one."""
        is_named = any(mounted.name == RIGHT_CAMERA for mounted in self.more)
        return not is_named and self.camera.cam3_from_cam0_m != self.camera.cam2_from_cam0_m

    @property
    def gray_cameras(self) -> tuple[str, ...]:
        """The gray cameras beside KITTI's color cameras, rectified with them; a `Sample` has what they see in color."""
        taken = {mounted.name for mounted in self.more}
        return GRAY_CAMERAS if self.has_right_camera and taken.isdisjoint(GRAY_CAMERAS) else ()

    @property
    def camera_names(self) -> tuple[str, ...]:
        """The cameras that can take an image, the first one first."""
        right = (RIGHT_CAMERA,) if self.has_right_camera else ()
        return (self.camera_name, *right, *self.mounted_cameras, *self.gray_cameras)

    @property
    def mounted_cameras(self) -> tuple[str, ...]:
        """The cameras among `more`."""
        return tuple(mounted.name for mounted in self.more if isinstance(mounted, MountedCamera))

    @property
    def lidar_names(self) -> tuple[str, ...]:
        """The LIDARs, the first one first."""
        return (self.lidar_name, *(m.name for m in self.more if isinstance(m, MountedLidar)))

    def wanted(self, sensors: Iterable[str] | None) -> tuple[list[int], list[int]]:
        """Return what is to be captured besides the first camera and LIDAR, by places in both lists of names.

        Args:
            sensors: names; None for all of `more`.

        Raises:
            CadetError: the rig has no sensor of that name.
        """
        if sensors is None:
            sensors = [mounted.name for mounted in self.more]
        cameras, lidars = self.camera_names, self.lidar_names
        found: tuple[set[int], set[int]] = (set(), set())
        for name in as_tuple("", "sensors", sensors, "sensors' names"):
            if not is_one_of(name, cameras + lidars):
                known = ", ".join(cameras + lidars)
                raise CadetError(f"the rig {self.name} has no sensor {shown(name)}; it has {known}")
            if name in cameras:
                found[0].add(cameras.index(name))
            else:
                found[1].add(lidars.index(name))
        return sorted(found[0] - {0}), sorted(found[1] - {0})

    def ego_from_sensor(self, name: str) -> NDArray[np.float64]:
        """Return the (4, 4) pose of a sensor's frame on the ego; that of image_0, _1, and _3 is the first camera's.

        Raises:
            CadetError: the rig has no sensor of that name.
        """
        self.wanted((name,))
        for mounted in self.more:
            if mounted.name == name:
                return mounted.pose.matrix()
        if name == self.lidar_name:
            return self._ego_from_velo()
        cam_from_velo = np.vstack([self.extrinsics.cam_from_velo(), [0.0, 0.0, 0.0, 1.0]])
        return product(self._ego_from_velo(), inverse(cam_from_velo))

    def sensor(self, name: str) -> Camera | Lidar:
        """Return the sensor of a name; image_0, _1, and _3 are the rig's camera at other places.

        Raises:
            CadetError: the rig has none.
        """
        self.wanted((name,))
        for mounted in self.more:
            if mounted.name == name:
                return mounted.camera if isinstance(mounted, MountedCamera) else mounted.lidar
        return self.lidar if name == self.lidar_name else self.camera

    def _to_native(self) -> _cadet.Rig:
        """Return the rig as the core takes it."""
        velo = _cadet.Pose.mounted(list(self.velo_in_ego_m), list(self.velo_roll_pitch_yaw_deg))
        beside = [velo, _cadet.Pose.rigid(self.extrinsics.cam_from_velo()).inverse()]
        projections = self.camera.projections()
        cameras = [self.camera._to_native(self.camera_name, projections["P2"], beside)]
        if self.has_right_camera:
            cameras.append(self.camera._to_native(RIGHT_CAMERA, projections["P3"], beside))
        lidars = [(self.lidar_name, self.lidar._to_native(), [velo])]
        for mounted in self.more:
            at = [_cadet.Pose.rigid(mounted.pose.matrix()[:3].copy())]
            if isinstance(mounted, MountedCamera):
                cameras.append(mounted.camera._to_native(mounted.name, mounted.camera.projections()["P2"], at))
            else:
                lidars.append((mounted.name, mounted.lidar._to_native(), at))
        for name, key in zip(self.gray_cameras, ("P0", "P1"), strict=False):
            cameras.append(self.camera._to_native(name, projections[key], beside))
        return _cadet.Rig(self.name, cameras=cameras, lidars=lidars)

    def to_dict(self) -> dict[str, Any]:
        """Return the rig in plain numbers, for a manifest."""
        camera: dict[str, Any] = {"width": int(self.camera.width), "height": int(self.camera.height)}
        matrices = {**self.camera.projections(), **self.extrinsics.matrices()}
        camera |= {key: matrix.tolist() for key, matrix in matrices.items()}
        camera |= self.camera.unusual()
        plain: dict[str, Any] = {
            "name": self.name,
            **self.lidar.to_dict(),
            "velo_in_ego": [float(v) for v in self.velo_in_ego_m],
            "velo_roll_pitch_yaw_deg": [float(v) for v in self.velo_roll_pitch_yaw_deg],
            "camera": camera,
            "range_m": self.lidar.range_m(),
        }
        if self.more:
            plain["names"] = [self.camera_name, self.lidar_name]
            plain["origin_in_ego"] = [float(v) for v in self.origin_in_ego_m]
            plain["more"] = {mounted.name: mounted.to_dict() for mounted in self.more}
        return plain

    def sha256(self) -> str:
        """Return a digest of all numbers of the rig."""
        return hashlib.sha256(json.dumps(self.to_dict(), sort_keys=True).encode("ascii")).hexdigest()

    def _ego_from_velo(self) -> NDArray[np.float64]:
        matrix = np.eye(4)
        matrix[:3, :3] = rotation_of_angles(*self.velo_roll_pitch_yaw_deg)
        matrix[:3, 3] = self.velo_in_ego_m
        return matrix
