"""`avod adapt`: a detector for frames without labels."""

from __future__ import annotations

from pathlib import Path

import click

from avod.adapt import Adaptation, adapt
from avod.cli.options import (
    checkpoint_option,
    device_options,
    frames_of,
    how_to_continue,
    loss_text,
    progress,
    run_of,
    seed_option,
    split_option,
)
from avod.cli.stopping import Stopping
from cadet import kitti
from cadet.errors import CadetError
from cadet.formats.kitti_sequences import RawDrive

_DEFAULT = Adaptation()


@click.command(name="adapt")
@checkpoint_option
@click.option(
    "--data",
    metavar="DIR",
    required=True,
    type=click.Path(path_type=Path),
    help="Frames without labels: a KITTI folder, or a raw drive.",
)
@split_option("all")
@click.option(
    "--source",
    metavar="DIR",
    required=True,
    type=click.Path(path_type=Path),
    help="Labeled frames, generated ones.",
)
@click.option("--source-split", metavar="NAME", default="train", show_default=True, help="A list of theirs, or 'all'.")
@click.option("--out", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Where the rounds go.")
@click.option(
    "--rounds", type=click.IntRange(1, 100), default=_DEFAULT.rounds, show_default=True, help="Of finding and learning."
)
@click.option("--steps", type=click.IntRange(1), default=_DEFAULT.steps, show_default=True, help="Of each round.")
@click.option(
    "--sure",
    type=click.FloatRange(0, 1),
    default=_DEFAULT.sure,
    show_default=True,
    help="Objects with at least this score are learned from.",
)
@click.option(
    "--unsure",
    type=click.FloatRange(0, 1),
    default=_DEFAULT.unsure,
    show_default=True,
    help="Those with at least this one are left open; others are background.",
)
@seed_option
@click.option("--resume", is_flag=True, help="Go on with the rounds in --out.")
@device_options
def adapt_command(
    checkpoint: Path,
    data: Path,
    split: str,
    source: Path,
    source_split: str,
    out: Path,
    rounds: int,
    steps: int,
    sure: float,
    unsure: float,
    seed: int,
    resume: bool,
    device: str,
    precision: str,
    workers: int | None,
) -> int:
    """Adapt a detector to frames without labels: it learns from what it is sure of in them, and from labeled frames.

    \b
    avod adapt --data my_street --source set --out adapted
    avod predict --checkpoint adapted/round_2 --data my_street --out results
    """  # noqa: D301 - click reads the backspace
    adaptation = Adaptation(rounds=rounds, steps=steps, sure=sure, unsure=unsure)
    target, ids = frames_of(data, split, None)
    if not isinstance(target, kitti.Dataset | RawDrive):
        raise CadetError(f"{data}: adapt takes a KITTI folder or one of KITTI's raw drives")
    run = run_of(
        source, out, split=source_split, seed=seed, resume=resume, device=device, precision=precision, workers=workers
    )
    stopping = Stopping(None)
    total = rounds * (len(ids) + steps)
    with stopping, progress(total, "adapting", "frames and steps") as advance:
        last = adapt(
            checkpoint,
            target,
            run,
            adaptation,
            on_frame=lambda number, done: advance((number - 1) * (len(ids) + steps) + done, ""),
            on_step=lambda number, done, losses: advance(
                (number - 1) * (len(ids) + steps) + len(ids) + done, loss_text(losses)
            ),
            should_stop=stopping,
        )
    if last is None:
        return how_to_continue(stopping)
    click.echo(f"last checkpoint: {last}", err=True)
    return 0
