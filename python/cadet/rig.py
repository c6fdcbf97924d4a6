"""The sensors and where they sit: LIDAR, camera, and the calibration that follows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet.beam_table import BeamTable
from cadet.config import check_number
from cadet.errors import CadetError

RETURN_MODES = ("strongest", "last")
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
    under the middle of the car), metres.
    """

    name: str
    lidar: str | dict[str, Any]
    single_origin: bool
    rolling: bool
    returns: str
    divergence_mrad: float
    velo_in_ego: list[float]
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
            if not isinstance(getattr(self, name), bool):
                raise CadetError(f"Lidar.{name}: expected True or False, got {getattr(self, name)!r}")
        if self.returns not in RETURN_MODES:
            raise CadetError(f"Lidar.returns: expected one of {', '.join(RETURN_MODES)}, got {self.returns!r}")
        check_number("Lidar", "divergence_mrad", self.divergence_mrad, 0, 20)
        if self.table is not None:
            if not isinstance(self.table, BeamTable):
                raise CadetError(f"Lidar.table: expected a BeamTable, got {self.table!r}")
            if self.name != self.table.name:
                raise CadetError(f"Lidar.name: expected the table's, {self.table.name!r}, got {self.name!r}")
            # What the table's own checks cannot see is refused here rather than in the middle of a run.
            self.to_native()
        elif self.name not in LIDAR_PRESETS:
            raise CadetError(f"unknown lidar {self.name!r}; known: {', '.join(LIDAR_PRESETS)}")

    @classmethod
    def hdl64e_kitti(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """The Velodyne of KITTI: 64 lasers, each with its own elevation and height, 137,728 beams a turn."""
        return cls("hdl64e_kitti", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def hdl64e_uniform(cls) -> Lidar:
        """The same elevations from one point in 2,083 uniform columns: 133,312 beams, the benchmark's scan."""
        return cls("hdl64e_uniform")

    @classmethod
    def cadet(cls) -> Lidar:
        """The 2019 paper's LIDAR: 40 beams from +7 to -16 degrees."""
        return cls("cadet")

    @classmethod
    def hdl32e(cls) -> Lidar:
        """Velodyne's HDL-32E: 32 lasers from +10.67 to -30.67 degrees, 2,170 columns a turn."""
        return cls("hdl32e")

    @classmethod
    def vlp16(cls) -> Lidar:
        """Velodyne's VLP-16: 16 lasers from +15 to -15 degrees, 1,808 columns a turn."""
        return cls("vlp16")

    @classmethod
    def os1_64(cls) -> Lidar:
        """A sensor like Ouster's OS1-64: 64 lasers from +22.5 to -22.5 degrees, 1,024 columns a turn."""
        return cls("os1_64")

    @classmethod
    def os1_128(cls) -> Lidar:
        """A sensor like Ouster's OS1-128: 128 lasers from +22.5 to -22.5 degrees, 2,048 columns a turn."""
        return cls("os1_128")

    @classmethod
    def custom(cls, table: BeamTable) -> Lidar:
        """A sensor of one's own."""
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
            raise CadetError(f"{Path(path).name}: {error}") from None

    @classmethod
    def named(cls, name_or_file: str | Path) -> Lidar:
        """Return the preset of that name, or what a TOML file holds.

        Raises:
            CadetError: neither, or as `from_toml`.
        """
        if str(name_or_file) in LIDAR_PRESETS:
            return cls(str(name_or_file))
        if Path(name_or_file).suffix == ".toml":
            return cls.from_toml(name_or_file)
        raise CadetError(
            f"unknown lidar {str(name_or_file)!r}; known: {', '.join(LIDAR_PRESETS)}, or the path of a .toml file"
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


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A rectified pinhole camera, KITTI's left colour camera by default.

    Raises:
        CadetError: a number outside its range.
    """

    width: int = 1242
    """Pixels."""
    height: int = 375
    """Pixels."""
    fx: float = 721.5377
    """Focal length along the rows, pixels."""
    fy: float = 721.5377
    """Focal length along the columns, pixels."""
    cx: float = 609.5593
    """Column of the optical axis; (0, 0) is the center of the top-left pixel."""
    cy: float = 172.854
    """Row of the optical axis."""
    cam2_from_cam0_m: tuple[float, float, float] = (0.0598492648008258, -0.0003579271504954, 0.002745884)
    """Where camera 0 stands in this camera's frame: the translation behind P2's fourth column."""

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            check_number("Camera", name, getattr(self, name), 16, 8192, whole=True)
        for name in ("fx", "fy"):
            check_number("Camera", name, getattr(self, name), 1)
        for name in ("cx", "cy"):
            check_number("Camera", name, getattr(self, name), -1e6, 1e6)
        if not isinstance(self.cam2_from_cam0_m, tuple) or len(self.cam2_from_cam0_m) != 3:
            raise CadetError(f"Camera.cam2_from_cam0_m: expected three numbers, got {self.cam2_from_cam0_m!r}")
        for value in self.cam2_from_cam0_m:
            check_number("Camera", "cam2_from_cam0_m", value, -10, 10)

    @classmethod
    def kitti(cls) -> Camera:
        """The left colour camera of KITTI's 26 September 2011: 1242 x 375 pixels."""
        return cls()

    def resized(self, width: int, height: int) -> Camera:
        """Return the camera of the image scaled to `width` x `height`, as resizing the image would have it."""
        x, y = width / self.width, height / self.height
        return Camera(
            width=width,
            height=height,
            fx=self.fx * x,
            fy=self.fy * y,
            cx=(self.cx + 0.5) * x - 0.5,
            cy=(self.cy + 0.5) * y - 0.5,
            cam2_from_cam0_m=self.cam2_from_cam0_m,
        )

    def projection(self, offset_m: tuple[float, float, float]) -> NDArray[np.float64]:
        """Return the (3, 4) projection of a camera with these intrinsics that sees camera 0 at `offset_m`."""
        k = np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])
        # Rounded to what a calib file's reader would see, so that file and memory agree.
        return np.round(np.hstack([k, k @ np.array(offset_m)[:, None]]), 9)


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A LIDAR and a camera on the ego vehicle, both level with it.

    Raises:
        CadetError: a number outside its range.
    """

    name: str = "custom"
    """For the metadata."""
    lidar: Lidar = Lidar("hdl64e_kitti")
    """The LIDAR."""
    camera: Camera = Camera()
    """The camera that renders the image."""
    velo_in_ego_m: tuple[float, float, float] = (0.0, 0.0, 1.73)
    """The LIDAR in the ego's frame: forward, left, and up from the road."""
    cam0_in_velo_m: tuple[float, float, float] = (0.27, 0.0, -0.08)
    """Camera 0 in the LIDAR's frame: forward, left, up."""

    def __post_init__(self) -> None:
        if not isinstance(self.lidar, Lidar):
            raise CadetError(f"Rig.lidar: expected a Lidar, got {self.lidar!r}")
        if not isinstance(self.camera, Camera):
            raise CadetError(f"Rig.camera: expected a Camera, got {self.camera!r}")
        for name in ("velo_in_ego_m", "cam0_in_velo_m"):
            values = getattr(self, name)
            if not isinstance(values, tuple) or len(values) != 3:
                raise CadetError(f"Rig.{name}: expected three numbers, got {values!r}")
            for value in values:
                check_number("Rig", name, value, -20, 20)

    @classmethod
    def kitti(cls) -> Rig:
        """KITTI's car: HDL-64E 1.73 m up, camera 0 0.27 m ahead of it and 0.08 m lower, the image from camera 2."""
        return cls(name="kitti")

    @classmethod
    def paper(cls) -> Rig:
        """The 2019 paper's rig: LIDAR and camera in one point, KITTI's beams from one origin, no P2 offset."""
        return cls(
            name="paper",
            lidar=Lidar("hdl64e_kitti", single_origin=True),
            camera=Camera(cam2_from_cam0_m=(0.0, 0.0, 0.0)),
            cam0_in_velo_m=(0.0, 0.0, 0.0),
        )

    def to_native(self) -> RigDict:
        """Return the rig as the core takes it."""
        camera = self.camera
        x, y, z = self.cam0_in_velo_m
        # Axes from velo (forward, left, up) to cam (right, down, forward), then the shift to camera 0.
        velo_to_cam = np.array([[0.0, -1.0, 0.0, y], [0.0, 0.0, -1.0, z], [1.0, 0.0, 0.0, -x]])
        stereo = {"P0": 0.0, "P1": -0.5371506, "P3": -0.4731033}
        if self.camera.cam2_from_cam0_m == (0.0, 0.0, 0.0):
            stereo = dict.fromkeys(stereo, 0.0)
        others = {key: camera.projection((shift, 0.0, 0.0)) for key, shift in stereo.items()}
        return RigDict(
            name=self.name,
            lidar=self.lidar.name if self.lidar.table is None else self.lidar.table.to_native(),
            single_origin=self.lidar.single_origin,
            rolling=self.lidar.rolling,
            returns=self.lidar.returns,
            divergence_mrad=float(self.lidar.divergence_mrad),
            velo_in_ego=[float(v) for v in self.velo_in_ego_m],
            camera=CameraDict(
                width=int(camera.width),
                height=int(camera.height),
                P0=others["P0"],
                P1=others["P1"],
                P2=camera.projection(camera.cam2_from_cam0_m),
                P3=others["P3"],
                R0_rect=np.eye(3),
                Tr_velo_to_cam=velo_to_cam,
                Tr_imu_to_velo=np.eye(3, 4),
            ),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the rig in plain numbers, for a manifest."""
        native = self.to_native()
        camera = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in native["camera"].items()}
        beams = self.lidar.to_native().table()
        return {**native, "camera": camera, "range_m": [beams["min_range_m"], beams["max_range_m"]]}
