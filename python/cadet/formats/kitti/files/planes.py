"""AVOD's `planes` files: three header lines, then the ground plane a b c d in the cam frame."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import check_array
from cadet.errors import KittiFormatError
from cadet.formats.kitti.files.dialects import accept
from cadet.formats.kitti.files.numbers import number_from_text
from cadet.formats.kitti.files.text import content_lines

_HEADER: Final = "# Matrix\nWIDTH 4\nHEIGHT 1\n"
_NUM_LINES: Final = 4
_NUM_DECIMALS: Final = 6


def plane_from_text(text: str, file: str = "plane") -> NDArray[np.float64]:
    """Parse a plane: (4,) float64 [a, b, c, d] with a x + b y + c z + d = 0 in the cam frame.

    Args:
        text: the file's text. Its header lines are skipped unread, as AVOD does: they differ between tools.
        file: its name for messages.

    Raises:
        KittiFormatError: not four lines, or the last is not four finite numbers.
    """
    lines = content_lines(text)
    if len(lines) not in (1, _NUM_LINES):
        raise KittiFormatError(f"expected {_NUM_LINES} lines, the last a b c d of the plane, got {len(lines)}", file)
    number, line = lines[-1]
    fields = line.split()
    if len(fields) != _NUM_LINES:
        raise KittiFormatError(f"expected 4 numbers, got {len(fields)}", file, number)
    try:
        plane = np.array([number_from_text(field) for field in fields])
    except ValueError as error:
        raise KittiFormatError(str(error), file, number) from None
    if len(lines) == 1:
        accept("plane-header", f"the plane without its {_NUM_LINES - 1} header lines: AVOD reads line 4", file, number)
    return plane


def text_from_plane(plane: NDArray[np.float64]) -> str:
    """Write a plane: 6 decimals, more only where a number needs them to come back exactly.

    Raises:
        ShapeError: not (4,) float64.
        NonFiniteError: NaN or infinity.
    """
    check_array(plane, "plane", (4,), np.float64, finite=True)
    numbers = (np.format_float_scientific(x, min_digits=_NUM_DECIMALS, exp_digits=2) for x in plane)
    return f"{_HEADER}{' '.join(numbers)} \n"
