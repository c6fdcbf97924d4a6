"""How samples are changed in training beyond what AVOD does: all off, frozen, checked when made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cadet._util.checks import Limits, check_fields
from cadet.errors import CadetError


@dataclass(frozen=True, kw_only=True)
class AugmentationConfig:
    """Changes of a training sample. Everything is drawn from (seed, place in the order of training); 0 is off.

    Points, plane, boxes, and camera change together, so that every point keeps its pixel, except where said otherwise.

    Raises:
        CadetError: a number outside its range.
    """

    rotation_deg: Annotated[float, Limits(0, 45)] = 0.0
    """The sample is turned about the cam frame's vertical axis by up to this, left or right."""
    scaling: Annotated[float, Limits(0, 0.5)] = 0.0
    """The sample, the camera's height too, is scaled by 1 - this to 1 + this."""
    translation_m: Annotated[tuple[float, float, float], Limits(0, 10)] = (0.0, 0.0, 0.0)
    """The sample is moved by up to this along x, y, and z of the cam frame, to either side."""
    point_dropout: Annotated[float, Limits(0, 0.95)] = 0.0
    """Up to this share of the points is left out; the share is drawn for each sample."""
    range_noise_m: Annotated[float, Limits(0, 1)] = 0.0
    """Standard deviation of noise along the beams. Points move along their rays from the LIDAR, not the camera's."""
    object_scaling: Annotated[float, Limits(0, 0.5)] = 0.0
    """Each object's length, width, and height, with the points in it, are scaled by 1 - this to 1 + this, each on its
    own, about the center of its bottom. The image keeps the object as it is."""
    object_sizes_lwh_m: Annotated[tuple[tuple[float, float, float], ...], Limits(0.01, 50)] = ()
    """The mean sizes, class by class, of the objects that the detector is meant for: each object's size, with the
    points in it, is shifted by how much they differ from the training set's. The image keeps the object as it is.
    Statistical normalization: Wang et al., "Train in Germany, Test in the USA" (2020)."""
    brightness: Annotated[float, Limits(0, 1)] = 0.0
    """Up to this share of white is added to all colors, or taken off."""
    contrast: Annotated[float, Limits(0, 1)] = 0.0
    """Colors' distances from the image's mean gray are multiplied by 1 - this to 1 + this."""
    hue_deg: Annotated[float, Limits(0, 180)] = 0.0
    """Colors are turned about the gray axis by up to this, either way."""
    pasted_objects: Annotated[int, Limits(0, 64)] = 0
    """Up to so many objects of the bank (`--bank`) are pasted into a frame."""

    def __post_init__(self) -> None:
        check_fields(self)

    def check_classes(self, count: int) -> None:
        """Refuse mean sizes of another number of classes.

        Raises:
            CadetError: some, but not one for each class.
        """
        if self.object_sizes_lwh_m and len(self.object_sizes_lwh_m) != count:
            raise CadetError(
                f"AugmentationConfig.object_sizes_lwh_m: expected a size for each of {count} classes, "
                f"got {len(self.object_sizes_lwh_m)}"
            )
