"""Configurations as the plain tables that checkpoints carry, and changes of them by key."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from avod.config.base import merged
from avod.config.detector import Config
from cadet.errors import CadetError


def config_from_table(table: Any, source: str) -> Config:
    """Make a configuration from plain tables, as TOML and JSON give them.

    Args:
        table: the tables.
        source: where they come from, for messages.

    Raises:
        CadetError: an unknown key, or a value that the configuration refuses; source and key are named.
    """
    try:
        return Config._of_table(table, Path())
    except CadetError as error:
        raise CadetError(f"{source}: {error}") from None


def table_from_config(config: Config) -> dict[str, Any]:
    """Return a configuration as plain tables: the inverse of `config_from_table`."""
    return dataclasses.asdict(config)


def changed_config(config: Config, changes: Mapping[str, Any]) -> Config:
    """Return a configuration with other values.

    Args:
        config: the configuration.
        changes: tables with what differs, as a file that builds on it would have them.

    Raises:
        CadetError: an unknown key, or a value that the configuration refuses; the key is named.
    """
    return config if not changes else config_from_table(merged(config._table(), changes), "--set")


def differences(old: object, new: object, path: str = "") -> Iterator[tuple[str, object, object]]:
    """Yield the path, the old and the new value of each entry that differs between two tables."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in {**old, **new}:
            yield from differences(old.get(key), new.get(key), f"{path}.{key}" if path else str(key))
    elif old != new:
        yield path, old, new
