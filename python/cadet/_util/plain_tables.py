"""Dataclasses as plain tables, as TOML and JSON hold them, and tables as the text of TOML."""

from __future__ import annotations

import dataclasses
import json
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from cadet._util.checks import known_names, shown, shown_key
from cadet.errors import CadetError

T = TypeVar("T")

_LONGEST_ROW = 100
_KINDS = {float: "a number", int: "a whole number", str: "a string", bool: "true or false"}


def check_keys(table: object, known: tuple[str, ...], needed: tuple[str, ...] = (), place: str = "") -> None:
    """Refuse what is no table, a key that is not known, and a table that lacks one that is needed.

    Args:
        table: what a file holds.
        known: the keys that it may have.
        needed: those that it must have.
        place: the table's own key, for messages.

    Raises:
        CadetError: naming the key.
    """
    if not isinstance(table, Mapping):
        raise CadetError(f"{place}{': ' if place else ''}expected a table, got {shown(table)}")
    for key in table:
        if key not in known:
            name = _join(place, shown_key(key))
            raise CadetError(f"{name}: unknown key; {known_names(key, known)}")
    for key in needed:
        if key not in table:
            raise CadetError(f"{_join(place, key)}: missing key")


def check_keys_of(cls: type[Any], table: object, place: str = "") -> None:
    """Refuse, as `check_keys` does, a table whose keys are not the fields of a dataclass that it is to become."""
    fields = [f for f in dataclasses.fields(cls) if f.init]
    needed = (f.name for f in fields if f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING)
    check_keys(table, tuple(f.name for f in fields), tuple(needed), place)


def object_of_table(cls: type[T], table: object, folder: Path, place: str = "") -> T:
    """Make a dataclass from a table whose keys are its fields.

    Args:
        cls: the dataclass. Fields that are dataclasses are tables, tuples are arrays.
        table: the table.
        folder: what the names of files in it are relative to.
        place: the table's own key, for messages.

    Raises:
        CadetError: an unknown or missing key, or a value that the class refuses; the key is named.
    """
    check_keys_of(cls, table, place)
    hints = get_type_hints(cls)
    values = {key: value_of(hints[key], value, folder, _join(place, key)) for key, value in table.items()}  # type: ignore[attr-defined]
    try:
        return cls(**values)
    except CadetError as error:
        raise CadetError(f"{place}: {error}" if place else str(error)) from None


def table_of_object(settings: Any) -> dict[str, Any]:
    """Return a dataclass as a table: the inverse of `object_of_table`, without what is None."""
    values = {f.name: getattr(settings, f.name) for f in dataclasses.fields(settings) if f.init}
    return {name: _plain(value) for name, value in values.items() if value is not None}


def toml_of_table(table: Mapping[str, Any], place: str = "") -> str:
    """Return a table as TOML: numbers and strings first, then the tables in it."""
    lines = [f"{_key(key)} = {_inline(value)}" for key, value in table.items() if not _is_tables(value)]
    text = "".join(f"{line}\n" for line in lines)
    for key, value in table.items():
        if _is_tables(value):
            name = _join(place, _key(key))
            for one in value if isinstance(value, list) else [value]:
                head = f"[[{name}]]" if isinstance(value, list) else f"[{name}]"
                text += f"\n{head}\n{toml_of_table(one, name)}"
    return text


def value_of(kind: Any, value: object, folder: Path, place: str) -> Any:
    """Return a table's value as a field of an annotation holds it.

    Raises:
        CadetError: another kind of value; `place` is named.
    """
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        if value is None and type(None) in inner:
            return None
        kinds = [one for one in inner if one is not type(None)]
        is_array = isinstance(value, list | tuple)
        kind = next((one for one in kinds if (get_origin(one) is tuple) == is_array), kinds[0])
        return value_of(kind, value, folder, place)
    if dataclasses.is_dataclass(kind):
        if not isinstance(value, Mapping):
            raise CadetError(f"{place}: expected a table, got {shown(value)}")
        own = getattr(kind, "_of_table", None)
        return object_of_table(kind, value, folder, place) if own is None else own(value, folder, place)  # type: ignore[arg-type]
    if origin is tuple:
        return _tuple(inner, value, folder, place)
    if origin is Literal:
        if value not in inner:
            choices = ", ".join(repr(choice) for choice in inner)
            raise CadetError(f"{place}: expected one of {choices}, got {shown(value)}")
        return value
    if origin is not None and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            raise CadetError(f"{place}: expected a table, got {shown(value)}")
        return {key: value_of(inner[1], one, folder, _join(place, shown_key(key))) for key, one in value.items()}
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise CadetError(f"{place}: expected {_KINDS.get(kind, kind.__name__)}, got {shown(value)}")
    return value


def _tuple(kinds: tuple[Any, ...], value: object, folder: Path, place: str) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        raise CadetError(f"{place}: expected an array, got {shown(value)}")
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    if len(kinds) != len(value):
        raise CadetError(f"{place}: expected {len(kinds)} values, got {len(value)}")
    pairs = enumerate(zip(kinds, value, strict=True))
    return tuple(value_of(kind, item, folder, f"{place}[{index}]") for index, (kind, item) in pairs)


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        own = getattr(value, "_table", None)
        return table_of_object(value) if own is None else own()
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return {key: _plain(item) for key, item in value.items()} if isinstance(value, Mapping) else value


def _is_tables(value: object) -> bool:
    """Tell whether a value is written as tables of their own: arrays of short tables are rows instead."""
    if isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
        return any(len(_inline(item)) > _LONGEST_ROW or any(map(_is_tables, item.values())) for item in value)
    return isinstance(value, Mapping)


def _inline(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON's strings are TOML's but for one letter.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(key)} = {_inline(item)}' for key, item in value.items())} }}"
    if isinstance(value, list | tuple):
        items = [_inline(item) for item in value]
        if any(isinstance(item, Mapping) for item in value):
            return "".join(["[\n", *(f"    {item},\n" for item in items), "]"])
        return f"[{', '.join(items)}]"
    return str(value)


def _key(key: str) -> str:
    is_bare = key.isascii() and key.replace("-", "_").replace("_", "a").isalnum()
    return key if is_bare else _inline(key)


def _join(place: str, key: object) -> str:
    return f"{place}.{key}" if place else str(key)
