"""Lists of names in options: commas between them, or the option several times."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])


def names_option(name: str, *, default: tuple[str, ...] = (), help: str) -> Callable[[F], F]:
    """Make an option whose value is a tuple of names."""
    return click.option(
        name, metavar="LIST", multiple=True, default=default, show_default=",".join(default) or False, callback=_split, help=help
    )


def _split(context: click.Context, option: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name.strip() for value in values for name in value.split(",") if name.strip())
