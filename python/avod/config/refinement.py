"""The numbers of the stage that corrects boxes by the points in them: frozen, checked when made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cadet._util.checks import Limits, check_fields


@dataclass(frozen=True, kw_only=True)
class RefinementConfig:
    """A last stage that looks at the points in and around a found box, corrects it, and judges it; AVOD has none.

    Raises:
        CadetError: a number outside its range.

    Reference: Li et al., "LiDAR R-CNN: An Efficient and Universal 3D Object Detector" (CVPR 2021).
    """

    max_points: Annotated[int, Limits(0, 4096)] = 0
    """Points of a box that are looked at; 0 leaves boxes as they are."""
    margin_m: Annotated[float, Limits(0, 10)] = 0.7
    """How far beyond a box's sides points are looked at."""
    channels: Annotated[tuple[int, int, int], Limits(1, 4096)] = (64, 64, 128)
    """Of each point after each layer."""
    hidden: Annotated[tuple[int, ...], Limits(1, 65536)] = (128, 128)
    """Widths of the layers behind the greatest of all points' features."""
    copies: Annotated[int, Limits(0, 1024)] = 8
    """Copies of each true box, moved, scaled and turned a little, that it learns from in a step ..."""
    found_boxes: Annotated[int, Limits(0, 1024)] = 32
    """... besides so many boxes that the network found, the best."""
    passes: Annotated[int, Limits(0, 8)] = 1
    """How often a box is corrected in detection."""
    weight: Annotated[float, Limits(0)] = 1.0
    """Of its loss."""

    def __post_init__(self) -> None:
        check_fields(self)
