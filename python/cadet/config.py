"""What a scene contains and what gets a label: frozen, checked when made, unknown keys refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any, Literal, TypeVar

from cadet.checks import check_kind, check_number, is_one_of, make_plain, shown
from cadet.errors import CadetError

T = TypeVar("T")

VEHICLE_CLASSES = ("Car", "Van", "Truck")
"""KITTI's classes of vehicles that drive and park."""


def from_dict(cls: type[T], values: Mapping[str, Any]) -> T:
    """Make a configuration from a dictionary, refusing keys that it does not have.

    Raises:
        CadetError: an unknown key, or a value that the configuration refuses.
    """
    known = [f.name for f in fields(cls)]  # type: ignore[arg-type]
    unknown = sorted(set(values) - set(known))
    if unknown:
        raise CadetError(f"{cls.__name__}: unknown key {unknown[0]!r}; known: {', '.join(known)}")
    return cls(**values)


@dataclass(frozen=True, kw_only=True)
class LabelConfig:
    """Every number of the labels' definitions.

    Raises:
        CadetError: a number outside its range, or an unknown method.
    """

    method: Literal["pixels", "corners"] = "pixels"
    """How occlusion is measured: visible over silhouette pixels, or box corners against the depth map (the paper's)."""
    boxes: Literal["kitti", "exact"] = "kitti"
    """Which boxes labels hold: what KITTI's annotators would have drawn, or the extents of the body.

    Annotators' boxes are a little shorter than the vehicle, their bottoms a little over the ground, and their sizes
    are distributed as KITTI's; an actor keeps its box through an episode."""
    min_height_px: float = 15.0
    """A label's 2D box is at least this high, in the image before it is resized (`Camera.resized`, `--image-size`)."""
    min_visible_fraction: float = 0.1
    """A label's object shows at least this fraction of its silhouette."""
    max_depth_m: float = 80.0
    """A label's object is at most this deep."""
    min_depth_m: float = 0.5
    """A label's object is at least this deep."""
    max_truncation: float = 0.95
    """A label's object is truncated by at most this."""
    min_contrast: float = 0.05
    """An object without returns keeps at least this much of its contrast through fog, rain and snow to get a label."""
    min_points: int = 0
    """A label's object has at least this many returns."""
    dontcare_min_pixels: float = 8.0
    """An object without a label becomes DontCare if it shows at least this many pixels, in the image before it is
    resized."""
    occlusion_levels: tuple[float, float] = (0.8, 0.5)
    """Visible fractions from which `occluded` is 0 and 1; below the second it is 2."""
    corner_tolerance_m: float = 0.1
    """A corner is hidden by what is nearer than it by more than this."""
    max_hidden_corners: int = 4
    """With this many hidden corners an object is occluded (method "corners")."""

    def scaled(self, image_scale: tuple[float, float]) -> LabelConfig:
        """Return the limits for an image that was stretched: heights follow its rows, counts of pixels its area.

        Args:
            image_scale: factors along the rows and the columns, as in `Camera.image_scale`.
        """
        x, y = image_scale
        return replace(
            self, min_height_px=self.min_height_px * y, dontcare_min_pixels=self.dontcare_min_pixels * (x * y)
        )

    def __post_init__(self) -> None:
        if not is_one_of(self.method, ("pixels", "corners")):
            raise CadetError(f"LabelConfig.method: expected 'pixels' or 'corners', got {shown(self.method)}")
        if not is_one_of(self.boxes, ("kitti", "exact")):
            raise CadetError(f"LabelConfig.boxes: expected 'kitti' or 'exact', got {shown(self.boxes)}")
        check_number("LabelConfig", "min_height_px", self.min_height_px, 0)
        check_number("LabelConfig", "min_visible_fraction", self.min_visible_fraction, 0, 1)
        check_number("LabelConfig", "max_depth_m", self.max_depth_m, 0)
        check_number("LabelConfig", "min_depth_m", self.min_depth_m, 0)
        check_number("LabelConfig", "max_truncation", self.max_truncation, 0, 1)
        check_number("LabelConfig", "min_contrast", self.min_contrast, 0, 1)
        check_number("LabelConfig", "min_points", self.min_points, 0, 1_000_000, whole=True)
        check_number("LabelConfig", "dontcare_min_pixels", self.dontcare_min_pixels, 0)
        check_number("LabelConfig", "corner_tolerance_m", self.corner_tolerance_m, 0)
        check_number("LabelConfig", "max_hidden_corners", self.max_hidden_corners, 1, 8, whole=True)
        levels = self.occlusion_levels
        if not isinstance(levels, tuple) or len(levels) != 2:
            raise CadetError(f"LabelConfig.occlusion_levels: expected two fractions, got {shown(levels)}")
        for level in levels:
            check_number("LabelConfig", "occlusion_levels", level, 0, 1)
        if levels[0] < levels[1]:
            raise CadetError(f"LabelConfig.occlusion_levels: expected the first to be the larger, got {levels!r}")
        make_plain(self)


def check_vehicle_classes(owner: str, classes: object) -> None:
    """Refuse what is no tuple of vehicle classes, "Car" among them.

    Raises:
        CadetError: naming the owner and the classes.
    """
    is_known = isinstance(classes, tuple) and all(is_one_of(name, VEHICLE_CLASSES) for name in classes)
    if not is_known or "Car" not in classes:  # type: ignore[operator]
        names = ", ".join(VEHICLE_CLASSES)
        raise CadetError(f"{owner}.vehicle_classes: expected a tuple of {names}, Car among them, got {shown(classes)}")


@dataclass(frozen=True, kw_only=True)
class SceneConfig:
    """How full a scene is, and what gets a label.

    Raises:
        CadetError: a number outside its range.
    """

    num_cars: int = 14
    """Driving vehicles kept around the ego: cars, one in eleven a van; trucks only among a user's own (`assets`)."""
    num_pedestrians: int = 24
    """People on foot kept around the ego; nobody rides a bicycle."""
    parking_occupancy: float = 0.6
    """Share of the parking places along the ego's way that are taken; each street varies around it.

    In side streets and drives it is this to the power of 0.35."""
    vehicle_classes: tuple[str, ...] = VEHICLE_CLASSES
    """Classes of the vehicles that drive and park, "Car" among them, mixed as on KITTI's streets.

    Trucks come from the user's own vehicles alone."""
    label: LabelConfig = field(default_factory=LabelConfig)
    """What gets a label."""

    def __post_init__(self) -> None:
        for name in ("num_cars", "num_pedestrians"):
            check_number("SceneConfig", name, getattr(self, name), 0, 500, whole=True)
        check_number("SceneConfig", "parking_occupancy", self.parking_occupancy, 0, 1)
        check_vehicle_classes("SceneConfig", self.vehicle_classes)
        check_kind("SceneConfig", "label", self.label, LabelConfig)
        make_plain(self)

    def to_native(self, image_scale: tuple[float, float] = (1.0, 1.0)) -> dict[str, Any]:
        """Return the fields as the core takes them: a flat dictionary whose `label` is a dictionary too.

        Args:
            image_scale: that of the camera; the labels' pixel limits are scaled with it.
        """
        return asdict(replace(self, label=self.label.scaled(image_scale)))
