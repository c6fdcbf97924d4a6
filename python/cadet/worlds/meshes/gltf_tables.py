"""The objects of a glTF file's JSON, each value checked where it is taken."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cadet._util.checks import shown
from cadet.errors import FileFormatError

# What a float of 32 bits holds, nearly.
_GREATEST = 1e30


class Table:
    """An object of the JSON. Keys that nobody takes are not looked at.

    Args:
        values: the object.
        where: what leads to it, for messages.
        file: the file's name, for messages.
    """

    def __init__(self, values: object, where: str, file: str) -> None:
        if not isinstance(values, Mapping):
            raise FileFormatError(f"{where or 'invalid glTF'}: expected an object, got {shown(values)}", file)
        self._values: Mapping[str, Any] = values
        self.where = where
        self.file = file

    def __contains__(self, key: str) -> bool:
        return self._values.get(key) is not None

    def bad(self, key: str, expected: str) -> FileFormatError:
        """Return the error of a value that is not what is expected."""
        return FileFormatError(
            f"{self._place(key)}: expected {expected}, got {shown(self._values.get(key))}", self.file
        )

    def whole(self, key: str, default: int | None = None, *, below: int = 1 << 40) -> int:
        """Return a whole number from 0; without a default it must be there."""
        value = self._values.get(key, default)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < below:
            raise self.bad(key, f"a whole number below {below}")
        return value

    def number(self, key: str, default: float) -> float:
        """Return a number."""
        value = self._values.get(key, default)
        if not _is_number(value):
            raise self.bad(key, "a number")
        return float(value)

    def numbers(self, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Return as many numbers as there are in the default."""
        values = self._values.get(key, default)
        if not isinstance(values, (list, tuple)) or len(values) != len(default) or not all(map(_is_number, values)):
            raise self.bad(key, f"{len(default)} numbers")
        return tuple(map(float, values))

    def flag(self, key: str, default: bool = False) -> bool:
        """Return True or False."""
        value = self._values.get(key, default)
        if not isinstance(value, bool):
            raise self.bad(key, "true or false")
        return value

    def text(self, key: str, default: str = "") -> str:
        """Return a text; what no encoding has is replaced in it."""
        value = self._values.get(key, default)
        if not isinstance(value, str):
            raise self.bad(key, "a string")
        return value.encode("utf-8", "replace").decode()

    def texts(self, key: str) -> list[str]:
        """Return a list of strings."""
        values = self._values.get(key, [])
        if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
            raise self.bad(key, "a list of strings")
        return values

    def indices(self, key: str, below: int) -> list[int]:
        """Return a list of whole numbers below another."""
        values = self._values.get(key, [])
        if not isinstance(values, list) or not all(
            isinstance(value, int) and not isinstance(value, bool) and 0 <= value < below for value in values
        ):
            raise self.bad(key, f"whole numbers below {below}")
        return values

    def weights(self, key: str) -> list[float] | None:
        """Return a list of numbers; None where it is not there."""
        values = self._values.get(key)
        if values is None:
            return None
        if not isinstance(values, list) or not all(map(_is_number, values)):
            raise self.bad(key, "a list of numbers")
        return [float(value) for value in values]

    def table(self, key: str) -> Table:
        """Return an object; an empty one where it is not there."""
        return Table(self._values.get(key, {}), self._place(key), self.file)

    def tables(self, key: str) -> list[Table]:
        """Return a list of objects; an empty one where it is not there."""
        values = self._values.get(key, [])
        if not isinstance(values, list):
            raise self.bad(key, "a list of objects")
        return [Table(value, f"{self._place(key)}[{number}]", self.file) for number, value in enumerate(values)]

    def extension(self, name: str) -> Table | None:
        """Return an extension of the object; None where it has none of that name."""
        extensions = self.table("extensions")
        return extensions.table(name) if name in extensions else None

    def _place(self, key: str) -> str:
        return f"{self.where}.{key}" if self.where else key


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= _GREATEST
