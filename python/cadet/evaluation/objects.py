"""The objects of a frame as arrays: what a detector holds in memory."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import as_array
from cadet._util.checks import shown
from cadet._util.summary import counts, summary
from cadet.errors import CadetError, ShapeError
from cadet.formats.kitti import Label

MIN_SCORE = -1e7
"""KITTI's program never matches a detection whose score is not above this."""


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """The labeled objects of a frame, in the order of its label file. Lists are taken for arrays.

    Attributes:
        types: n names; their letter case does not matter, names that KITTI lacks take no part.
        boxes_img: (n, 4) [left, top, right, bottom] in pixels.
        boxes_cam: (n, 7) [x, y, z, l, w, h, rotation_y], bottom center in the cam frame.
        alphas: (n,) observation angles in radians.
        truncated: (n,) 0 (whole) .. 1 (outside the image).
        occluded: (n,) levels 0 visible .. 3 unknown.
        optional: (n,) whether an object need not be found at any level: finding it is neither right nor wrong. None,
            for no object, becomes an array of False.

    Raises:
        ShapeError: an array of another length.
        NonFiniteError: NaN or infinity.
    """

    types: tuple[str, ...]
    boxes_img: NDArray[Any]
    boxes_cam: NDArray[Any]
    alphas: NDArray[Any]
    truncated: NDArray[Any]
    occluded: NDArray[Any]
    optional: NDArray[Any] | None = None

    def __post_init__(self) -> None:
        _check(self, ("alphas", "truncated", "occluded"))

    @classmethod
    def from_labels(cls, labels: Iterable[Label]) -> GroundTruth:
        """Gather labels, DontCare regions too."""
        labels = tuple(labels)
        return cls(
            truncated=np.array([label.truncated for label in labels], np.float64),
            occluded=np.array([label.occluded for label in labels], np.float64),
            **_from_labels(labels),
        )

    def __repr__(self) -> str:
        return summary(self, types=counts(self.types), boxes_img=self.boxes_img, boxes_cam=self.boxes_cam)

    def rows(self) -> NDArray[np.float64]:
        """Return (n, 15) as the core takes them."""
        first = (self.truncated, self.occluded, self.alphas)
        return np.column_stack(
            [*(a.astype(np.float64) for a in first), self.boxes_img, self.boxes_cam, is_optional(self)]
        )


@dataclass(frozen=True, eq=False)
class Detections:
    """The detections of a frame; their order breaks ties between equal scores. Lists are taken for arrays.

    Attributes:
        types: n names; their letter case does not matter.
        boxes_img: (n, 4) [left, top, right, bottom] in pixels. They decide about height in all metrics.
        boxes_cam: (n, 7) [x, y, z, l, w, h, rotation_y], bottom center in the cam frame.
        alphas: (n,) observation angles in radians; a single -10 switches AOS off.
        scores: (n,) any numbers above -1e7, higher is better.
        optional: (n,) whether a detection that finds no object is still no false positive. None, for no detection,
            becomes an array of False.

    Raises:
        ShapeError: an array of another length.
        NonFiniteError: NaN or infinity.
        CadetError: a score of -1e7 or less.
    """

    types: tuple[str, ...]
    boxes_img: NDArray[Any]
    boxes_cam: NDArray[Any]
    alphas: NDArray[Any]
    scores: NDArray[Any]
    optional: NDArray[Any] | None = None

    def __post_init__(self) -> None:
        _check(self, ("alphas", "scores"))
        if (self.scores <= MIN_SCORE).any():
            raise CadetError(f"scores: expected numbers above {MIN_SCORE:g}, got {self.scores.min():g}")

    @classmethod
    def from_labels(cls, labels: Iterable[Label]) -> Detections:
        """Gather labels that carry scores.

        Raises:
            ShapeError: one has no score.
        """
        labels = tuple(labels)
        scores = [label.score for label in labels if label.score is not None]
        if len(scores) < len(labels):
            raise ShapeError(f"detections: {len(labels) - len(scores)} of {len(labels)} labels have no score")
        return cls(scores=np.array(scores, np.float64), **_from_labels(labels))

    def __repr__(self) -> str:
        best = [f"best score {self.scores.max():g}"] if len(self.scores) else []
        return summary(self, *best, types=counts(self.types), boxes_img=self.boxes_img, boxes_cam=self.boxes_cam)

    def rows(self) -> NDArray[np.float64]:
        """Return (n, 14) as the core takes them."""
        first, last = self.alphas.astype(np.float64), self.scores.astype(np.float64)
        return np.column_stack([first, self.boxes_img, self.boxes_cam, last, is_optional(self)])


def is_optional(objects: GroundTruth | Detections) -> NDArray[np.bool_]:
    """Return (n,) which objects are optional."""
    assert objects.optional is not None, "filled in where objects are made"
    return objects.optional


def _from_labels(labels: tuple[Label, ...]) -> dict[str, Any]:
    return {
        "types": tuple(label.type for label in labels),
        "boxes_img": np.array([label.bbox for label in labels], np.float64).reshape(-1, 4),
        "boxes_cam": np.array([label.box_cam for label in labels], np.float64).reshape(-1, 7),
        "alphas": np.array([label.alpha for label in labels], np.float64),
    }


def _check(objects: GroundTruth | Detections, columns: tuple[str, ...]) -> None:
    types = objects.types
    if not isinstance(types, (tuple, list)) or not all(isinstance(name, str) for name in types):
        raise ShapeError(f"types: expected a tuple of names, got {shown(types)}")
    object.__setattr__(objects, "types", tuple(types))
    count = len(objects.types)
    shapes: dict[str, tuple[int, ...]] = {"boxes_img": (count, 4), "boxes_cam": (count, 7)}
    for name in ("boxes_img", "boxes_cam", *columns):
        object.__setattr__(
            objects, name, as_array(getattr(objects, name), name, shapes.get(name, (count,)), finite=True)
        )
    optional = np.zeros(count, np.bool_) if objects.optional is None else np.asarray(objects.optional)
    if optional.dtype != np.bool_ or optional.shape != (count,):
        raise ShapeError(f"optional: expected ({count},) bool, got {optional.shape} {optional.dtype}")
    object.__setattr__(objects, "optional", optional)
