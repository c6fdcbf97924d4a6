"""`cadet verify`: whether a dataset is what its recipe says."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import click

from cadet._util.operating_system import num_processors
from cadet.cli.destination import Destination
from cadet.errors import MissingFileError
from cadet.generate import RECIPE, Recipe, compare
from cadet.generate.object_sink import open_sink

_SHOWN: Final = 10


@click.command(name="verify")
@click.argument("root", type=Destination())
@click.option(
    "--recipe",
    "recipe_file",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help=f"What it is said to be made from.  [default: ROOT/{RECIPE}]",
)
@click.option(
    "-n",
    "--num-frames",
    type=click.IntRange(1, 1_000_000),
    default=20,
    show_default=True,
    help="How many frames are made again.",
)
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True, help="Draws which.")
@click.option("--workers", type=click.IntRange(1, 1024), help="Worker processes.  [default: one per processor]")
def verify_command(root: str | Path, recipe_file: Path | None, num_frames: int, seed: int, workers: int | None) -> int:
    """Make some frames of a dataset again from its recipe, and compare them with its files; exit 1 if any differs.

    If the recipe has the hash of the dataset's manifest, that is compared too. "cadet check" then compares all files
    with the manifest.

    \b
    cadet verify out
    cadet verify out --recipe published.toml -n 100
    """  # noqa: D301 - click reads the backspace
    recipe = _recipe_in(root) if recipe_file is None else Recipe.read(recipe_file)
    found = compare(root, recipe, num_frames=num_frames, seed=seed, workers=workers or num_processors())
    bad = [f"missing  {name}" for name in found.missing] + [f"differs  {name}" for name in found.differing]
    for line in bad[:_SHOWN]:
        click.echo(line)
    if len(bad) > _SHOWN:
        click.echo(f"... and {len(bad) - _SHOWN} more")
    same = f"{found.num_files - len(bad)} of {found.num_files} files are the recipe's, byte for byte"
    click.echo(f"{found.num_frames} of {recipe.settings.num_frames} frames made again: {same}")
    return 1 if bad else 0


def _recipe_in(root: str | Path) -> Recipe:
    sink = open_sink(root)
    try:
        text = sink.read(RECIPE)
    except FileNotFoundError:
        raise MissingFileError(f"{sink.location}: there is no {RECIPE} in it: name one with --recipe") from None
    return Recipe.from_toml(text, file=f"{sink.location}/{RECIPE}")
