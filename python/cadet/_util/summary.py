"""The `repr` of objects, in one or a few lines: shapes and counts rather than all numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Final

_LONGEST: Final = 120


def summary(owner: object, *notes: str, **parts: object) -> str:
    """Return an object's `repr`: the name of its class and some of its parts; those that are None are left out.

    Args:
        owner: the object.
        notes: what else is to be said, such as "64 rings".
        parts: attributes of it by name: numbers, texts, or arrays, of which shape and dtype are shown.
    """
    shown = [f"{name}={_text(value)}" for name, value in parts.items() if value is not None]
    return f"{type(owner).__name__}({', '.join([*shown, *notes])})"


def counts(names: Iterable[str]) -> str:
    """Count names, such as "4 Car, 1 Van", in the order in which they appear first."""
    return ", ".join(f"{count} {name}" for name, count in Counter(names).items()) or "none"


def _text(value: object) -> str:
    shape, dtype = getattr(value, "shape", None), getattr(value, "dtype", None)
    if shape is not None and dtype is not None:
        return f"{tuple(shape)} {str(dtype).removeprefix('torch.')}"
    text = f"{value:g}" if isinstance(value, float) else repr(value)
    return text if len(text) <= _LONGEST or "(" in text else text[: _LONGEST - 3] + "..."
