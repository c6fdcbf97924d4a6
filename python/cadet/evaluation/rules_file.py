"""Own classes and levels of difficulty, read from a TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

from cadet._util.plain_tables import check_keys, table_of_object
from cadet._util.toml_file import TomlFile
from cadet.errors import CadetError
from cadet.evaluation.classes import EvalClass
from cadet.evaluation.levels import Level, resolve_levels

_LEVEL: Final = tuple(f.name for f in fields(Level))
_CLASS: Final = tuple(f.name for f in fields(EvalClass) if f.name != "name")


@dataclass(frozen=True)
class Rules(TomlFile):
    """What a file says must be found: `[[levels]]` and `[classes.NAME]`, with the fields of `Level` and `EvalClass`.

    Attributes:
        levels: its levels, in the order of the file; empty if it has none.
        classes: its classes, likewise.
    """

    levels: tuple[Level, ...] = ()
    classes: tuple[EvalClass, ...] = ()

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> Rules:
        check_keys(table, ("levels", "classes"))
        levels, classes = table.get("levels", []), table.get("classes", {})
        if not isinstance(levels, list) or not all(isinstance(level, dict) for level in levels):
            raise CadetError("levels: expected tables [[levels]]")
        if not isinstance(classes, dict) or not all(isinstance(entry, dict) for entry in classes.values()):
            raise CadetError("classes: expected tables [classes.NAME]")
        if not levels and not classes:
            raise CadetError("neither a [[levels]] nor a [classes.NAME]")
        found = []
        for number, level in enumerate(levels, start=1):
            check_keys(level, _LEVEL, _LEVEL[:2], f"level {number}")
            found.append(Level(**level))
        if found:
            resolve_levels(tuple(found))
        return cls(tuple(found), tuple(_class(name, entry) for name, entry in classes.items()))

    def _table(self) -> dict[str, Any]:
        classes = {one.name: table_of_object(one) for one in self.classes}
        for entry in classes.values():
            del entry["name"]
        return {"levels": [table_of_object(level) for level in self.levels], "classes": classes}


def _class(name: str, entry: Mapping[str, Any]) -> EvalClass:
    check_keys(entry, _CLASS, ("min_overlap",), f"class {name}")
    # A class of the name of a type is that type, unless it says otherwise.
    return EvalClass(**{"name": name, "types": (name,), **entry})
