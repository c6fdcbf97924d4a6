"""Configurations as TOML files, and as the plain tables that checkpoints carry."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from avod.config import Config
from cadet._util.checks import shown, shown_key
from cadet._util.plain_text import toml_from_text
from cadet._util.user_files import read_settings
from cadet.errors import CadetError

T = TypeVar("T")


def config_names() -> tuple[str, ...]:
    """List the configurations that come with the package."""
    folder = resources.files("avod") / "configs"
    return tuple(sorted(entry.name[:-5] for entry in folder.iterdir() if entry.name.endswith(".toml")))


def load_config(name: str | Path) -> Config:
    """Load a configuration.

    A file may name another by `base = "car_default"` and then holds only what differs; tables are merged key by key,
    arrays are replaced.

    Args:
        name: of a configuration of the package, or a path that ends in ".toml".

    Raises:
        MissingFileError: no such file.
        CadetError: an unknown name or key, or a value that the configuration refuses; file and key are named.
    """
    table = _read(str(name), ())
    return config_from_table(table, str(name))


def config_from_table(table: object, source: str) -> Config:
    """Make a configuration from plain tables, as TOML and JSON give them.

    Args:
        table: the tables.
        source: where they come from, for messages.

    Raises:
        CadetError: an unknown key, or a value that the configuration refuses; source and key are named.
    """
    return _build(Config, table, source, "")


def table_from_config(config: Config) -> dict[str, Any]:
    """Return a configuration as plain tables: the inverse of `config_from_table`."""
    return dataclasses.asdict(config)


def _read(name: str, seen: tuple[str, ...]) -> dict[str, Any]:
    if name in seen:
        raise CadetError(f"{name}: base: configurations build on each other in a circle: {' -> '.join((*seen, name))}")
    if name.endswith(".toml"):
        data = read_settings(Path(name))
    elif name in config_names():
        data = (resources.files("avod") / "configs" / f"{name}.toml").read_bytes()
    else:
        raise CadetError(f"unknown configuration {name!r}: expected a .toml file or one of {', '.join(config_names())}")
    table = toml_from_text(data, name)
    base = table.pop("base", None)
    if base is None:
        return table
    if not isinstance(base, str):
        raise CadetError(f"{name}: base: expected a name, got {base!r}")
    return _merged(_read(base, (*seen, name)), table)


def _merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in changes.items():
        old = merged.get(key)
        merged[key] = _merged(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return merged


def _build(cls: type[T], table: object, source: str, path: str) -> T:
    where = f"{source}: {path}" if path else source
    if not isinstance(table, Mapping):
        raise CadetError(f"{where}: expected a table, got {shown(table)}")
    known = [f.name for f in dataclasses.fields(cls)]  # type: ignore[arg-type]
    for key in table:
        if key not in known:
            raise CadetError(f"{source}: {_join(path, shown_key(key))}: unknown key; known: {', '.join(known)}")
    hints = get_type_hints(cls)
    values = {key: _convert(hints[key], value, source, _join(path, key)) for key, value in table.items()}
    try:
        return cls(**values)
    except CadetError as error:
        raise CadetError(f"{where}: {error}") from None


def _convert(kind: Any, value: object, source: str, path: str) -> Any:
    if dataclasses.is_dataclass(kind) and isinstance(kind, type):
        return _build(kind, value, source, path)
    if get_origin(kind) is tuple:
        return _convert_tuple(get_args(kind), value, source, path)
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            choices = ", ".join(repr(choice) for choice in get_args(kind))
            raise CadetError(f"{source}: {path}: expected one of {choices}, got {shown(value)}")
        return value
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise CadetError(f"{source}: {path}: expected {_KINDS.get(kind, kind.__name__)}, got {shown(value)}")
    return value


_KINDS = {float: "a number", int: "a whole number", str: "a string", bool: "true or false"}


def _convert_tuple(kinds: tuple[Any, ...], value: object, source: str, path: str) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        raise CadetError(f"{source}: {path}: expected an array, got {shown(value)}")
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    if len(kinds) != len(value):
        raise CadetError(f"{source}: {path}: expected {len(kinds)} values, got {len(value)}")
    pairs = enumerate(zip(kinds, value, strict=True))
    return tuple(_convert(kind, item, source, f"{path}[{index}]") for index, (kind, item) in pairs)


def _join(path: str, key: object) -> str:
    return f"{path}.{key}" if path else str(key)
