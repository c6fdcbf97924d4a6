"""Lists of names in one option, with commas between them."""

from __future__ import annotations

from typing import Any

import click


class Names(click.ParamType):
    """Names that commas separate; an option of this type may be given several times, too."""

    name = "list"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        """Return the names."""
        return value if isinstance(value, tuple) else tuple(filter(None, (name.strip() for name in value.split(","))))
