"""`avod clusters`."""

from __future__ import annotations

from pathlib import Path

import click

from avod.cli.options import check_split, resolve_split, split_option
from avod.clusters import anchor_sizes, toml_of
from cadet.errors import CadetError
from cadet.formats.kitti.label import is_object_type, kitti_spelling

_MOST = 64


@click.command(name="clusters")
@click.argument("data", metavar="DATA", type=click.Path(path_type=Path))
@split_option("train")
@click.option(
    "--class",
    "classes",
    metavar="NAME=COUNT",
    multiple=True,
    default=("Car=2", "Pedestrian=1", "Cyclist=1"),
    show_default=True,
    help="A class and the number of its anchor sizes; may be repeated.",
)
def clusters_command(data: Path, split: str | None, classes: tuple[str, ...]) -> None:
    """Fit anchor sizes to the labels of a KITTI folder, and print them as a configuration holds them.

    \b
    avod clusters kitti --split train --class Car=2 > sizes.toml
    """  # noqa: D301 - click reads the backspace
    name = resolve_split(split)
    check_split(data, name)
    click.echo(toml_of(anchor_sizes(data, name, dict(_count(text) for text in classes))), nl=False)


def _count(text: str) -> tuple[str, int]:
    name, _, count = text.partition("=")
    if not is_object_type(name) or not count.isascii() or not count.isdecimal():
        raise CadetError(f"--class: expected a type of labels and a count, such as Car=2, got {text!r}")
    if not 1 <= int(count[:9]) <= _MOST:
        raise CadetError(f"--class: expected 1 to {_MOST} sizes, got {text!r}")
    return kitti_spelling(name), int(count)
