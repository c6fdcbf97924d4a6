"""Where a command writes a dataset to: a folder, or an object store's URL."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from cadet.generate.object_sink import is_url


class Destination(click.Path):
    """A folder, checked as `click.Path` does, or a URL as it stands."""

    name = "folder or URL"

    def __init__(self) -> None:
        super().__init__(path_type=Path, file_okay=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return a `Path`, or the text of a URL."""
        return value if is_url(value) else super().convert(value, param, ctx)
