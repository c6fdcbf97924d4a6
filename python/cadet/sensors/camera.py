"""The camera, as calibration files describe it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.checks import Limits, check_fields, check_number, check_three, is_one_of, make_plain, shown
from cadet._util.plain_tables import check_keys, object_of_table, table_of_object
from cadet._util.toml_file import TomlFile
from cadet.errors import CadetError
from cadet.sensors.kitti_calibrations import MOST_FREQUENT, KittiCalibration, Row3, kitti_calibration


def _offset_m(calibration: KittiCalibration, column: Row3) -> Row3:
    """Return where camera 0 stands in the frame of the camera with that fourth column of its projection."""
    (u, v, z), (cx, cy), focal_px = column, calibration.center_px, calibration.focal_px
    return (u - cx * z) / focal_px, (v - cy * z) / focal_px, z


_HERE: Row3 = (0.0, 0.0, 0.0)

MAX_PIXELS = 1 << 24
"""The most pixels of an image that is made, 4096 x 4096: a frame takes about 70 bytes of memory for each."""


MODELS = ("pinhole", "fisheye")
"""How rays become pixels."""
RESPONSES = ("linear", "srgb")
"""How values follow the light; others are given as points."""
_UNNAMED = ("motion_blur_s", "exposure_ev", "noise", "white_balance", "response", "model")
"""Fields that no manifest names where they are KITTI's."""
_RESPONSE = '"linear", "srgb", or points (light, value) that rise from (0, 0) to (1, 1)'
_RARE = ("image_scale", "distortion", "rolling_shutter_s", *_UNNAMED)
_INTRINSICS = ("width", "height", "fx", "fy", "cx", "cy")
_OFFSETS = ("cam1_from_cam0_m", "cam2_from_cam0_m", "cam3_from_cam0_m")


def _check_side(name: str, size: object) -> None:
    least, most = _cadet.limits()["image_side_px"]
    check_number("Camera", name, size, int(least), int(most), whole=True)


def _check_response(response: object) -> None:
    if is_one_of(response, RESPONSES):
        return
    least, most = _cadet.limits()["curve_points"]
    points: tuple[Any, ...] = response if isinstance(response, tuple) else ()
    is_curve = least <= len(points) <= most and all(isinstance(point, tuple) and len(point) == 2 for point in points)
    if is_curve:
        for share in (share for point in points for share in point):
            check_number("Camera", "response", share, 0, 1)
        rises = all(a[0] < b[0] and a[1] <= b[1] for a, b in pairwise(points))
        is_curve = rises and (points[0], points[-1]) == ((0, 0), (1, 1))
    if not is_curve:
        raise CadetError(f"Camera.response: expected {_RESPONSE}, got {shown(response)}")


@dataclass(frozen=True, kw_only=True)
class Camera(TomlFile):
    """A camera by its intrinsics; `kitti`, `from_fov`, and `fisheye` derive them.

    Labels stand in the frame of KITTI's camera 0, and the image is that of camera 2, the left color camera. The four
    cameras have the same intrinsics, and all are one unless it is told where the others stand.

    Raises:
        CadetError: a number outside its range.
    """

    width: int
    """Pixels."""
    height: int
    """Pixels."""
    fx: Annotated[float, Limits(1, 1e6)]
    """Focal length along the rows, pixels; of a fisheye, pixels a radian."""
    fy: Annotated[float, Limits(1, 1e6)]
    """Focal length along the columns, likewise."""
    cx: Annotated[float, Limits(-1e6, 1e6)]
    """Column of the optical axis; (0, 0) is the center of the top-left pixel."""
    cy: Annotated[float, Limits(-1e6, 1e6)]
    """Row of the optical axis."""
    cam1_from_cam0_m: Row3 = _HERE
    """Where camera 0 stands in the frame of camera 1, the right gray one: the translation behind P1's fourth column."""
    cam2_from_cam0_m: Row3 = _HERE
    """Where camera 0 stands in the frame of camera 2, which takes the image: from P2's fourth column."""
    cam3_from_cam0_m: Row3 = _HERE
    """Where camera 0 stands in the frame of camera 3, the right color one: from P3's fourth column."""
    image_scale: Annotated[tuple[float, float], Limits(1e-4, 1e4)] = (1.0, 1.0)
    """By what the image was scaled along the rows and the columns (`resized`); labels' pixel limits follow."""

    distortion: Annotated[tuple[float, float, float, float, float], Limits(-100, 100)] = (0.0, 0.0, 0.0, 0.0, 0.0)
    """k1, k2, p1, p2, k3 of OpenCV's lens model; all 0 for the rectified image that KITTI's files hold."""
    rolling_shutter_s: float = 0.0
    """Seconds from the first row's exposure to the last's, about the frame's instant, 0 to 0.1; 0: a global shutter."""

    motion_blur_s: float = 0.0
    """Seconds for which each row gathers light, about its own time, 0 to 0.05; 0: what moves is sharp."""
    model: str = "pinhole"
    """How rays become pixels: "pinhole", or "fisheye", the equidistant one: what is seen at an angle a to the optical
    axis lies f a from the center, up to 95 degrees, beyond which the image is black. It has no distortion,
    rolling shutter, motion blur, or labels, and depth along its rays."""
    exposure_ev: float = 0.0
    """Stops by which the image is brighter than the meter has it, -8 to 8."""
    noise: float = 1.0
    """Standard deviation of the sensor's noise in units of that of KITTI's cameras, 0 to 16."""
    white_balance: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Factors of red, green, and blue beside KITTI's own white balance, 0.125 to 8 each."""
    response: str | tuple[tuple[float, float], ...] = "linear"
    """How values follow the light: "linear" as KITTI's, "srgb", or a curve of 2 to 1024 points (light, value) in shares
    of white that rise from (0, 0) to (1, 1), with straight lines between. Behind a curve the
    meter aims at middle gray, 18 % of white."""

    def __post_init__(self) -> None:
        make_plain(self)
        for name in ("width", "height"):
            _check_side(name, getattr(self, name))
        if self.width * self.height > MAX_PIXELS:
            raise CadetError(f"Camera: {self.width} x {self.height} pixels, expected at most {MAX_PIXELS}")
        for name in _OFFSETS:
            check_three("Camera", name, getattr(self, name), 10)
        if not isinstance(self.image_scale, tuple) or len(self.image_scale) != 2:
            raise CadetError(f"Camera.image_scale: expected two numbers, got {shown(self.image_scale)}")
        if not isinstance(self.distortion, tuple) or len(self.distortion) != 5:
            raise CadetError(f"Camera.distortion: expected k1, k2, p1, p2, k3, got {shown(self.distortion)}")
        check_fields(self)
        limits = _cadet.limits()
        for name in ("rolling_shutter_s", "motion_blur_s", "exposure_ev", "noise"):
            check_number("Camera", name, getattr(self, name), *limits[name])
        if not isinstance(self.white_balance, tuple) or len(self.white_balance) != 3:
            raise CadetError(f"Camera.white_balance: expected three numbers, got {shown(self.white_balance)}")
        for factor in self.white_balance:
            check_number("Camera", "white_balance", factor, *limits["white_balance"])
        _check_response(self.response)
        self._check_model()

    def _check_model(self) -> None:
        if not is_one_of(self.model, MODELS):
            raise CadetError(f"Camera.model: expected {' or '.join(MODELS)}, got {shown(self.model)}")
        for name in ("distortion", "rolling_shutter_s", "motion_blur_s") if self.model == "fisheye" else ():
            if np.any(getattr(self, name)):
                raise CadetError(f"Camera.{name}: a fisheye has none")

    def __repr__(self) -> str:
        usual = {f.name: f.default for f in fields(self) if f.name in _RARE}
        parts = {f.name: getattr(self, f.name) for f in fields(self)}
        shown = {name: value for name, value in parts.items() if name not in usual or value != usual[name]}
        return f"Camera({', '.join(f'{name}={value!r}' for name, value in shown.items())})"

    @classmethod
    def kitti(cls, *, calibration: str = MOST_FREQUENT) -> Camera:
        """KITTI's left color camera: 1242 x 375 pixels on 26 September 2011, other sizes on other days.

        Raises:
            CadetError: a calibration that KITTI does not have.
        """
        figures = kitti_calibration(calibration)
        return cls(
            width=figures.image_size[0],
            height=figures.image_size[1],
            fx=figures.focal_px,
            fy=figures.focal_px,
            cx=figures.center_px[0],
            cy=figures.center_px[1],
            cam1_from_cam0_m=_offset_m(figures, figures.p1_column),
            cam2_from_cam0_m=_offset_m(figures, figures.p2_column),
            cam3_from_cam0_m=_offset_m(figures, figures.p3_column),
        )

    @classmethod
    def from_fov(
        cls,
        width: int,
        height: int,
        *,
        horizontal_deg: float,
        distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0),
        rolling_shutter_s: float = 0.0,
    ) -> Camera:
        """Return a camera with square pixels whose optical axis goes through the middle of the image.

        Args:
            width: pixels.
            height: pixels.
            horizontal_deg: what it sees from the left edge to the right one, lens distortion aside, 1 to 175 degrees.
            distortion: as in a camera.
            rolling_shutter_s: as in a camera.

        Raises:
            CadetError: a number outside its range.
        """
        _check_side("width", width)
        _check_side("height", height)
        check_number("Camera", "horizontal_deg", horizontal_deg, 1, 175)
        # Rounded, since the last bit of a tangent differs between machines.
        focal_px = round(width / 2 / math.tan(math.radians(horizontal_deg) / 2), 9)
        return cls(
            width=width,
            height=height,
            fx=focal_px,
            fy=focal_px,
            cx=(width - 1) / 2,
            cy=(height - 1) / 2,
            distortion=distortion,
            rolling_shutter_s=rolling_shutter_s,
        )

    @classmethod
    def fisheye(cls, width: int, height: int, *, fov_deg: float = 190.0) -> Camera:
        """Return an equidistant fisheye whose optical axis goes through the middle of the image.

        Args:
            width: pixels.
            height: pixels.
            fov_deg: what it sees from the left edge to the right one, 1 to 190 degrees.

        Raises:
            CadetError: a number outside its range.
        """
        _check_side("width", width)
        _check_side("height", height)
        check_number("Camera", "fov_deg", fov_deg, 1, 190)
        focal_px = round(width / math.radians(fov_deg), 9)
        return cls(
            width=width,
            height=height,
            fx=focal_px,
            fy=focal_px,
            cx=(width - 1) / 2,
            cy=(height - 1) / 2,
            model="fisheye",
        )

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> Camera:
        check_keys(table, tuple(f.name for f in fields(cls)), _INTRINSICS, place)
        return object_of_table(cls, table, folder, place)

    def _table(self) -> dict[str, Any]:
        usual = {f.name: f.default for f in fields(self)}
        return {key: value for key, value in table_of_object(self).items() if getattr(self, key) != usual[key]}

    def resized(self, width: int, height: int) -> Camera:
        """Return the camera of the image scaled to `width` x `height`, as resizing the image would have it.

        Raises:
            CadetError: a size that is no whole number of pixels, or out of range.
        """
        for name, size in (("width", width), ("height", height)):
            _check_side(name, size)
        x, y = width / self.width, height / self.height
        return replace(
            self,
            width=width,
            height=height,
            fx=self.fx * x,
            fy=self.fy * y,
            cx=(self.cx + 0.5) * x - 0.5,
            cy=(self.cy + 0.5) * y - 0.5,
            image_scale=(self.image_scale[0] * x, self.image_scale[1] * y),
        )

    def unusual(self) -> dict[str, Any]:
        """Return what most cameras do not have, in plain values for a manifest."""
        table = table_of_object(self)
        return {f.name: table[f.name] for f in fields(self) if f.name in _RARE and getattr(self, f.name) != f.default}

    def to_dict(self) -> dict[str, Any]:
        """Return the camera in plain numbers, for a manifest."""
        return {name: value for name, value in asdict(self).items() if name not in _UNNAMED} | self.unusual()

    def _to_native(self, name: str, projection: NDArray[np.float64], mount: list[_cadet.Pose]) -> _cadet.Camera:
        """Return the camera as the core takes it.

        Args:
            name: names its images.
            projection: one of `projections`.
            mount: poses that lead from the ego to the camera's frame.
        """
        return _cadet.Camera(
            name,
            width=int(self.width),
            height=int(self.height),
            is_fisheye=self.model == "fisheye",
            projection=projection,
            distortion=[float(k) for k in self.distortion],
            rolling_shutter_s=float(self.rolling_shutter_s),
            motion_blur_s=float(self.motion_blur_s),
            exposure_ev=float(self.exposure_ev),
            noise=float(self.noise),
            white_balance=[float(factor) for factor in self.white_balance],
            response=self.response,
            mount=mount,
        )

    def projection(self, offset_m: Row3) -> NDArray[np.float64]:
        """Return the (3, 4) projection of a camera with these intrinsics that sees camera 0 at `offset_m`."""
        x, y, z = offset_m
        matrix = [
            [self.fx, 0.0, self.cx, self.fx * x + self.cx * z],
            [0.0, self.fy, self.cy, self.fy * y + self.cy * z],
            [0.0, 0.0, 1.0, z],
        ]
        # Rounded to what a calib file's reader would see, so that file and memory agree.
        return np.round(np.array(matrix), 9)

    def projections(self) -> dict[str, NDArray[np.float64]]:
        """Return the (3, 4) projections of the four cameras by KITTI's keys."""
        return {
            "P0": self.projection((0.0, 0.0, 0.0)),
            "P1": self.projection(self.cam1_from_cam0_m),
            "P2": self.projection(self.cam2_from_cam0_m),
            "P3": self.projection(self.cam3_from_cam0_m),
        }
