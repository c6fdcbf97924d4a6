"""Checks of what users hand in: numbers, flags, names, pairs and paths. Arrays are checked by `cadet._util.arrays`."""

from __future__ import annotations

import os
import sys
from collections.abc import Collection
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np

from cadet.errors import CadetError

MAX_SEED = 2**63 - 1
MAX_EPISODE = 10**9

_LONGEST_SHOWN = 100

MAX_PATH_BYTES: Final = 4095
"""Longest path on Linux (PATH_MAX without its end)."""
MAX_NAME_BYTES: Final = 255
"""Longest name of a file or folder on Linux's file systems (NAME_MAX)."""


def shown(value: object) -> str:
    """Return the value for a message: its repr on one line, cut where it gets long."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:
        # Python prints no whole number of more than 4300 digits.
        text = f"{type(value).__name__} with thousands of digits"
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."


def known_names(name: object, names: Collection[str], or_else: str = "") -> str:
    """Return what there is instead of `name` for a message, and which of it was probably meant."""
    # Scenes do without it.
    from difflib import get_close_matches

    asked = name if isinstance(name, str) and len(name) <= _LONGEST_SHOWN else ""
    nearest = get_close_matches(asked, names, 1)
    meant = f"; did you mean {nearest[0]!r}?" if nearest else ""
    return f"known: {', '.join(names) or 'none'}{or_else}{meant}"


def shown_key(key: str) -> str:
    """Return a table's key for a message: as it is, unless it would not be seen as it is."""
    return key if key.isprintable() and len(key) <= _LONGEST_SHOWN else shown(key)


def check_number(
    owner: str, name: str, value: object, low: float, high: float = float("inf"), *, whole: bool = False
) -> None:
    """Refuse anything but a number in the range. NumPy's numbers are accepted.

    Args:
        owner: whose value it is, for the message; empty for a function's argument.
        name: the value's name.
        value: what the user gave.
        low: the least that is allowed.
        high: the greatest; infinity itself is refused all the same.
        whole: allow integers alone.

    Raises:
        CadetError: naming the field, the value and the range.
    """
    kinds = (int, np.integer) if whole else (int, float, np.integer, np.floating)
    is_number = isinstance(value, kinds) and not isinstance(value, bool)
    if not is_number or not low <= plain_number(value) <= min(high, sys.float_info.max):
        low_text, high_text = (str(limit) if whole else f"{limit:g}" for limit in (low, high))
        limits = f"of at least {low_text}" if high == float("inf") else f"from {low_text} to {high_text}"
        kind = "a whole number" if whole else "a number"
        raise CadetError(f"{_place(owner, name)}: expected {kind} {limits}, got {shown(value)}")


class Limits(NamedTuple):
    """The least and the greatest of a field's numbers, as in `share: Annotated[float, Limits(0, 1)]`."""

    least: float
    most: float = float("inf")


def check_fields(settings: Any, owner: str | None = None) -> None:
    """Refuse a dataclass's numbers outside their fields' `Limits`: those in tuples too, and None where None may be.

    Args:
        settings: the dataclass; a field of int takes whole numbers alone.
        owner: its name for messages; None for the class's.

    Raises:
        CadetError: naming the field, the value and the range.
    """
    for name, kind, limits in _limited(type(settings)):  # type: ignore[arg-type]
        _check_numbers(owner or type(settings).__name__, name, getattr(settings, name), kind, limits)


@cache
def _limited(cls: type[Any]) -> list[tuple[str, Any, Limits]]:
    hints = get_type_hints(cls, include_extras=True).items()
    return [(name, hint.__origin__, *hint.__metadata__) for name, hint in hints if get_origin(hint) is Annotated]


def _check_numbers(owner: str, name: str, value: Any, kind: Any, limits: Limits) -> None:
    kinds = get_args(kind)
    if get_origin(kind) is tuple:
        for item in value:
            _check_numbers(owner, name, item, kinds[0], limits)
    elif value is not None or type(None) not in kinds:
        check_number(owner, name, value, *limits, whole=int in (kind, *kinds))


def check_three(owner: str, name: str, values: object, limit: float) -> None:
    """Refuse anything but a tuple of three numbers from `-limit` to `limit`.

    Raises:
        CadetError: naming the field, the value and the range.
    """
    if not isinstance(values, tuple) or len(values) != 3:
        raise CadetError(f"{_place(owner, name)}: expected three numbers, got {shown(values)}")
    for value in values:
        check_number(owner, name, value, -limit, limit)


def check_image_size(size: object, name: str = "image_size") -> tuple[int, int]:
    """Return width and height if they are two whole numbers of pixels.

    Raises:
        CadetError: they are not.
    """
    values = tuple(size) if isinstance(size, (tuple, list)) else ()
    if len(values) != 2:
        raise CadetError(f"{name}: expected (width, height), got {shown(size)}")
    for value in values:
        check_number("", name, value, 1, 1_000_000, whole=True)
    return int(values[0]), int(values[1])


def check_range(owner: str, name: str, values: object, low: float, high: float, *, whole: bool = False) -> None:
    """Refuse anything but a tuple of two numbers from `low` to `high`, the second at least as large as the first.

    Raises:
        CadetError: naming the field, the value and the range.
    """
    if not isinstance(values, tuple) or len(values) != 2:
        raise CadetError(f"{_place(owner, name)}: expected (low, high), got {shown(values)}")
    for value in values:
        check_number(owner, name, value, low, high, whole=whole)
    if values[0] > values[1]:
        raise CadetError(f"{_place(owner, name)}: expected (low, high), got {shown(values)}")


def check_flag(owner: str, name: str, value: object) -> None:
    """Refuse what is neither True nor False.

    Raises:
        CadetError: naming the field and the value.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise CadetError(f"{_place(owner, name)}: expected True or False, got {shown(value)}")


def check_kind(owner: str, name: str, value: object, kind: type[Any]) -> None:
    """Refuse anything but an instance of a class.

    Raises:
        CadetError: naming the field, the class and the value.
    """
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        raise CadetError(f"{_place(owner, name)}: expected {article} {kind.__name__}, got {shown(value)}")


def check_text(owner: str, name: str, value: object) -> None:
    """Refuse anything but text that can be written: half of a surrogate pair can't.

    Raises:
        CadetError: naming the field and the value.
    """
    if not isinstance(value, str):
        raise CadetError(f"{_place(owner, name)}: expected a string, got {shown(value)}")
    try:
        value.encode("utf-8")
    except UnicodeEncodeError as error:
        half = shown(value[error.start : error.end])
        raise CadetError(
            f"{_place(owner, name)}: expected a string, got half of a surrogate pair in it: {half}"
        ) from None


def is_one_of(value: object, names: Collection[str]) -> bool:
    """Tell whether `value` is one of the names; anything but text is not."""
    return isinstance(value, str) and value in names


def as_tuple(owner: str, name: str, values: object, what: str) -> tuple[Any, ...]:
    """Return a list or tuple as a tuple.

    Args:
        owner: whose value it is, for the message; empty for a function's argument.
        name: the value's name.
        values: what the user gave.
        what: what it should be a list of, for the message.

    Raises:
        CadetError: it is neither.
    """
    if not isinstance(values, (list, tuple)):
        raise CadetError(f"{_place(owner, name)}: expected a tuple of {what}, got {shown(values)}")
    return tuple(values)


def as_pairs(owner: str, name: str, values: object, what: str) -> tuple[tuple[Any, Any], ...]:
    """Return a list or tuple of pairs as a tuple of tuples.

    Raises:
        CadetError: it is none; `what` names the pair in the message.
    """
    pairs = as_tuple(owner, name, values, f"pairs {what}")
    for pair in pairs:
        if not isinstance(pair, (list, tuple)) or len(pair) != 2:
            raise CadetError(f"{_place(owner, name)}: expected pairs {what}, got {shown(pair)}")
    return tuple((first, second) for first, second in pairs)


def as_seed(seed: object) -> int:
    """Return a seed as Python's own integer; NumPy's are accepted.

    Raises:
        CadetError: not a whole number from 0 to `MAX_SEED`.
    """
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or not 0 <= seed <= MAX_SEED:
        raise CadetError(f"seed: expected a whole number from 0 to 2**63 - 1, got {shown(seed)}")
    return int(seed)


def fresh_seed() -> int:
    """Return a seed that nobody chose, drawn by the operating system: ten digits at most, to be written down."""
    return int.from_bytes(os.urandom(4), "little")


def as_path(name: str, path: object) -> Path:
    """Return a path that was given as text or as a `Path`.

    Raises:
        CadetError: it is neither, or no file can have that name.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise CadetError(f"{name}: expected a path, got {shown(path)}")
    text = os.fspath(path)
    if not isinstance(text, str) or not text or "\0" in text:
        raise CadetError(f"{name}: expected a path, got {shown(path)}")
    try:
        whole = os.fsencode(text)
    except UnicodeEncodeError:
        raise CadetError(f"{name}: expected a path, got {shown(path)}") from None
    longest = max(len(part) for part in whole.split(b"/"))
    if len(whole) > MAX_PATH_BYTES or longest > MAX_NAME_BYTES:
        raise CadetError(
            f"{name}: a path of {len(whole)} bytes with a name of {longest}, expected at most {MAX_PATH_BYTES} and "
            f"{MAX_NAME_BYTES}"
        )
    return Path(text)


def plain_number(value: Any) -> Any:
    """Return Python's number for one of NumPy's, whose sums and comparisons are confined to its own few bits."""
    return value.item() if isinstance(value, np.generic) else value


def make_plain(settings: Any) -> None:
    """Put Python's own numbers in place of NumPy's in a frozen dataclass, so that it can be written as JSON."""
    for f in fields(settings):
        value = getattr(settings, f.name)
        if isinstance(value, (np.generic, tuple)):
            object.__setattr__(settings, f.name, _plain(value))


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    # Named tuples and tuples of other objects stay what they are.
    if type(value) is tuple and any(isinstance(item, (np.generic, tuple)) for item in value):
        return tuple(map(_plain, value))
    return value


def _place(owner: str, name: str) -> str:
    return f"{owner}.{name}" if owner else name
