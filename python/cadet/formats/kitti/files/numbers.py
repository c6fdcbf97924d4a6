"""Numbers of KITTI's text files."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cadet._util.checks import shown

_NUM_DECIMALS: Final = 12


def is_number(text: str) -> bool:
    """Tell whether a word is a number as C reads it: ASCII, without Python's underscores; infinity and NaN are."""
    try:
        float(text if "_" not in text and text.isascii() else "")
    except ValueError:
        return False
    return True


def number_from_text(text: str) -> float:
    """Parse a number that is finite.

    Raises:
        ValueError: it is none.
    """
    if not is_number(text):
        raise ValueError(f"expected a number, got {shown(text)}")
    if not math.isfinite(value := float(text)):
        raise ValueError(f"expected a finite number, got {shown(text)}")
    return value


def scientific_text(value: float) -> str:
    """Write a number of a calibration as KITTI does: 12 decimals, more only where it needs them to come back."""
    return np.format_float_scientific(value, min_digits=_NUM_DECIMALS, exp_digits=2)
