"""Own classes and levels of difficulty, read from a TOML file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

from cadet._util.checks import as_path
from cadet._util.plain_text import toml_from_text
from cadet._util.user_files import read_settings
from cadet.errors import CadetError, FileFormatError
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.levels import Level, resolve_levels

T = TypeVar("T")
_SECTIONS = ("level", "class")


@dataclass(frozen=True)
class Rules:
    """What a file says must be found.

    Attributes:
        levels: its levels, in the order of the file; empty if it has none.
        classes: its classes, likewise.
    """

    levels: tuple[Level, ...]
    classes: tuple[EvalClass, ...]

    @classmethod
    def from_toml(cls, text: str | bytes, file: str = "rules") -> Rules:
        """Parse a file of levels (`[[level]]`) and classes (`[class.NAME]`).

        Args:
            text: the file's text.
            file: its name for messages.

        Raises:
            FileFormatError: invalid TOML, an unknown or missing key, or a value that its class refuses.
        """
        table = toml_from_text(text, file)
        for name in table:
            if name not in _SECTIONS:
                raise FileFormatError(f"unknown key {name!r}, expected some of {', '.join(_SECTIONS)}", file)
        levels, classes = table.get("level", []), table.get("class", {})
        if not isinstance(levels, list) or not all(isinstance(level, dict) for level in levels):
            raise FileFormatError("level: expected tables [[level]]", file)
        if not isinstance(classes, dict) or not all(isinstance(entry, dict) for entry in classes.values()):
            raise FileFormatError("class: expected tables [class.NAME]", file)
        if not levels and not classes:
            raise FileFormatError("neither a [[level]] nor a [class.NAME]", file)
        found = tuple(_made(Level, level, f"level {number}", file) for number, level in enumerate(levels, start=1))
        own = tuple(_made(_class, {"name": n, **c}, f"class {n}", file, EvalClass) for n, c in classes.items())
        if found:
            _checked(lambda: resolve_levels(found), file)
        return cls(found, own)


def read_rules(path: str | Path) -> Rules:
    """Read a file of own levels and classes.

    Raises:
        MissingFileError: no such file.
        FileFormatError: a file that says anything else, named with what is wrong.
    """
    path = as_path("rules", path)
    return Rules.from_toml(read_settings(path, missing=f"{path}: no such file of levels"), str(path))


def _class(**values: Any) -> EvalClass:
    # A class of the name of a type is that type, unless it says otherwise.
    return EvalClass(**{"types": (values["name"],), **values})


def _made(make: Callable[..., T], values: dict[str, Any], where: str, file: str, kind: type | None = None) -> T:
    known = [field.name for field in fields(kind or make)]  # type: ignore[arg-type]
    for key in values:
        if key not in known:
            raise FileFormatError(f"{where}: unknown key {key!r}, expected some of {', '.join(known)}", file)
    needed = {"class": ("min_overlap",), "level": ("name", "min_height_px")}[where.split()[0]]
    for key in needed:
        if key not in values:
            raise FileFormatError(f"{where}: {key} is missing", file)
    return _checked(lambda: make(**values), file)


def _checked(make: Callable[[], T], file: str) -> T:
    try:
        return make()
    except CadetError as error:
        raise FileFormatError(str(error), file) from None
