"""Numbers of KITTI's text files."""

from __future__ import annotations


def number_from_text(text: str) -> float:
    """Parse a decimal number as C reads it: ASCII, without Python's underscores between digits.

    Raises:
        ValueError: it is none.
    """
    if "_" in text or not text.isascii():
        raise ValueError(f"expected a number, got {text!r}")
    return float(text)
