"""TOML and JSON, read in one place: damage, deep nesting and values that nothing can hold are refused by place."""

from __future__ import annotations

import json
import math
import re
import sys
from typing import Any, Final

from cadet._util.checks import shown_key
from cadet.errors import FileFormatError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MAX_DEPTH: Final = 64
"""Tables and lists stand at most this deep in each other."""
MAX_WHOLE: Final = 2**64
"""Whole numbers are smaller, negative ones greater than minus this: what the core and NumPy can hold."""

# TOML's parser takes minutes for some ten thousand dotted keys; each part of the pattern ends at the next dot.
_KEY: Final = r"""[^\s.,=#\[\]{}"']{1,200}|"[^"\n]{0,200}"|'[^'\n]{0,200}'"""
_DOTTED_KEYS: Final = re.compile(rf"(?:\.[ \t]{{0,20}}(?:{_KEY})[ \t]{{0,20}}){{{MAX_DEPTH}}}")


def toml_from_text(text: str | bytes, file: str) -> dict[str, Any]:
    """Parse TOML.

    Args:
        text: the text, or its bytes in UTF-8.
        file: its name, for messages.

    Raises:
        FileFormatError: not UTF-8, not TOML, or a value that `_check_values` refuses.
    """
    try:
        # tomllib takes CRLF for a newline, but no byte order mark.
        decoded = (text if isinstance(text, str) else text.decode("utf-8")).removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        raise FileFormatError(f"invalid TOML: {error}", file) from None
    if _DOTTED_KEYS.search(decoded):
        raise FileFormatError(f"nested deeper than {MAX_DEPTH}", file)
    try:
        values = tomllib.loads(decoded)
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"invalid TOML: {_reason(error)}", file) from None
    # TOML has infinity, which its readers refuse by the line.
    _check_values(values, file, is_infinity_refused=False)
    return values


def json_from_text(text: str | bytes, file: str) -> Any:
    """Parse JSON, strictly: NaN and infinity are not numbers in it.

    Args:
        text: the text, or its bytes in UTF-8.
        file: its name, for messages.

    Raises:
        FileFormatError: not UTF-8, not JSON, or a value that `_check_values` refuses.
    """
    try:
        values = json.loads(text.removeprefix("\ufeff") if isinstance(text, str) else text, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"invalid JSON: {_reason(error)}", file, getattr(error, "lineno", None)) from None
    _check_values(values, file, is_infinity_refused=True)
    return values


def _refuse(constant: str) -> object:
    raise ValueError(f"{constant} is not a number")


def _reason(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return f"nested deeper than {MAX_DEPTH}"
    if re.match(r"Exceeds the limit", str(error)):
        return "a whole number has too many digits"
    return str(error)


def _check_values(values: Any, file: str, *, is_infinity_refused: bool) -> None:
    """Refuse what readers can't handle, and name its place.

    Raises:
        FileFormatError: nesting that overflows the stack of who walks through it, a whole number beyond `MAX_WHOLE`,
            JSON's numbers beyond floating point, text that can't be written (half of a surrogate pair).
    """
    level: list[tuple[str, Any]] = [("", values)]
    for _ in range(MAX_DEPTH):
        children: list[tuple[str, Any]] = []
        for place, value in level:
            if isinstance(value, dict):
                for key, child in value.items():
                    _check_leaf(key, place or "key", file)
                    children.append((f"{place}.{key}" if place else key, child))
            elif isinstance(value, list):
                children += [(f"{place}[{index}]", child) for index, child in enumerate(value)]
            elif isinstance(value, float):
                if is_infinity_refused and math.isinf(value):
                    raise FileFormatError(f"{shown_key(place)}: expected a finite number, got {value}", file)
            else:
                _check_leaf(value, place, file)
        if not children:
            return
        level = children
    raise FileFormatError(f"nested deeper than {MAX_DEPTH}", file)


def _check_leaf(value: object, place: str, file: str) -> None:
    if isinstance(value, str):
        if not value.isascii():
            try:
                value.encode("utf-8")
            except UnicodeEncodeError:
                raise FileFormatError(
                    f"{shown_key(place)}: {value!r} is not valid text: half of a surrogate pair", file
                ) from None
    elif isinstance(value, int) and not -MAX_WHOLE < value < MAX_WHOLE:
        digits = int(abs(value).bit_length() * math.log10(2.0)) + 1
        raise FileFormatError(f"{shown_key(place)}: a whole number of {digits} digits, expected one below 2**64", file)
