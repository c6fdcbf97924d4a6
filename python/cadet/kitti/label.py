"""Lines of KITTI's `label_2` files and of result files."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.checks import check_kind, is_one_of, plain_number, shown
from cadet.errors import KittiFormatError, NonFiniteError, ShapeError

TYPES: Final = ("Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc", "DontCare")
"""The object types of KITTI's labels, spelled as in its files."""

_NUM_FIELDS: Final = 15
_FIELDS: Final = (
    "truncated occluded alpha bbox_left bbox_top bbox_right bbox_bottom height width length x y z rotation_y score"
).split()
_UNKNOWN_EXTENT: Final = -1.0
_UNKNOWN_ANGLE: Final = -10.0
_UNKNOWN_PLACE: Final = -1000.0
_MAX_OCCLUDED: Final = 3
_NUMBERS: Final = (int, float, np.integer, np.floating)


@dataclass(frozen=True)
class Label:
    """One object of a frame.

    KITTI's marks for "unknown" are kept as they are: truncated, occluded and dimensions -1, alpha and rotation_y -10,
    location -1000. A DontCare region carries all of them.

    Attributes:
        type: one of `TYPES`.
        truncated: 0 (whole) .. 1 (outside the image), -1 unknown.
        occluded: 0 visible, 1 partly, 2 largely occluded, 3 unknown, -1 for DontCare.
        alpha: observation angle in radians, rotation_y - atan2(x, z), -10 unknown.
        bbox: (left, top, right, bottom) in pixels.
        dimensions_hwl: (height, width, length) in meters.
        location_cam: (x, y, z) of the bottom face's center in the cam frame, meters.
        rotation_y: heading about the cam frame's y axis in radians, 0 along x.
        score: a detection's confidence; None for a label.

    Raises:
        KittiFormatError: an unknown type, `occluded` no whole number or outside -1..3, or what is no number.
        ShapeError: a tuple has the wrong length.
        NonFiniteError: a number is NaN or infinite.
    """

    type: str
    truncated: float
    occluded: int
    alpha: float
    bbox: tuple[float, float, float, float]
    dimensions_hwl: tuple[float, float, float]
    location_cam: tuple[float, float, float]
    rotation_y: float
    score: float | None = None

    def __post_init__(self) -> None:
        if not is_one_of(self.type, TYPES):
            raise KittiFormatError(f"unknown type {shown(self.type)}, expected one of {', '.join(TYPES)}")
        is_whole = isinstance(self.occluded, (int, np.integer)) and not isinstance(self.occluded, bool)
        if not is_whole or not -1 <= self.occluded <= _MAX_OCCLUDED:
            raise KittiFormatError(f"occluded: expected a whole number -1..{_MAX_OCCLUDED}, got {shown(self.occluded)}")
        for name, size in (("bbox", 4), ("dimensions_hwl", 3), ("location_cam", 3)):
            values = getattr(self, name)
            if isinstance(values, list) or (isinstance(values, np.ndarray) and values.ndim == 1):
                values = tuple(values)
                object.__setattr__(self, name, values)
            if not isinstance(values, tuple):
                raise ShapeError(f"{name}: expected {size} numbers, got {shown(values)}")
            if len(values) != size:
                raise ShapeError(f"{name}: expected {size} numbers, got {len(values)}")
        for name, value in zip(_FIELDS, self._numbers(), strict=False):
            if not isinstance(value, _NUMBERS) or isinstance(value, bool):
                raise KittiFormatError(f"{name}: expected a number, got {shown(value)}")
            if not abs(plain_number(value)) <= sys.float_info.max:
                raise NonFiniteError(f"{name}: not finite: {value if isinstance(value, float) else shown(value)}")

    @classmethod
    def in_image(
        cls,
        type: str,
        bbox: tuple[float, float, float, float],
        *,
        truncated: float = _UNKNOWN_EXTENT,
        occluded: int = -1,
    ) -> Label:
        """Return a label of which nothing is known in 3D, such as a DontCare region.

        Args:
            type: one of `TYPES`.
            bbox: (left, top, right, bottom) in pixels.
            truncated: as in a label; unknown by default.
            occluded: likewise.
        """
        size, place = (_UNKNOWN_EXTENT,) * 3, (_UNKNOWN_PLACE,) * 3
        return cls(type, truncated, occluded, _UNKNOWN_ANGLE, bbox, size, place, _UNKNOWN_ANGLE)

    @classmethod
    def from_line(cls, line: str, file: str = "label", line_number: int = 1) -> Label:
        """Parse one line of a label or result file.

        Args:
            line: 15 fields, or 16 with a score, separated by blanks.
            file: the file's name for messages.
            line_number: the line's number for messages, from 1.

        Raises:
            KittiFormatError: wrong number of fields, a field that is no finite number, an unknown type.
        """
        where = (file, line_number)
        fields = line.split()
        if len(fields) not in (_NUM_FIELDS, _NUM_FIELDS + 1):
            raise KittiFormatError(f"expected {_NUM_FIELDS} fields, got {len(fields)}", *where)
        numbers = [_parse_number(text, name, where) for name, text in zip(_FIELDS, fields[1:], strict=False)]
        occluded = numbers[1]
        if occluded != int(occluded):
            raise KittiFormatError(f"occluded: expected a whole number, got {fields[2]!r}", *where)
        try:
            return cls(
                type=fields[0],
                truncated=numbers[0],
                occluded=int(occluded),
                alpha=numbers[2],
                bbox=(numbers[3], numbers[4], numbers[5], numbers[6]),
                dimensions_hwl=(numbers[7], numbers[8], numbers[9]),
                location_cam=(numbers[10], numbers[11], numbers[12]),
                rotation_y=numbers[13],
                score=numbers[14] if len(numbers) == _NUM_FIELDS else None,
            )
        except KittiFormatError as error:
            raise KittiFormatError(error.reason, *where) from None

    def to_line(self) -> str:
        """Write the label as KITTI does: two decimals, marks for "unknown" whole, no newline.

        A score keeps all its digits, two decimals at least, since its order ranks detections.
        """
        fields = [
            self.type,
            _decimal(self.truncated, _UNKNOWN_EXTENT),
            str(self.occluded),
            _decimal(self.alpha, _UNKNOWN_ANGLE),
            *(_decimal(value) for value in self.bbox),
            *(_decimal(value, _UNKNOWN_EXTENT) for value in self.dimensions_hwl),
            *(_decimal(value, _UNKNOWN_PLACE) for value in self.location_cam),
            _decimal(self.rotation_y, _UNKNOWN_ANGLE),
        ]
        if self.score is not None:
            fields.append(np.format_float_positional(self.score, min_digits=2))
        return " ".join(fields)

    @property
    def is_dont_care(self) -> bool:
        """Whether this is a region to ignore instead of an object."""
        return self.type == "DontCare"

    @property
    def box_cam(self) -> NDArray[np.float64]:
        """(7,) float64 [x, y, z, l, w, h, rotation_y]: bottom center in the cam frame, meters and radians."""
        height, width, length = self.dimensions_hwl
        return np.array([*self.location_cam, length, width, height, self.rotation_y], np.float64)

    def _numbers(self) -> tuple[float, ...]:
        score = () if self.score is None else (self.score,)
        place = (*self.dimensions_hwl, *self.location_cam, self.rotation_y)
        return (self.truncated, self.occluded, self.alpha, *self.bbox, *place, *score)


def boxes_cam_from_labels(labels: Iterable[Label]) -> NDArray[np.float64]:
    """Gather the boxes of labels, DontCare regions too: (M, 7) float64 [x, y, z, l, w, h, rotation_y], cam frame."""
    labels = tuple(labels)
    for label in labels:
        check_kind("", "labels", label, Label)
    boxes = [label.box_cam for label in labels]
    return np.stack(boxes) if boxes else np.zeros((0, 7))


def labels_from_text(text: str, file: str = "label") -> tuple[Label, ...]:
    """Parse a whole label or result file; an empty one has no objects.

    Raises:
        KittiFormatError: a malformed line, named with the file and its number; blank lines count as malformed.
    """
    lines = text.split("\n")
    if lines[-1] == "":
        lines.pop()
    return tuple(Label.from_line(line, file, number) for number, line in enumerate(lines, start=1))


def text_from_labels(labels: Iterable[Label]) -> str:
    """Write labels as a file's text, one line each."""
    return "".join(f"{label.to_line()}\n" for label in labels)


def _parse_number(text: str, name: str, where: tuple[str, int]) -> float:
    try:
        value = float(text if "_" not in text else "")
    except ValueError:
        raise KittiFormatError(f"{name}: expected a number, got {text!r}", *where) from None
    if not math.isfinite(value):
        raise KittiFormatError(f"{name}: expected a finite number, got {text!r}", *where)
    return value


def _decimal(value: float, unknown: float | None = None) -> str:
    return f"{value:.0f}" if value == unknown else f"{value:.2f}"
