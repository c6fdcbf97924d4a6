"""`cadet gallery`: contact sheets of what scenes are made of."""

from __future__ import annotations

from pathlib import Path

import click

from cadet.cli.names import names_option
from cadet.figures.gallery import PAGES, write_gallery


@click.command(name="gallery")
@click.argument("out", type=click.Path(path_type=Path, file_okay=False))
@names_option("--parts", default=tuple(PAGES), help="What to draw.")
@click.option("--real", type=click.Path(path_type=Path), help="A KITTI folder, to draw its scans beside ours.")
def gallery_command(out: Path, parts: tuple[str, ...], real: Path | None) -> None:
    """Draw contact sheets: families of vehicles, people, districts in several weathers, scans.

    \b
    cadet gallery sheets --parts people
    cadet gallery sheets --real kitti
    """  # noqa: D301 - click reads the backspace
    for path in write_gallery(out, parts, real):
        click.echo(f"wrote {path}")
