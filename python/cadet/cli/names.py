"""Lists of names in options: commas between them, or the option several times."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])


def names_option(name: str, *, default: tuple[str, ...] = (), help: str) -> Callable[[F], F]:
    """Make an option whose value is a tuple of names."""
    # Click would show a tuple as Python writes it.
    text = f"{help}  [default: {','.join(default)}]" if default else help
    return click.option(
        name, metavar="LIST", multiple=True, default=default, show_default=False, callback=_split, help=text
    )


def _split(context: click.Context, option: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name.strip() for value in values for name in value.split(",") if name.strip())
