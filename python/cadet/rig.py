"""The sensors and where they sit: LIDAR, camera, and the calibration that follows."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet.beam_table import BeamTable
from cadet.camera import Camera
from cadet.checks import (
    as_path,
    check_flag,
    check_kind,
    check_number,
    check_text,
    check_three,
    is_one_of,
    make_plain,
    shown,
)
from cadet.errors import CadetError
from cadet.extrinsics import Extrinsics
from cadet.kitti_calibrations import KITTI_CALIBRATIONS, MOST_FREQUENT, Row3, kitti_calibration
from cadet.summary import summary

RETURN_MODES = ("strongest", "last")
RIG_PRESETS = ("kitti", "paper", "cadet")
LIDAR_PRESETS = ("hdl64e_kitti", "hdl64e_uniform", "cadet", "hdl32e", "vlp16", "os1_64", "os1_128")


class CameraDict(TypedDict):
    """A camera as the core takes it: KITTI's matrices, float64, and the image's size."""

    width: int
    height: int
    P0: NDArray[np.float64]
    P1: NDArray[np.float64]
    P2: NDArray[np.float64]
    P3: NDArray[np.float64]
    R0_rect: NDArray[np.float64]
    Tr_velo_to_cam: NDArray[np.float64]
    Tr_imu_to_velo: NDArray[np.float64]


class RigDict(TypedDict):
    """A rig as the core takes it.

    `lidar` is a preset's name or a whole table (`BeamTable.to_native`), `single_origin` puts all its lasers into one
    point, and `velo_in_ego` is the LIDAR's origin [x, y, z] in the ego's frame (x forward, y left, z up from the road
    under the middle of the car), metres; `velo_roll_pitch_yaw_deg` are its angles there.
    """

    name: str
    lidar: str | dict[str, Any]
    single_origin: bool
    rolling: bool
    returns: str
    divergence_mrad: float
    velo_in_ego: list[float]
    velo_roll_pitch_yaw_deg: list[float]
    camera: CameraDict


@dataclass(frozen=True)
class Lidar:
    """A LIDAR's beams, by preset or by a table of one's own, and how it takes a scan (docs/scan.md).

    Args:
        name: one of `LIDAR_PRESETS`, or the table's name.
        single_origin: all lasers leave one point, where the HDL-64E's sit at different heights.
        table: a sensor that is no preset; `Lidar.custom` and `Lidar.from_toml` give it its name.
        rolling: the car and all actors move during the turn, from 0.05 s before the image to 0.05 s after it, azimuth 0
            (forward) at its instant; points stay in the frame of their own firing.
        returns: "strongest" or "last": what is reported where a beam meets several surfaces.
        divergence_mrad: how far a beam opens (the full cone), so that it meets several surfaces at depth edges; 0 for
            beams that meet surfaces as lines do; drops and flakes then see the sensor's own 2 mrad. The HDL-64E's is 2
            to 3.

    Raises:
        CadetError: an unknown preset, a table of another name or that makes no sensor, or a setting out of range.
    """

    name: str = "hdl64e_kitti"
    single_origin: bool = False
    table: BeamTable | None = None
    rolling: bool = False
    returns: str = "strongest"
    divergence_mrad: float = 0.0

    def __post_init__(self) -> None:
        for name in ("single_origin", "rolling"):
            check_flag("Lidar", name, getattr(self, name))
        if not is_one_of(self.returns, RETURN_MODES):
            raise CadetError(f"Lidar.returns: expected one of {', '.join(RETURN_MODES)}, got {shown(self.returns)}")
        check_number("Lidar", "divergence_mrad", self.divergence_mrad, 0, 20)
        make_plain(self)
        if self.table is not None:
            check_kind("Lidar", "table", self.table, BeamTable)
            if not is_one_of(self.name, (self.table.name,)):
                raise CadetError(f"Lidar.name: expected the table's, {self.table.name!r}, got {shown(self.name)}")
            # What the table's own checks cannot see is refused here rather than in the middle of a run.
            self.to_native()
        elif not is_one_of(self.name, LIDAR_PRESETS):
            raise CadetError(f"unknown lidar {shown(self.name)}; known: {', '.join(LIDAR_PRESETS)}")

    def __repr__(self) -> str:
        changed = {f.name: getattr(self, f.name) for f in fields(self)[1:] if getattr(self, f.name) != f.default}
        return summary(self, name=self.name, **changed)

    @classmethod
    def hdl64e_kitti(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """The Velodyne of KITTI: 64 lasers, each with its own elevation and height, 137,728 beams a turn."""
        return cls("hdl64e_kitti", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def hdl64e_uniform(
        cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0
    ) -> Lidar:
        """The same elevations from one point in 2,083 uniform columns: 133,312 beams, the benchmark's scan."""
        return cls("hdl64e_uniform", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def cadet(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """The 2019 paper's LIDAR: 40 beams from +7 to -16 degrees."""
        return cls("cadet", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def hdl32e(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """Velodyne's HDL-32E: 32 lasers from +10.67 to -30.67 degrees, 2,170 columns a turn."""
        return cls("hdl32e", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def vlp16(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """Velodyne's VLP-16: 16 lasers from +15 to -15 degrees, 1,808 columns a turn."""
        return cls("vlp16", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def os1_64(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """A sensor like Ouster's OS1-64: 64 lasers from +22.5 to -22.5 degrees, 1,024 columns a turn."""
        return cls("os1_64", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def os1_128(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """A sensor like Ouster's OS1-128: 128 lasers from +22.5 to -22.5 degrees, 2,048 columns a turn."""
        return cls("os1_128", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def custom(cls, table: BeamTable) -> Lidar:
        """A sensor of one's own.

        Raises:
            CadetError: no table, or one that makes no sensor.
        """
        check_kind("Lidar", "table", table, BeamTable)
        return cls(table.name, table=table)

    @classmethod
    def from_toml(cls, path: str | Path) -> Lidar:
        """Read a sensor of one's own from a TOML file (docs/lidars.md says what is in it).

        Raises:
            MissingFileError: there is no such file.
            CadetError: anything that is wrong with it: one line with the file, its line where known, key and reason.
        """
        table = BeamTable.read(path)
        try:
            return cls.custom(table)
        except CadetError as error:
            raise CadetError(f"{as_path('path', path).name}: {error}") from None

    @classmethod
    def named(cls, name_or_file: str | Path) -> Lidar:
        """Return the preset of that name, or what a TOML file holds.

        Raises:
            CadetError: neither, or as `from_toml`.
        """
        path = as_path("lidar", name_or_file)
        if str(path) in LIDAR_PRESETS:
            return cls(str(path))
        if path.suffix == ".toml":
            return cls.from_toml(path)
        raise CadetError(
            f"unknown lidar {shown(str(path))}; known: {', '.join(LIDAR_PRESETS)}, or the path of a .toml file"
        )

    def beam_table(self) -> BeamTable:
        """Return every laser and number of the sensor, presets' too."""
        return BeamTable.from_native(self.to_native().table())

    def to_toml(self) -> str:
        """Return the sensor as TOML, to start one's own from; `from_toml` reads it."""
        return self.beam_table().to_toml()

    def rays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
        """Return every beam of a turn, in the order of an ideal scan's rows.

        Returns:
            origins_velo (B, 3) metres, directions_velo (B, 3) of unit length, ring (B,) from the top, column (B,).
        """
        return self.to_native().rays()

    def to_native(self) -> _cadet.Lidar:
        """Return the core's LIDAR; the last few made are kept, as each holds tables of its beams."""
        return _to_native(self)

    def _make_native(self) -> _cadet.Lidar:
        if self.table is None:
            native = _cadet.Lidar.preset(self.name)
        else:
            native = _cadet.Lidar.from_table(self.table.to_native())
        native = native.single_origin() if self.single_origin else native
        return native.scanning(rolling=self.rolling, returns=self.returns, divergence_mrad=float(self.divergence_mrad))


@lru_cache(maxsize=8)
def _to_native(lidar: Lidar) -> _cadet.Lidar:
    return lidar._make_native()


_DEFAULT = kitti_calibration(MOST_FREQUENT)


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A LIDAR on the ego vehicle and a camera beside it, KITTI's by default.

    Raises:
        CadetError: a number outside its range.
    """

    name: str = "custom"
    """For the metadata."""
    lidar: Lidar = Lidar("hdl64e_kitti")
    """The LIDAR."""
    camera: Camera = Camera()
    """The camera that renders the image."""
    extrinsics: Extrinsics = Extrinsics()
    """How the camera stands to the LIDAR, rotation included."""
    velo_in_ego_m: Row3 = (0.0, 0.0, 1.73)
    """The LIDAR in the ego's frame: forward, left, and up from the road."""
    velo_roll_pitch_yaw_deg: Row3 = (0.0, _DEFAULT.lidar_pitch_deg, 0.0)
    """How the LIDAR is turned there: about its own x axis (left side up), then y (nose down), then z (to the left)."""

    def __post_init__(self) -> None:
        for name, kind in (("lidar", Lidar), ("camera", Camera), ("extrinsics", Extrinsics)):
            check_kind("Rig", name, getattr(self, name), kind)
        check_text("Rig", "name", self.name)
        check_three("Rig", "velo_in_ego_m", self.velo_in_ego_m, 20)
        check_three("Rig", "velo_roll_pitch_yaw_deg", self.velo_roll_pitch_yaw_deg, 180)
        make_plain(self)

    @classmethod
    def kitti(cls, *, calibration: str = MOST_FREQUENT) -> Rig:
        """KITTI's car: HDL-64E 1.73 m up, camera 0 0.27 m ahead of it and 0.08 m lower, the image from camera 2.

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
            camera=Camera.single(seen.width, seen.height, fx=seen.fx, fy=seen.fy, cx=seen.cx, cy=seen.cy),
            extrinsics=Extrinsics.aligned(),
            velo_roll_pitch_yaw_deg=(0.0, 0.0, 0.0),
        )

    @classmethod
    def cadet(cls) -> Rig:
        """The rig of the CADET tool as it was shipped: 1248 x 384 pixels over 90 degrees, 40 beams, all from 1.6 m."""
        width, height = 1248, 384
        # tan 45 degrees is 1.
        focal_px = width / 2
        return cls(
            name="cadet",
            lidar=Lidar.cadet(),
            camera=Camera.single(width, height, fx=focal_px, fy=focal_px, cx=(width - 1) / 2, cy=(height - 1) / 2),
            extrinsics=Extrinsics.aligned(),
            velo_in_ego_m=(0.0, 0.0, 1.6),
            velo_roll_pitch_yaw_deg=(0.0, 0.0, 0.0),
        )

    @classmethod
    def named(cls, name: str) -> Rig:
        """Return the preset of that name, one of `RIG_PRESETS`.

        Raises:
            CadetError: there is none.
        """
        presets = {"kitti": cls.kitti, "paper": cls.paper, "cadet": cls.cadet}
        if not is_one_of(name, presets):
            raise CadetError(f"unknown rig {shown(name)}; known: {', '.join(RIG_PRESETS)}")
        return presets[name]()

    def __repr__(self) -> str:
        return summary(
            self,
            name=self.name,
            lidar=self.lidar,
            camera=self.camera,
            velo_in_ego_m=self.velo_in_ego_m,
            velo_roll_pitch_yaw_deg=self.velo_roll_pitch_yaw_deg,
        )

    def pitched(self, angle_deg: float) -> Rig:
        """Return the rig on a car that stands `angle_deg` deeper in front than behind.

        Raises:
            CadetError: an angle that is no number from -90 to 90.
        """
        check_number("", "angle_deg", angle_deg, -90, 90)
        roll, pitch, yaw = self.velo_roll_pitch_yaw_deg
        return replace(self, velo_roll_pitch_yaw_deg=(roll, pitch + angle_deg, yaw))

    def to_native(self) -> RigDict:
        """Return the rig as the core takes it."""
        projections, extrinsics = self.camera.projections(), self.extrinsics.matrices()
        return RigDict(
            name=self.name,
            lidar=self.lidar.name if self.lidar.table is None else self.lidar.table.to_native(),
            single_origin=self.lidar.single_origin,
            rolling=self.lidar.rolling,
            returns=self.lidar.returns,
            divergence_mrad=float(self.lidar.divergence_mrad),
            velo_in_ego=[float(v) for v in self.velo_in_ego_m],
            velo_roll_pitch_yaw_deg=[float(v) for v in self.velo_roll_pitch_yaw_deg],
            camera=CameraDict(
                width=int(self.camera.width),
                height=int(self.camera.height),
                P0=projections["P0"],
                P1=projections["P1"],
                P2=projections["P2"],
                P3=projections["P3"],
                R0_rect=extrinsics["R0_rect"],
                Tr_velo_to_cam=extrinsics["Tr_velo_to_cam"],
                Tr_imu_to_velo=extrinsics["Tr_imu_to_velo"],
            ),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the rig in plain numbers, for a manifest."""
        native = self.to_native()
        camera = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in native["camera"].items()}
        if self.camera.image_scale != (1.0, 1.0):
            camera["image_scale"] = list(self.camera.image_scale)
        beams = self.lidar.to_native().table()
        return {**native, "camera": camera, "range_m": [beams["min_range_m"], beams["max_range_m"]]}

    def sha256(self) -> str:
        """Return a digest of all numbers of the rig."""
        return hashlib.sha256(json.dumps(self.to_dict(), sort_keys=True).encode("ascii")).hexdigest()
