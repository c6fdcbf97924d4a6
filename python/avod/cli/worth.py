"""`avod worth`: what frames are worth to a detector."""

from __future__ import annotations

from pathlib import Path

import click

from avod.cli.options import (
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
from avod.worth import REMEDIES, STEPS, fixed_recipe, worth
from cadet.cli.eval import print_analysis


@click.command(name="worth")
@click.argument("data", metavar="DATA", type=click.Path(path_type=Path))
@click.option("--test", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Frames to judge it on.")
@split_option("train")
@click.option("--test-split", metavar="NAME", default="all", show_default=True, help="A list of theirs, or 'all'.")
@click.option("--out", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Where the training goes.")
@click.option(
    "--minutes",
    type=click.Choice([str(minutes) for minutes in STEPS]),
    default="30",
    show_default=True,
    help="The budget: about so much processor time, by a fixed number of steps.",
)
@seed_option
@click.option("--resume", is_flag=True, help="Go on with the training in --out.")
@device_options
def worth_command(
    data: Path,
    test: Path,
    split: str,
    test_split: str,
    out: Path,
    minutes: str,
    seed: int,
    resume: bool,
    device: str,
    precision: str,
    workers: int | None,
) -> int:
    """Train a small detector of cars on DATA alone, test it on other frames, and tell what to mend first.

    \b
    avod worth set --test kitti --out worth_of_set
    """  # noqa: D301 - click reads the backspace
    config = fixed_recipe(int(minutes))
    frames, ids = frames_of(test, test_split, None)
    seed_of_run = None if resume else seed
    run = run_of(
        data, out, split=split, seed=seed_of_run, resume=resume, device=device, precision=precision, workers=workers
    )
    stopping = Stopping(None)
    with stopping, progress(config.training.steps, "training", "steps") as advance:
        found = worth(
            config,
            run,
            frames,
            ids,
            on_step=lambda step, losses: advance(step, loss_text(losses)),
            should_stop=stopping,
        )
    if found is None:
        return how_to_continue(stopping)
    click.echo(f"{len(ids)} frames of {test}, {config.training.steps} steps on {data}")
    print_analysis(found.analysis)
    if found.gains and found.gains[0][1] > 0.0:
        name, gain = found.gains[0]
        click.echo(f"\nMend first: {name}, worth {gain:.1f} points of AP 3D; {REMEDIES[name]}.")
    return 0
