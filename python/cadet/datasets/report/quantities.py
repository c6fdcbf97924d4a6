"""Quantities that are counted of labels, and their bins: the same for a dataset and for KITTI.

Bins lie in one table, so that two sets can be drawn into one figure. What falls outside counts in the outermost bin.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti import TYPES, Label

CLASSES: Final = tuple(name for name in TYPES if name != "DontCare")
"""The types of objects, in KITTI's order."""


@dataclass(frozen=True)
class Quantity:
    """Something that every label has a number of.

    Attributes:
        name: its key in files.
        title: the figure's heading.
        unit: of the axis; empty for none.
        edges: of the bins, rising.
        names: of the bins, where these stand for values rather than for ranges.
    """

    name: str
    title: str
    unit: str
    edges: tuple[float, ...]
    names: tuple[str, ...] = ()

    def count(self, values: Sequence[float] | NDArray[np.float64]) -> NDArray[np.int64]:
        """Count values by bin: (num_bins,) int64."""
        clipped = np.clip(np.asarray(values, np.float64), self.edges[0], np.nextafter(self.edges[-1], -np.inf))
        return np.histogram(clipped, self.edges)[0].astype(np.int64)

    @property
    def num_bins(self) -> int:
        """The number of bins."""
        return len(self.edges) - 1


def _even(low: float, high: float, num_bins: int) -> tuple[float, ...]:
    return tuple(np.linspace(low, high, num_bins + 1).round(9).tolist())


OBJECTS: Final = Quantity(
    "objects", "Objects per frame", "", _even(-0.5, 20.5, 21), tuple(map(str, range(20))) + ("20+",)
)
"""Per frame and class; the others are per label."""

POINTS: Final = Quantity(
    "points",
    "LIDAR returns per box",
    "returns",
    (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0, 10000.0),
    ("0", "1", "2", "5", "10", "20", "50", "100", "200", "500", "1k", "2k", "5k"),
)
"""Needs the scans."""

LABEL_QUANTITIES: Final = (
    Quantity("distance", "Distance", "m", _even(0.0, 90.0, 30)),
    Quantity("lateral", "Place to the side", "m", _even(-30.0, 30.0, 24)),
    Quantity("rotation_y", "Heading, rotation_y", "deg", _even(-180.0, 180.0, 24)),
    Quantity("alpha", "Observation angle, alpha", "deg", _even(-180.0, 180.0, 24)),
    Quantity("length", "Length", "m", _even(0.0, 20.0, 100)),
    Quantity("width", "Width", "m", _even(0.0, 4.0, 40)),
    Quantity("height", "Height", "m", _even(0.0, 4.0, 40)),
    Quantity("box_height", "Height of the 2D box", "px", _even(0.0, 380.0, 38)),
    Quantity("truncated", "Truncation", "", _even(0.0, 1.0, 20)),
    Quantity(
        "occluded",
        "Occlusion",
        "",
        (-0.5, 0.5, 1.5, 2.5, 3.5),
        ("visible", "partly", "largely", "unknown"),
    ),
)
"""What a label file alone tells."""

QUANTITIES: Final = {one.name: one for one in (OBJECTS, *LABEL_QUANTITIES, POINTS)}
"""All by name."""


def values_of(labels: Sequence[Label]) -> dict[str, NDArray[np.float64]]:
    """Return the numbers of labels without DontCare, by the names of `LABEL_QUANTITIES`: (len(labels),) each."""
    location = np.array([label.location_cam for label in labels], np.float64).reshape(-1, 3)
    size = np.array([label.dimensions_hwl for label in labels], np.float64).reshape(-1, 3)
    bbox = np.array([label.bbox for label in labels], np.float64).reshape(-1, 4)
    return {
        "distance": np.hypot(location[:, 0], location[:, 2]),
        "lateral": location[:, 0],
        "rotation_y": np.degrees(_of(labels, "rotation_y")),
        "alpha": np.degrees(_of(labels, "alpha")),
        "length": size[:, 2],
        "width": size[:, 1],
        "height": size[:, 0],
        "box_height": bbox[:, 3] - bbox[:, 1],
        "truncated": _of(labels, "truncated"),
        "occluded": _of(labels, "occluded"),
    }


def _of(labels: Iterable[Label], name: str) -> NDArray[np.float64]:
    return np.array([getattr(label, name) for label in labels], np.float64)
