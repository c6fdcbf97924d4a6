"""`cadet`: generates, shows, checks, and evaluates datasets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import click

from cadet import _cadet
from cadet._util.checks import shown_key
from cadet.cli.bank import bank_command
from cadet.cli.check import check_command
from cadet.cli.convert import convert_command
from cadet.cli.doctor import doctor_command
from cadet.cli.eval import evaluate_command
from cadet.cli.gallery import gallery_command
from cadet.cli.gen import cadet_gen
from cadet.cli.lidar import fit_lidar_command, lidar_command
from cadet.cli.report import report_command
from cadet.cli.task_group import TaskGroup
from cadet.cli.verify import verify_command
from cadet.errors import CadetError, MissingFileError
from cadet.figures.bev_maps import view_bev_maps
from cadet.figures.picture import check_picture_path, write_picture
from cadet.figures.sheet import overview, sheet
from cadet.formats import kitti
from cadet.formats.kitti.files.unreadable import READING_ERRORS, Unreadable
from cadet.formats.kitti.image_sets import check_not_empty
from cadet.formats.webdataset import ShardDataset, open_dataset

_OVERVIEW_ROWS: Final = 4
_NAMED: Final = 4


@click.group(
    cls=TaskGroup,
    tasks={
        "Make": ("gen", "lidar", "fit-lidar"),
        "Look": ("view", "report", "gallery"),
        "Check and change": ("check", "verify", "convert", "bank", "doctor"),
        "Evaluate": ("eval",),
    },
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="avod trains detectors on such datasets, and detects: avod --help.",
)
@click.version_option(_cadet.__version__, prog_name="cadet")
def cadet() -> None:
    """Generate, show, check, and evaluate datasets in KITTI's format.

    \b
    cadet gen out -n 40       # streets, as a KITTI folder; cadet-gen is the same
    cadet view out            # a picture of some frames
    cadet check out           # whether all is there, and right
    cadet eval out results    # KITTI's AP of a detector's result files
    """  # noqa: D301 - click reads the backspace


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
    if out is not None and not is_rerun:
        check_picture_path(out)
    root, frame_id = _named(what)
    if is_rerun:
        if is_bev:
            raise CadetError("--rerun: shows scan, image and boxes; leave out --bev")
        from cadet.figures.recording import view_episode

        name = frame_id or what.resolve().name
        click.echo(f"wrote {view_episode(root, frame_id, out or Path(f'{name}.rrd'))}")
        return
    if is_bev and frame_id is None:
        raise CadetError(f"{what}: --bev draws one frame; name it, as in {what}/000012")
    dataset = open_dataset(root)
    if frame_id is None:
        path = _view_some(dataset, root, out or Path("overview.png"))
    elif is_bev:
        path = view_bev_maps(dataset.read_frame(frame_id), out or Path(f"{frame_id}_bev.png"))
    else:
        page = sheet(dataset.read_frame(frame_id), title=f"{root.resolve().name} / {frame_id}")
        path = write_picture(out or Path(f"{frame_id}.png"), page)
    click.echo(f"wrote {path}")


def _named(what: Path) -> tuple[Path, str | None]:
    """Tell a dataset's folder from ROOT/ID, which names a frame.

    Raises:
        MissingFileError: neither is there; the line says which frames there are.
    """
    if what.is_dir():
        return what, None
    if what.exists():
        raise MissingFileError(f"{what}: is not a folder: expected a dataset's, or ROOT/ID")
    root, name = what.parent, what.name
    try:
        ids = open_dataset(root).ids
    except MissingFileError:
        raise MissingFileError(f"{what}: no such folder, and no frame: {root} is no dataset") from None
    if name in ids:
        return root, name
    matching = [one for one in ids if name.isdecimal() and one.isdecimal() and int(one) == int(name)]
    hint = f"did you mean {root / matching[0]}" if matching else f"its frames are {_some(ids)}"
    raise MissingFileError(f"{root}: no frame {shown_key(name)}: {hint}")


def _some(ids: Sequence[str]) -> str:
    return ", ".join(ids) if len(ids) <= _NAMED else f"{', '.join(ids[: _NAMED - 1])} ... {ids[-1]} ({len(ids)} in all)"


def _view_some(dataset: kitti.Dataset | ShardDataset, root: Path, out: Path) -> Path:
    check_not_empty(dataset.ids, root, None)
    rows = min(_OVERVIEW_ROWS, len(dataset))
    unreadable = Unreadable(root)

    def frames() -> Iterator[kitti.Frame]:
        for index in range(rows):
            # Spread over the set, so that several episodes show.
            frame_id = dataset.ids[index * len(dataset) // rows]
            try:
                yield dataset.read_frame(frame_id)
            except READING_ERRORS as error:
                unreadable.add(frame_id, error)
        unreadable.say(rows)

    return overview(frames(), out)


cadet.add_command(bank_command)
cadet.add_command(check_command)
cadet.add_command(convert_command)
cadet.add_command(doctor_command)
cadet.add_command(evaluate_command)
cadet.add_command(fit_lidar_command)
cadet.add_command(gallery_command)
cadet.add_command(cadet_gen, "gen")
cadet.add_command(lidar_command)
cadet.add_command(report_command)
cadet.add_command(verify_command)
