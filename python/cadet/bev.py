"""Bird's-eye-view maps of a point cloud: the input of AVOD and detectors like it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.arrays import check_array
from cadet._util.checks import Limits, as_tuple, check_fields, check_kind, check_range, is_one_of, make_plain, shown
from cadet.errors import CadetError, ShapeError

Feature = Literal["max_height", "min_height", "density", "density_log64"]
"""A map: greatest or least height of a cell's points, or min(1, ln(N + 1) / ln 16)."""

MAX_VALUES: Final = 2**27
"""The most values that the maps of a point cloud may have, half a gigabyte; AVOD's have 3,360,000."""


@dataclass(frozen=True, kw_only=True)
class BevConfig:
    """Which maps there are, and over which part of the world.

    Heights are over the ground plane, as shares of the slice's thickness (slice maps) or of the whole range of heights
    (cloud maps). The channels are the slice maps of each slice, from the lowest slice up and in the order of the list,
    then the cloud maps.

    Raises:
        CadetError: a number outside its range, an unknown feature, no map at all, cells that do not fill the range,
            or more than `MAX_VALUES` values.

    Reference: "Multimodal 3D Object Detection from Simulated Pretraining" (2019), section on BEV configurations; the
    ranges are AVOD's.
    """

    slice_maps: tuple[Feature, ...] = ("max_height",)
    """Maps of each slice."""
    cloud_maps: tuple[Feature, ...] = ("density",)
    """Maps of the whole cloud."""
    num_slices: Annotated[int, Limits(1, 1000)] = 5
    """Slices between `height_lo_m` and `height_hi_m`, all of one thickness."""
    height_lo_m: Annotated[float, Limits(-100, 100)] = -0.2
    """Lowest height over the ground plane."""
    height_hi_m: Annotated[float, Limits(-100, 100)] = 2.3
    """Height over the ground plane where the last slice ends."""
    x_m: tuple[float, float] = (-40.0, 40.0)
    """Range to the left and to the right, camera frame."""
    y_m: tuple[float, float] = (-5.0, 3.0)
    """Range down from the camera; points outside are left out whatever their height over the plane."""
    z_m: tuple[float, float] = (0.0, 70.0)
    """Range ahead, camera frame."""
    cell_m: Annotated[float, Limits(1e-3, 100)] = 0.1
    """Side of a cell."""
    height: Literal["max", "reference"] = "max"
    """The greatest height of a cell's points, or that of the point which AVOD's own code takes for it: the first in
    the scan's order among those in the topmost `cell_m` of the y axis. Least heights are the least in both."""

    def __post_init__(self) -> None:
        make_plain(self)
        for name in ("slice_maps", "cloud_maps"):
            features = as_tuple("BevConfig", name, getattr(self, name), "maps' names")
            object.__setattr__(self, name, features)
            for feature in features:
                if not is_one_of(feature, get_args(Feature)):
                    raise CadetError(f"BevConfig.{name}: expected {', '.join(get_args(Feature))}, got {shown(feature)}")
        if not self.slice_maps and not self.cloud_maps:
            raise CadetError("BevConfig: expected at least one slice map or cloud map, got none")
        check_fields(self)
        if self.height_lo_m >= self.height_hi_m:
            raise CadetError(
                f"BevConfig.height_hi_m: expected more than {self.height_lo_m:g}, got {self.height_hi_m!r}"
            )
        for name in ("x_m", "y_m", "z_m"):
            check_range("BevConfig", name, getattr(self, name), -1000, 1000)
            low, high = getattr(self, name)
            if name == "y_m":
                if low >= high:
                    raise CadetError(f"BevConfig.y_m: expected a range that rises, got {(low, high)!r}")
                continue
            cells = (high - low) / self.cell_m
            if round(cells) < 1 or abs(cells - round(cells)) > 1e-6:
                raise CadetError(f"BevConfig.{name}: expected whole cells of {self.cell_m:g} m, got {(low, high)!r}")
        num_values = math.prod(self.shape)
        if num_values > MAX_VALUES:
            channels, rows, columns = self.shape
            raise CadetError(
                f"BevConfig: expected maps of at most {MAX_VALUES:,} values, "
                f"got {channels} channels of {rows} x {columns} cells of {self.cell_m:g} m"
            )
        if not is_one_of(self.height, ("max", "reference")):
            raise CadetError(f"BevConfig.height: expected 'max' or 'reference', got {shown(self.height)}")

    @classmethod
    def default(cls) -> BevConfig:
        """AVOD's own: the greatest height of five slices, and the cloud's density."""
        return cls()

    @classmethod
    def max3_density3(cls) -> BevConfig:
        """The greatest height and the density of three slices."""
        return cls(slice_maps=("max_height", "density"), cloud_maps=(), num_slices=3)

    @classmethod
    def max_min_density(cls) -> BevConfig:
        """The cloud's greatest height, least height and density: half of the others' channels."""
        return cls(slice_maps=(), cloud_maps=("max_height", "min_height", "density"))

    @property
    def shape(self) -> tuple[int, int, int]:
        """(C, H, W): channels, cells ahead, cells across."""
        rows = round((self.z_m[1] - self.z_m[0]) / self.cell_m)
        columns = round((self.x_m[1] - self.x_m[0]) / self.cell_m)
        return len(self.slice_maps) * self.num_slices + len(self.cloud_maps), rows, columns

    def _to_native(self) -> _cadet.BevConfig:
        """Return the configuration as the core takes it."""
        return _cadet.BevConfig(
            slice_maps=self.slice_maps,
            cloud_maps=self.cloud_maps,
            num_slices=self.num_slices,
            height_m=(self.height_lo_m, self.height_hi_m),
            range_cam_m=(self.x_m, self.y_m, self.z_m),
            cell_m=self.cell_m,
            height=self.height,
        )


def maps(
    points_cam: NDArray[np.floating[Any]],
    plane: NDArray[np.floating[Any]],
    config: BevConfig | None = None,
    out: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]:
    """Make the maps of a point cloud. No image filter inside: see `cadet.kitti.points_in_image`.

    Args:
        points_cam: (N, 3) or wider, float32 or float64, meters, frame of camera 0. May be empty.
        plane: (4,) a, b, c, d of the ground in the same frame, of any length and sign.
        config: which maps; AVOD's own by default.
        out: (C, H, W) float32, C-contiguous and aligned, to be overwritten: a fresh array costs about as much as the
            maps.

    Returns:
        (C, H, W) float32, `out` if given. Row 0 is farthest, column 0 leftmost; cells without points are 0.

    Raises:
        ShapeError: an array of another shape or dtype.
        NonFiniteError: NaN or infinity in the points or the plane.
        CadetError: a plane without a vertical part of its normal.

    Reference: AVOD (Ku et al., 2018), section III.A; its configurations: "Multimodal 3D Object Detection from Simulated
    Pretraining" (2019).
    """
    config = BevConfig.default() if config is None else config
    check_kind("", "config", config, BevConfig)
    check_array(points_cam, "points_cam", ("N", "C"), finite=True)
    if points_cam.dtype not in (np.float32, np.float64):
        raise ShapeError(f"points_cam: expected float32 or float64, got {points_cam.dtype.name}")
    check_array(plane, "plane", (4,), finite=True)
    if out is not None:
        check_array(out, "out", config.shape, np.float32)
        if not (out.flags.c_contiguous and out.flags.writeable and out.flags.aligned):
            raise ShapeError("out: expected a writeable, aligned array in C order")
    return _cadet.bev_maps(points_cam, [float(v) for v in plane], config._to_native(), out)
