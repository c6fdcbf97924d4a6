"""Lines of KITTI's `label_2` files and of result files."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import check_kind, check_text, plain_number, shown
from cadet.errors import KittiFormatError, NonFiniteError, ShapeError
from cadet.formats.kitti.files.dialects import accept
from cadet.formats.kitti.files.numbers import is_number, number_from_text
from cadet.formats.kitti.files.text import content_lines

TYPES: Final = ("Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc", "DontCare")
"""The object types of KITTI's labels, spelled as in its files. Others may have others: see `is_type`."""

_BY_SMALL_LETTERS: Final = {name.casefold(): name for name in TYPES}
_NAME: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.:/+()-]{0,63}")
_NUM_FIELDS: Final = 15
_LAYOUT: Final = "type truncated occluded alpha, left top right bottom, height width length, x y z, rotation_y"
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
        type: one of `TYPES`, or another name that `is_type` lets pass. KITTI's are spelled as KITTI does.
        truncated: 0 (whole) .. 1 (outside the image), -1 unknown.
        occluded: 0 visible, 1 partly, 2 largely occluded, 3 unknown, -1 for DontCare.
        alpha: observation angle in radians, rotation_y - atan2(x, z), -10 unknown.
        bbox: (left, top, right, bottom) in pixels.
        dimensions_hwl: (height, width, length) in meters.
        location_cam: (x, y, z) of the bottom face's center in the cam frame, meters.
        rotation_y: heading about the cam frame's y axis in radians, 0 along x.
        score: a detection's confidence; None for a label.

    Raises:
        KittiFormatError: a type that is no name, `occluded` no whole number or outside -1..3, or what is not a number.
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
        if not is_type(self.type):
            raise KittiFormatError(
                f"type: expected a name such as Car, of letters, digits and _.:/+()-, got {shown(self.type)}"
            )
        object.__setattr__(self, "type", kitti_spelling(self.type))
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
            type: as in a label.
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
            line: 15 fields, or 16 with a score, separated by blanks. What other programs note past them is passed over.
            file: the file's name for messages.
            line_number: the line's number for messages, from 1.

        Raises:
            KittiFormatError: too few fields, a field that is no finite number, a type that is no name.
        """
        check_text("", "line", line)
        where = (file, line_number)
        fields = line.split()
        if len(fields) < _NUM_FIELDS:
            raise KittiFormatError(f"expected {_NUM_FIELDS} fields, got {len(fields)}: {_LAYOUT}", *where)
        if not is_type(fields[0]) and all(map(str.isdigit, (fields[0], fields[1].removeprefix("-")))):
            raise KittiFormatError(
                f"type: expected a name, got {shown(fields[0])}; a line of KITTI's tracking labels? Leave out its "
                "first two fields, and give each frame a file",
                *where,
            )
        numbers = [_parse_number(text, name, where) for name, text in zip(_FIELDS, fields[1:_NUM_FIELDS], strict=False)]
        more, score = fields[_NUM_FIELDS:], None
        if len(more) == 1 and is_number(more[0]):
            score = _parse_number(more[0], _FIELDS[-1], where)
        elif more:
            accept("label-more-fields", f"fields past the {_NUM_FIELDS}th are ignored", *where)
        occluded = numbers[1]
        if occluded != int(occluded):
            raise KittiFormatError(f"occluded: expected a whole number, got {fields[2]!r}", *where)
        if not fields[2].lstrip("+-").isdigit():
            message = f"occluded {fields[2]} is read as {int(occluded)}: MMDetection3D expects it without a point"
            accept("label-occluded", message, *where)
        name = kitti_spelling(fields[0])
        if name != fields[0]:
            accept("label-letter-case", f"type {fields[0]} is read as {name}", *where)
        elif is_type(name) and name not in TYPES:
            accept("label-other-type", f"type {name} is not one of KITTI's: its labels are kept as {name}", *where)
        try:
            return cls(
                type=name,
                truncated=numbers[0],
                occluded=int(occluded),
                alpha=numbers[2],
                bbox=(numbers[3], numbers[4], numbers[5], numbers[6]),
                dimensions_hwl=(numbers[7], numbers[8], numbers[9]),
                location_cam=(numbers[10], numbers[11], numbers[12]),
                rotation_y=numbers[13],
                score=score,
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
    boxes = [label.box_cam for label in _checked(labels)]
    return np.stack(boxes) if boxes else np.zeros((0, 7))


def is_type(name: object) -> bool:
    """Tell whether a label's type may have this name: letters, digits and `_.:/+()-`, up to 64, and no number."""
    return isinstance(name, str) and _NAME.fullmatch(name) is not None and not is_number(name)


def is_object_type(name: object) -> bool:
    """Tell whether an object may have this type: `is_type`, and not that of regions."""
    return isinstance(name, str) and is_type(name) and kitti_spelling(name) != "DontCare"


def kitti_spelling(name: str) -> str:
    """Return one of KITTI's types, given in any letter case, as KITTI spells it; another name as it is."""
    return _BY_SMALL_LETTERS.get(name.casefold(), name)


def labels_from_text(text: str, file: str = "label") -> tuple[Label, ...]:
    """Parse a whole label or result file; an empty one has no objects. Blank lines are passed over.

    Raises:
        KittiFormatError: a malformed line, named with the file and its number.
        CadetError: `text` is no text.
    """
    return tuple(Label.from_line(line, file, number) for number, line in content_lines(text))


def text_from_labels(labels: Iterable[Label]) -> str:
    """Write labels as a file's text, one line each."""
    return "".join(f"{label.to_line()}\n" for label in _checked(labels))


def _checked(labels: Iterable[Label]) -> tuple[Label, ...]:
    check_kind("", "labels", labels, Iterable)
    labels = tuple(labels)
    for label in labels:
        check_kind("", "labels", label, Label)
    return labels


def _parse_number(text: str, name: str, where: tuple[str, int]) -> float:
    try:
        return number_from_text(text)
    except ValueError as error:
        raise KittiFormatError(f"{name}: {error}", *where) from None


def _decimal(value: float, unknown: float | None = None) -> str:
    return f"{value:.0f}" if value == unknown else f"{value:.2f}"
