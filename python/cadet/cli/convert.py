"""`cadet convert`."""

from __future__ import annotations

from pathlib import Path

import click

from cadet.errors import CadetError
from cadet.formats.bdd100k import convert_bdd100k
from cadet.formats.convert import FORMATS, convert
from cadet.formats.webdataset.exporter import SHARD_SIZE

_SHOWN = 3


@click.command(name="convert")
@click.argument("source", metavar="SRC")
@click.argument("out", metavar="DST", type=click.Path(path_type=Path, file_okay=False))
@click.option("--to", type=click.Choice(FORMATS), required=True, help="The format of DST.")
@click.option(
    "--shard-size", type=click.IntRange(1, 10_000), default=SHARD_SIZE, show_default=True, help="Frames per shard."
)
@click.option(
    "--images", metavar="DIR", type=click.Path(path_type=Path, file_okay=False), help="The folder of BDD100K's images."
)
def convert_command(source: str, out: Path, to: str, shard_size: int, images: Path | None) -> None:
    """Write the dataset SRC in another format to the folder DST, byte for byte, or its images or scans.

    SRC may be a .json file of BDD100K's labels, too: with its --images it becomes a KITTI folder without scans.

    \b
    cadet convert kitti shards --to webdataset
    cadet convert shards kitti --to kitti
    cadet convert 'shards/train/{000000..000003}.tar' some --to kitti
    cadet convert kitti coco --to coco               # images, and annotations/instances_train.json
    cadet convert kitti scans --to pcd               # or ply, las, npz: points_pcd/ID.pcd
    cadet convert det_train.json bdd --to kitti --images bdd100k/images/100k/train
    """  # noqa: D301 - click reads the backspace
    if source.endswith(".json"):
        if images is None or to != "kitti":
            raise CadetError(f"{source}: labels of BDD100K become a KITTI folder: --to kitti --images DIR")
        click.echo(f"{convert_bdd100k(source, images, out)} frames in {out}", err=True)
        return
    if images is not None:
        raise CadetError("--images belongs to labels of BDD100K, a .json file")
    done = convert(source, out, to, shard_size=shard_size)
    if done.left_out:
        names = ", ".join(done.left_out[:_SHOWN])
        more = f" and {len(done.left_out) - _SHOWN} more" if len(done.left_out) > _SHOWN else ""
        click.echo(f"left out, as no frame's: {names}{more}", err=True)
    click.echo(f"{done.num_frames} frames in {out}", err=True)
