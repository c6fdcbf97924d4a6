"""Numbers of KITTI's text files."""

from __future__ import annotations

from typing import Final

import numpy as np

_NUM_DECIMALS: Final = 12


def number_from_text(text: str) -> float:
    """Parse a decimal number as C reads it: ASCII, without Python's underscores between digits.

    Raises:
        ValueError: it is none.
    """
    if "_" in text or not text.isascii():
        raise ValueError(f"expected a number, got {text!r}")
    return float(text)


def scientific_text(value: float) -> str:
    """Write a number of a calibration as KITTI does: 12 decimals, more only where it needs them to come back."""
    return np.format_float_scientific(value, min_digits=_NUM_DECIMALS, exp_digits=2)
