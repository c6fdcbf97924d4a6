"""TOML and JSON, read in one place: damage, deep nesting and endless numbers are refused with file and line."""

from __future__ import annotations

import json
import re
import sys
from typing import Any, Final

from cadet.errors import FileFormatError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MAX_DEPTH: Final = 64
"""Tables and lists stand at most this deep in each other."""


def toml_from_text(text: str | bytes, file: str) -> dict[str, Any]:
    """Parse TOML.

    Args:
        text: the text, or its bytes in UTF-8.
        file: its name, for messages.

    Raises:
        FileFormatError: not UTF-8, not TOML, nested deeper than `MAX_DEPTH`, or a whole number of thousands of digits.
    """
    try:
        values = tomllib.loads(text if isinstance(text, str) else text.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise FileFormatError(f"no TOML: {error}", file) from None
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"no TOML: {_reason(error)}", file) from None
    _check_depth(values, file)
    return values


def json_from_text(text: str | bytes, file: str) -> Any:
    """Parse JSON, strictly: NaN and infinity are not numbers in it.

    Args:
        text: the text, or its bytes in UTF-8.
        file: its name, for messages.

    Raises:
        FileFormatError: not UTF-8, not JSON, nested deeper than `MAX_DEPTH`, or a whole number of thousands of digits.
    """
    try:
        values = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"no JSON: {_reason(error)}", file, getattr(error, "lineno", None)) from None
    _check_depth(values, file)
    return values


def _refuse_constant(constant: str) -> object:
    raise ValueError(f"{constant} is no number")


def _reason(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return f"nested deeper than {MAX_DEPTH}"
    if re.match(r"Exceeds the limit", str(error)):
        return "a whole number has too many digits"
    return str(error)


def _check_depth(values: Any, file: str) -> None:
    """Refuse what can't be walked through, printed and merged without a thought for the stack."""
    level = [values]
    for _ in range(MAX_DEPTH):
        level = [
            child
            for value in level
            if isinstance(value, (dict, list))
            for child in (value.values() if isinstance(value, dict) else value)
        ]
        if not level:
            return
    raise FileFormatError(f"nested deeper than {MAX_DEPTH}", file)
