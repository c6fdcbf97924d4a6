"""What a scene contains and what gets a label: frozen, checked when made."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal

from cadet import _cadet
from cadet.checks import check_kind, check_number, is_one_of, make_plain, shown
from cadet.errors import CadetError

VEHICLE_CLASSES = ("Car", "Van", "Truck")
"""KITTI's classes of vehicles that drive and park."""


_NUMBERS = dict(_cadet.LabelConfig.settings())
"""Default, least and greatest value of every number, and whether it counts."""


def _default(name: str) -> Any:
    default, _, _, is_whole = _NUMBERS[name]
    return int(default) if is_whole else default


def _shortest(limit: float) -> float:
    """Return a limit as messages show it: 8 for 8.0."""
    return int(limit) if limit.is_integer() else limit


@dataclass(frozen=True, kw_only=True)
class LabelConfig:
    """Every number of the labels' definitions; the core states their defaults and limits.

    Raises:
        CadetError: a number outside its range, or an unknown method.
    """

    method: Literal["pixels", "corners"] = "pixels"
    """How occlusion is measured: visible over silhouette pixels, or box corners against the depth map (the paper's)."""
    boxes: Literal["kitti", "exact"] = "kitti"
    """Which boxes labels hold: what KITTI's annotators would have drawn, or the extents of the body.

    Annotators' boxes are a little shorter than the vehicle, their bottoms a little over the ground, and their sizes
    are distributed as KITTI's; an actor keeps its box through an episode."""
    min_height_px: float = _default("min_height_px")
    """A label's 2D box is at least this high, in the image before it is resized (`Camera.resized`, `--image-size`)."""
    min_visible_fraction: float = _default("min_visible_fraction")
    """A label's object shows at least this fraction of its silhouette."""
    max_depth_m: float = _default("max_depth_m")
    """A label's object is at most this deep."""
    min_depth_m: float = _default("min_depth_m")
    """A label's object is at least this deep."""
    max_truncation: float = _default("max_truncation")
    """A label's object is truncated by at most this."""
    min_contrast: float = _default("min_contrast")
    """An object without returns keeps at least this much of its contrast through fog, rain and snow to get a label."""
    min_points: int = _default("min_points")
    """A label's object has at least this many returns."""
    dontcare_min_pixels: float = _default("dontcare_min_pixels")
    """An object without a label becomes DontCare if it shows at least this many pixels, in the image before it is
    resized."""
    occlusion_levels: tuple[float, float] = _cadet.LabelConfig.default_occlusion_levels()
    """Visible fractions from which `occluded` is 0 and 1; below the second it is 2."""
    corner_tolerance_m: float = _default("corner_tolerance_m")
    """A corner is hidden by what is nearer than it by more than this."""
    max_hidden_corners: int = _default("max_hidden_corners")
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
        for name, (_, least, most, is_whole) in _NUMBERS.items():
            check_number("LabelConfig", name, getattr(self, name), _shortest(least), _shortest(most), whole=is_whole)
        levels = self.occlusion_levels
        if not isinstance(levels, tuple) or len(levels) != 2:
            raise CadetError(f"LabelConfig.occlusion_levels: expected two fractions, got {shown(levels)}")
        for level in levels:
            check_number("LabelConfig", "occlusion_levels", level, 0, 1)
        if levels[0] < levels[1]:
            raise CadetError(f"LabelConfig.occlusion_levels: expected the first to be the larger, got {levels!r}")
        make_plain(self)

    def to_native(self) -> _cadet.LabelConfig:
        """Return the numbers as the core takes them."""
        return _cadet.LabelConfig(**asdict(self))


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

    def scaled(self, image_scale: tuple[float, float]) -> SceneConfig:
        """Return the configuration for an image that was stretched: see `LabelConfig.scaled`."""
        return replace(self, label=self.label.scaled(image_scale))

    def to_native(self) -> _cadet.SceneConfig:
        """Return the configuration as the core takes it."""
        return _cadet.SceneConfig(
            num_cars=self.num_cars,
            num_pedestrians=self.num_pedestrians,
            parking_occupancy=float(self.parking_occupancy),
            vehicle_classes=list(self.vehicle_classes),
            label=self.label.to_native(),
        )
