"""`cadet`: shows, checks, and evaluates datasets, generated or real."""

from __future__ import annotations

import re
from pathlib import Path

import click

from cadet import _cadet, kitti
from cadet.cli.bank import bank_command
from cadet.cli.check import check_command
from cadet.cli.convert import convert_command
from cadet.cli.eval import evaluate_command
from cadet.cli.gallery import gallery_command
from cadet.cli.lidar import fit_lidar_command, lidar_command
from cadet.cli.report import report_command
from cadet.errors import CadetError, MissingFileError
from cadet.view import overview, view_bev_maps, view_frame
from cadet.view.picture import check_picture_path

_OVERVIEW_ROWS = 4


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(_cadet.__version__, prog_name="cadet")
def cadet() -> None:
    """Show, check, and evaluate datasets in KITTI's format, generated or real."""


@cadet.command()
@click.argument("what", metavar="ROOT[/ID]", type=click.Path(path_type=Path))
@click.option(
    "-o", "--out", type=click.Path(path_type=Path, dir_okay=False), help="A .png, .jpg or .rrd.  [default: ID.png]"
)
@click.option("--rerun", "is_rerun", is_flag=True, help="Write the frame's episode for Rerun.  [default: ID.rrd]")
@click.option("--bev", "is_bev", is_flag=True, help="Draw the frame's bird's-eye-view maps.  [default PNG: ID_bev.png]")
def view(what: Path, out: Path | None, is_rerun: bool, is_bev: bool) -> None:
    """Draw a frame, or some frames of a dataset.

    \b
    cadet view out/000012                   # one frame: boxes, LIDAR returns, the view from above
    cadet view out/000012 --bev             # its maps from above, as AVOD and the paper's variants take them
    cadet view out -o overview.png          # some frames of the dataset
    cadet view out --rerun -o episode.rrd   # the first episode over time; "rerun episode.rrd" shows it
    """  # noqa: D301 - click reads the backspace
    is_frame = not what.is_dir() and re.fullmatch(r"\d{6}", what.name) is not None
    if not is_frame and not what.exists() and re.fullmatch(r"\d{1,5}", what.name):
        raise MissingFileError(
            f"{what}: no such folder; a frame's id has six digits: {what.with_name(what.name.zfill(6))}"
        )
    if is_rerun:
        if is_bev:
            raise CadetError("--rerun: shows scan, image and boxes; leave out --bev")
        from cadet.view.recording import view_episode

        root, name = (what.parent, what.name) if is_frame else (what, None)
        click.echo(f"wrote {view_episode(root, name, out or Path(f'{name or what.resolve().name}.rrd'))}")
        return
    if is_bev and not is_frame:
        raise CadetError(f"{what}: --bev draws one frame; name it, as in {what}/000012")
    if out is not None:
        check_picture_path(out)
    if is_bev:
        path = view_bev_maps(kitti.read_frame(what.parent, what.name), out or Path(f"{what.name}_bev.png"))
    elif not is_frame:
        path = _view_some(what, out or Path("overview.png"))
    else:
        path = view_frame(what.parent, what.name, out or Path(f"{what.name}.png"))
    click.echo(f"wrote {path}")


def _view_some(root: Path, out: Path) -> Path:
    dataset = kitti.Dataset(root)
    if len(dataset) == 0:
        raise CadetError(f"{root}: no frames")
    rows = min(_OVERVIEW_ROWS, len(dataset))
    # Spread over the set, so that several episodes show.
    return overview((dataset[index * len(dataset) // rows] for index in range(rows)), out)


cadet.add_command(bank_command)
cadet.add_command(check_command)
cadet.add_command(convert_command)
cadet.add_command(evaluate_command)
cadet.add_command(fit_lidar_command)
cadet.add_command(gallery_command)
cadet.add_command(lidar_command)
cadet.add_command(report_command)
