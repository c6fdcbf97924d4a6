"""The command: `python -m tools.experiments`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from avod.cli.options import (
    check_split,
    device_options,
    progress,
    resolve_device,
    resolve_precision,
    resolve_workers,
)
from avod.cli.stopping import Stopping
from avod.device import Processes
from cadet.cli.signals import exit_code, how_ended
from cadet.errors import CadetError
from tools.experiments.cells import REAL, SIM, Cell
from tools.experiments.estimate import Speed, cell_seconds, hours, measure_speed, shared_seconds
from tools.experiments.experiment import run_cells, selected, write_results
from tools.experiments.machine import Machine
from tools.experiments.outcome import is_finished
from tools.experiments.plans import few_frame_cells, matrix_cells
from tools.experiments.record import begin_cell, begin_experiment
from tools.experiments.scales import CLASSES, MAPS, SCALES, Scale
from tools.experiments.sets import TRAIN, VAL, FrameSet, Sets, check_sets

_DEVICES = (1, 2, 4, 8)


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--scale", type=click.Choice(list(SCALES)), default="tiny", show_default=True, help="Size of the experiments."
)
@click.option(
    "--data-real", metavar="DIR", required=True, type=click.Path(path_type=Path), help="KITTI, or a set in its place."
)
@click.option("--data-sim", metavar="DIR", type=click.Path(path_type=Path), help="A generated KITTI folder.")
@click.option("-o", "--out", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Output directory.")
@click.option("--seeds", type=click.IntRange(1), default=1, show_default=True, help="Trainings of each cell.")
@click.option("--classes", metavar="NAMES", default=",".join(CLASSES), show_default=True)
@click.option("--maps", metavar="NAMES", help=f"Some of {','.join(MAPS)}.  [default: all; with --frames, default]")
@click.option(
    "--frames",
    metavar="COUNTS",
    help="Instead of the matrix: train from scratch, pre-trained, and mixed with simulated frames on these numbers of "
    "real frames, as 10,40,160.",
)
@click.option(
    "--init",
    "inits",
    metavar="DIR|NAME",
    multiple=True,
    type=click.Path(path_type=Path),
    help="With --frames: the pre-trained checkpoint; repeat it for one per seed.",
)
@click.option("--cells", metavar="PATTERN", multiple=True, help="Run only these cells, as in 'car-*'; may be repeated.")
@click.option(
    "--steps", type=click.IntRange(1), help="Steps of a training from scratch; the others are shortened in proportion."
)
@click.option("--dry-run", is_flag=True, help="List the cells, time a few steps, and estimate the hours.")
@click.option("--max-minutes", type=click.FloatRange(0, min_open=True), help="Stop after so long.")
@click.option("--compile", is_flag=True, help="Compile the feature pyramids in training.")
@device_options
def experiments(**options: Any) -> int:
    """Run the paper's experiments: trained on simulated frames, on real ones, and on both.

    Cells run one after another. After Ctrl-C, SIGTERM, or a crash, the same command continues with the unfinished
    cells. Exit codes are those of avod train.

    \b
    python -m tools.experiments --scale tiny --data-real kitti --data-sim set -o paper --dry-run
    python -m tools.experiments --scale full --data-real kitti --data-sim set -o paper --device cuda
    python -m tools.experiments --data-real kitti --frames 10,40,160,640 --init tiny_car --classes Car --seeds 5 -o few
    """  # noqa: D301 - click reads the backspace
    plan = _plan(options)
    cells = selected(plan.cells, options["cells"], plan.out)
    check_sets(cells, plan.sets)
    stopping = Stopping(options["max_minutes"])
    device = resolve_device(options["device"])
    try:
        with stopping, Processes.joined(device) as processes:
            machine = Machine(
                processes=processes,
                precision=resolve_precision(options["precision"]),
                workers=resolve_workers(options["workers"]),
                compile=options["compile"],
                should_stop=stopping,
                progress=_shown if processes.is_first else _hidden,
            )
            if processes.is_first:
                begin_experiment(plan.out, plan.scale, options["steps"], plan.sets, is_written=not options["dry_run"])
                for cell in plan.cells:
                    begin_cell(plan.out, cell, is_written=False)
            if options["dry_run"]:
                _estimate(cells, plan, machine)
                return 0
            if not run_cells(cells, plan.out, plan.sets, machine, lambda name: click.echo(f"{name}: done", err=True)):
                if processes.is_first:
                    click.echo(f"{stopping.reason}; the same command continues", err=True)
                return stopping.exit_code
            if processes.is_first:
                click.echo(write_results(plan.out), nl=False)
    except KeyboardInterrupt as error:
        click.echo(f"{how_ended(error)}; the same command continues", err=True)
        return exit_code(error)
    return 0


@dataclass(frozen=True)
class _Plan:
    """The cells to run, on which data, and where."""

    out: Path
    scale: Scale
    sets: Sets
    cells: tuple[Cell, ...]


def _plan(options: dict[str, Any]) -> _Plan:
    scale = SCALES[options["scale"]]
    classes = _names_of("--classes", options["classes"], tuple(CLASSES))
    steps, num_seeds, inits = options["steps"], options["seeds"], options["inits"]
    if inits and options["frames"] is None:
        raise CadetError("--init: pre-trained weights are for --frames; the matrix trains its own")
    if options["data_sim"] is None and not inits:
        raise CadetError("--data-sim: needed to train on, unless --frames and --init give pre-trained weights")
    if scale.has_one_map and options["frames"] is None:
        raise CadetError(f"--scale {scale.name}: its detector is none of the paper's: it has --frames alone")
    if options["frames"] is None:
        maps = _names_of("--maps", options["maps"] or ",".join(MAPS), MAPS)
        cells = matrix_cells(scale, classes, maps, num_seeds, steps)
    else:
        maps = _names_of("--maps", options["maps"] or MAPS[0], MAPS[:1] if scale.has_one_map else MAPS)
        counts = _counts(options["frames"])
        cells = few_frame_cells(
            scale, classes, maps, num_seeds, counts, steps, inits, mixes=options["data_sim"] is not None
        )
    folders = {REAL: options["data_real"], SIM: options["data_sim"]}
    for folder in filter(None, folders.values()):
        for split in (TRAIN, VAL):
            check_split(folder, split)
    sets = {name: FrameSet.read(folder) for name, folder in folders.items() if folder is not None}
    return _Plan(options["out"], scale, sets, cells)


def _names_of(option: str, text: str, known: Sequence[str]) -> tuple[str, ...]:
    """Read names that commas separate.

    Args:
        option: for messages.
        text: what the user gave.
        known: the names that may stand there.

    Returns:
        The names, in the order of `known`.

    Raises:
        CadetError: an unknown name, or none.
    """
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in known:
            raise CadetError(f"{option}: expected some of {','.join(known)}, got {name!r}")
    return tuple(name for name in known if name in names)


def _counts(text: str) -> tuple[int, ...]:
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdecimal() and 0 < len(part) < 9 and int(part) > 0 for part in parts):
        raise CadetError(f"--frames: expected numbers of frames such as 10,40,160,640, got {text!r}")
    return tuple(sorted({int(part) for part in parts}))


def _estimate(cells: Sequence[Cell], plan: _Plan, machine: Machine) -> None:
    """Print the cells, what they take, and how long all would take."""
    left = [cell for cell in cells if not is_finished(plan.out, cell)]
    speeds: dict[str, Speed] = {}
    for cell in left:
        if cell.class_name not in speeds:
            speeds[cell.class_name] = measure_speed(cell.config, plan.sets[cell.data[-1]], machine)
    num_val = {name: frames.num_val for name, frames in plan.sets.items()}
    seconds = {cell.name: cell_seconds(cell, speeds[cell.class_name], num_val) for cell in left}
    if not machine.processes.is_first:
        return
    rows = [["cell", "steps", "tested on", "time"]]
    for cell in cells:
        time = hours(seconds[cell.name]) if cell.name in seconds else "finished"
        rows.append([cell.name, f"{cell.num_steps:,}", ", ".join(cell.tests), time])
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        click.echo("  ".join(map(str.ljust, row, widths)).rstrip())
    for name, speed in speeds.items():
        where = machine.processes.device
        click.echo(f"{name}: {speed.step_s:.3f} s a step, {speed.frame_s:.3f} s a frame in detection, timed on {where}")
    shared = ", ".join(f"{hours(shared_seconds(left, seconds, count))} on {count}" for count in _DEVICES)
    click.echo(f"{len(left)} of {len(cells)} cells to run; devices that share them by --cells: {shared}")


@contextmanager
def _shown(total: int, name: str, unit: str) -> Iterator[Callable[[int, str], None]]:
    click.echo(f"{name}: {total} {unit}", err=True)
    with progress(total, name, unit) as advance:
        yield advance


@contextmanager
def _hidden(total: int, name: str, unit: str) -> Iterator[Callable[[int, str], None]]:
    yield lambda done, note: None
