"""`cadet convert`."""

from __future__ import annotations

from pathlib import Path

import click

from cadet.convert import FORMATS, convert
from cadet.webdataset.exporter import SHARD_SIZE

_SHOWN = 3


@click.command(name="convert")
@click.argument("source", metavar="SRC")
@click.argument("out", metavar="DST", type=click.Path(path_type=Path, file_okay=False))
@click.option("--to", type=click.Choice(FORMATS), required=True, help="The format of DST.")
@click.option(
    "--shard-size", type=click.IntRange(1, 10_000), default=SHARD_SIZE, show_default=True, help="Frames of a shard."
)
def convert_command(source: str, out: Path, to: str, shard_size: int) -> None:
    """Write the dataset SRC in another format to the folder DST, byte for byte.

    \b
    cadet convert kitti shards --to webdataset
    cadet convert shards kitti --to kitti
    cadet convert 'shards/train/{000000..000003}.tar' some --to kitti
    """  # noqa: D301 - click reads the backspace
    done = convert(source, out, to, shard_size=shard_size)
    if done.left_out:
        names = ", ".join(done.left_out[:_SHOWN])
        more = f" and {len(done.left_out) - _SHOWN} more" if len(done.left_out) > _SHOWN else ""
        click.echo(f"left out, as no frame's: {names}{more}", err=True)
    click.echo(f"{done.num_frames} frames in {out}", err=True)
