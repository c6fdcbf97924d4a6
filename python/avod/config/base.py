"""The configurations of the package, and files that build on another by `base`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from cadet._util.checks import known_names, shown
from cadet._util.plain_text import toml_from_text
from cadet._util.user_files import read_settings
from cadet.errors import CadetError, FileFormatError

CONFIGS: Final = {path.stem: path for path in sorted((Path(__file__).parent / "presets").glob("*.toml"))}
"""The files of the package, by name."""


def config_names() -> tuple[str, ...]:
    """List the configurations that come with the package."""
    return tuple(CONFIGS)


def with_base(table: Mapping[str, Any], folder: Path, seen: tuple[Path, ...] = ()) -> dict[str, Any]:
    """Return a file's table with what it does not say taken from its `base`: tables key by key, arrays whole.

    Args:
        table: the table.
        folder: what the name of its base is relative to.
        seen: the files that were read on the way here.

    Raises:
        CadetError: a base that is no configuration's name and no file, or bases that build on each other in a circle.
    """
    rest = {key: value for key, value in table.items() if key != "base"}
    if "base" not in table:
        return rest
    name = table["base"]
    if not isinstance(name, str) or not (name in CONFIGS or name.endswith(".toml")):
        raise CadetError(
            f"base: unknown configuration {shown(name)}; {known_names(name, CONFIGS, ', or a .toml file')}"
        )
    path = CONFIGS.get(name, folder / name)
    if path in seen:
        circle = " -> ".join(map(str, (*seen, path)))
        raise CadetError(f"base: configurations build on each other in a circle: {circle}")
    base = with_base(toml_from_text(read_settings(path), str(path)), path.parent, (*seen, path))
    return merged(base, rest)


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with changes in it: tables are merged key by key, arrays replaced."""
    found = dict(base)
    for key, value in changes.items():
        old = found.get(key)
        found[key] = merged(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return found


def table_of_settings(settings: Sequence[str]) -> dict[str, Any]:
    """Return what texts such as "training.steps=100" say, as a file would: values are TOML, or strings as they are.

    Raises:
        CadetError: a text of another form.
    """
    table: dict[str, Any] = {}
    for text in settings:
        key, equals, value = text.partition("=")
        try:
            if not equals:
                raise CadetError(f"--set {text}: no value")
            try:
                found = toml_from_text(f"{key} = {value}", "--set")
            except FileFormatError:
                found = toml_from_text(f"{key} = {json.dumps(value)}", "--set")
        except CadetError:
            raise CadetError(
                f"--set: expected KEY=VALUE such as training.learning_rate=1e-4, got {shown(text)}"
            ) from None
        table = merged(table, found)
    return table
