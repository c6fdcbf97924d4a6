"""Rows of text, the header among them, as aligned lines and as Markdown."""

from __future__ import annotations

from collections.abc import Sequence


def aligned(rows: Sequence[Sequence[str]], num_left: int = 1, gap: str = "  ") -> list[str]:
    """Return a line for each row: the first `num_left` columns set to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    sides = [str.ljust if column < num_left else str.rjust for column in range(len(widths))]
    return [gap.join(s(cell, w) for s, cell, w in zip(sides, row, widths, strict=True)).rstrip() for row in rows]


def markdown(rows: Sequence[Sequence[str]], num_left: int = 1) -> list[str]:
    """Return the lines of a table whose header is the first row; numbers are set to the right as in `aligned`."""
    marks = ["---" if column < num_left else "---:" for column in range(len(rows[0]))]
    return [f"| {' | '.join(row)} |" for row in (rows[0], marks, *rows[1:])]
