"""`cadet bank`: objects cut out of labeled frames."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click
from rich.console import Console

from cadet._util.checks import shown
from cadet.cli.progress import reporter
from cadet.datasets.object_bank import BankObject, cut_objects, write_bank
from cadet.datasets.object_bank.cut import MIN_POINTS
from cadet.errors import CadetError
from cadet.formats.kitti.files.folder import REQUIRED
from cadet.formats.kitti.files.unreadable import READING_ERRORS, Unreadable, frames_with_files
from cadet.formats.kitti.image_sets import check_not_empty
from cadet.formats.kitti.label import is_object_type, kitti_spelling
from cadet.formats.webdataset import open_dataset


def _types(context: click.Context, option: click.Parameter, names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if not is_object_type(name):
            raise CadetError(f"--class: expected a type of labels such as Car, got {shown(name)}")
    return tuple(map(kitti_spelling, names))


@click.command(name="bank")
@click.argument("data", metavar="DATA", type=click.Path(path_type=Path))
@click.option(
    "-o", "--out", required=True, type=click.Path(path_type=Path, file_okay=False), help="Output: a new folder."
)
@click.option("--split", metavar="NAME", help="A list of ImageSets.  [default: every frame]")
@click.option(
    "--class",
    "types",
    multiple=True,
    metavar="TYPE",
    callback=_types,
    default=("Car", "Pedestrian", "Cyclist"),
    show_default=True,
    help="May be repeated.",
)
@click.option(
    "--min-points",
    type=click.IntRange(1),
    default=MIN_POINTS,
    show_default=True,
    help="Leave out objects with fewer points.",
)
def bank_command(data: Path, out: Path, split: str | None, types: tuple[str, ...], min_points: int) -> None:
    """Cut the fully visible objects out of a labeled KITTI folder, real or generated, with points and pixels.

    `avod train --bank` pastes them into other frames. Sets written with `--write instance` give exact silhouettes; of
    others they are hulls of the objects' points, refined by colors.

    \b
    cadet bank kitti -o bank --split train
    """  # noqa: D301 - click reads the backspace
    seen: set[str] = set()
    dataset = open_dataset(data, split)
    check_not_empty(dataset.ids, data, split)
    unreadable = Unreadable(data)
    ids = frames_with_files(dataset, unreadable, data, (*REQUIRED, "label_2"))
    with reporter(Console(stderr=True, highlight=False), len(ids), text="cutting", unit="frames") as report:

        def objects() -> Iterator[BankObject]:
            for frame_id in ids:
                try:
                    frame = dataset.read_frame(frame_id)
                except READING_ERRORS as error:
                    unreadable.add(frame_id, error)
                else:
                    seen.update(label.type for label in frame.labels)
                    yield from cut_objects(frame, types, f"{data}/{frame_id}", min_points=min_points)
                report.advance()
            unreadable.say(len(dataset.ids))

            if not seen & set(types):
                there = f"; they have {', '.join(sorted(seen))}" if seen else ""
                raise CadetError(f"{data}: no label has the type {' or '.join(types)}{there}")

        found = write_bank(out, objects())
    listed = ", ".join(f"{found[name]} {name}" for name in types)
    click.echo(f"wrote {out}: {listed} from {len(dataset.ids) - len(unreadable)} frames")
