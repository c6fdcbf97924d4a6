"""`avod train`."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import click
from click.core import ParameterSource

from avod.cli.options import (
    check_no_split,
    check_split,
    device_options,
    loss_text,
    parse_data,
    progress,
    resolve_device,
    resolve_precision,
    resolve_split,
    resolve_workers,
    set_option,
    split_option,
)
from avod.cli.stopping import Stopping
from avod.clusters import mean_sizes_of
from avod.config import Config
from avod.config.base import config_names, table_of_settings
from avod.config.tables import changed_config
from avod.data.frames import is_simulation
from avod.data.mixture import shares_of
from avod.device import Processes, is_first_process
from avod.model.network import AnyNetwork
from avod.train.checkpoint import checkpoints, read_checkpoint
from avod.train.log import Validated
from avod.train.run import train, with_steps
from avod.train.settings import Record, Run, read_record
from avod.validate import Validator
from cadet.cli.signals import exit_code, how_ended
from cadet.errors import CadetError, MissingFileError
from cadet.formats.webdataset.dataset import is_pattern

_SECONDS_BETWEEN_LINES: Final = 10.0


@click.command(name="train")
@click.option("--config", metavar="NAME|FILE", help=f"One of {', '.join(config_names())}, or a .toml.")
@click.option(
    "--data",
    metavar="DIR|SHARDS|sim:FILE[:SHARE]",
    multiple=True,
    help="A KITTI folder, shards ('set/train/{000000..000099}.tar'), or a simulation's TOML file; several folders "
    "with their shares of the frames.",
)
@split_option("train")
@click.option("--num-frames", type=click.IntRange(1), help="Learn from only so many frames of the last folder.")
@click.option("--out", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Output, one per run.")
@click.option("--steps", type=click.IntRange(1), help="Step at which training ends: short for --set training.steps=N.")
@set_option
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), help="Random seed.  [default: 0]")
@click.option(
    "--sizes-from",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Shift objects' sizes to the mean sizes of this folder's labels.",
)
@click.option(
    "--bank",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Paste objects of this bank (cadet bank), as many as the configuration says.",
)
@click.option("--init", metavar="DIR", type=click.Path(path_type=Path), help="Start at step 0 from these weights.")
@click.option(
    "--init-refinement",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Start the last stage from these weights, of any network.",
)
@click.option("--resume", is_flag=True, help="Resume the run in --out with the settings it was started with.")
@click.option(
    "--resume-from",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Continue another run's optimizer, step, and schedule.",
)
@click.option(
    "--skip-steps",
    metavar="STEP",
    type=click.IntRange(0),
    multiple=True,
    help="Leave out a step whose loss is not finite; may be repeated.",
)
@click.option(
    "--max-minutes", type=click.FloatRange(0, min_open=True), help="Stop after this many minutes; --resume continues."
)
@click.option("--keep", type=click.IntRange(1), help="Newest checkpoints to keep.  [default: all]")
@click.option("--val-every", metavar="STEPS", type=click.IntRange(1), help="Steps between validations on --val-split.")
@click.option("--val-split", metavar="NAME", default="val", show_default=True, help="A list of ImageSets, or 'all'.")
@click.option("--compile", is_flag=True, help="Compile the feature pyramids.")
@click.option("--tensorboard", is_flag=True, help="Write TensorBoard's files too.")
@device_options
@click.pass_context
def train_command(context: click.Context, /, **options: Any) -> int:
    """Train a detector.

    Ctrl-C, SIGTERM and --max-minutes end the step and write a checkpoint; exit codes 130, 143 and 75.

    \b
    avod train --config tiny_car --data set --out run
    avod train --out run --resume
    avod train --config tiny_car --data set:0.8 --data kitti:0.2 --out mixed
    avod train --config car_default --data kitti --out tuned --resume-from run --set training.learning_rate=1e-5
    avod train --config car_default --data kitti --out gpu --device cuda --precision bfloat16
    torchrun --nproc-per-node 4 -m avod train ...
    """  # noqa: D301 - click reads the backspace
    config, run = _settings(_Options(context, options))
    stopping = Stopping(options["max_minutes"])
    note = ""

    def validated(text: str) -> None:
        nonlocal note
        note = text

    def on_step(step: int, losses: dict[str, Any]) -> None:
        advance(step, f"{loss_text(losses)}{note}")

    is_first = is_first_process()
    shown = progress(config.training.steps, "training", "steps") if is_first else contextlib.nullcontext(_say_nothing)
    try:
        with stopping, shown as advance:
            validate = None if run.val_every is None else _validation(config, run, stopping, validated)
            last = train(config, run, on_step=on_step, validate=validate, should_stop=stopping)
    except KeyboardInterrupt as error:
        click.echo(f"{how_ended(error)}; {_how_to_go_on(run.out)}", err=True)
        return exit_code(error)
    is_done = last.name == f"{config.training.steps:09d}"
    if is_first:
        text = f"last checkpoint: {last}" if is_done else f"{stopping.reason}; {_how_to_go_on(run.out)}"
        click.echo(text, err=True)
    return 0 if is_done else stopping.exit_code


@dataclass(frozen=True)
class _Options:
    """The options of the command, and which of them were given."""

    context: click.Context
    values: dict[str, Any]

    def is_given(self, name: str) -> bool:
        """Tell whether an option stands in the command."""
        return self.context.get_parameter_source(name) != ParameterSource.DEFAULT

    def get(self, name: str, recorded: Any) -> Any:
        """Return an option, or what was recorded where it is not given and a training goes on."""
        return self.values[name] if self.is_given(name) or not self.values["resume"] else recorded


def _settings(options: _Options) -> tuple[Config, Run]:
    values = options.values
    out = values["out"]
    record, config = _recorded(out) if values["resume"] else (None, None)
    if values["config"] is not None:
        config = Config.named(values["config"])
        # Where training ends was settled when it was begun, perhaps by --steps.
        config = config if record is None else with_steps(config, record.config.training.steps)
    data = parse_data(values["data"]) if values["data"] or record is None else record.folders
    if config is not None:
        config = changed_config(config, table_of_settings(values["settings"]))
    if config is None or not data:
        missing = "--config" if config is None else "--data"
        raise CadetError(f"train needs {missing}: only a training that goes on by --resume knows its own")

    if values["sizes_from"] is not None:
        config = _with_sizes(config, values["sizes_from"])

    def recorded(name: str, default: Any) -> Any:
        return options.get(name, default if record is None else getattr(record, name))

    split = resolve_split(recorded("split", "train"))
    for folder, _ in data:
        check_no_split(folder)
        check_split(folder, split)
    val_every = recorded("val_every", None)
    if val_every is not None and any(is_pattern(folder) or is_simulation(folder) for folder, _ in data):
        raise CadetError("--val-every: shards that --data names, and simulations, have no --val-split to validate on")
    run = Run(
        data=data,
        out=out,
        split=split,
        seed=values["seed"],
        init=values["init"],
        init_refinement=values["init_refinement"],
        resume=values["resume"],
        resume_from=values["resume_from"],
        skip_steps=values["skip_steps"],
        keep=recorded("keep", None),
        val_every=val_every,
        val_split=resolve_split(recorded("val_split", "val")),
        device=resolve_device(recorded("device", "cpu")),
        precision=resolve_precision(recorded("precision", "float32") or "float32"),
        workers=resolve_workers(values["workers"]),
        compile=recorded("compile", False),
        tensorboard=values["tensorboard"],
        bank=recorded("bank", None),
        num_frames=recorded("num_frames", None),
    )
    if val_every is not None:
        check_split(data[0][0], run.val_split)
    return with_steps(config, values["steps"]), run


def _with_sizes(config: Config, folder: Path) -> Config:
    """Return the configuration with the mean sizes of a folder's labels."""
    sizes = mean_sizes_of(folder, config.class_names)
    return replace(config, augmentation=replace(config.augmentation, object_sizes_lwh_m=sizes))


def _recorded(out: Path) -> tuple[Record | None, Config]:
    """Return what a folder's training was begun with; without a record its checkpoint's configuration alone."""
    try:
        record = read_record(out)
    except MissingFileError:
        if not checkpoints(out / "checkpoints"):
            raise
        return None, read_checkpoint(out).config
    return record, record.config


def _validation(
    config: Config, run: Run, stopping: Stopping, on_validated: Callable[[str], None]
) -> Callable[[AnyNetwork, int, Processes], Validated | None]:
    last_s = time.monotonic()

    def on_frame(done: int, total: int) -> None:
        nonlocal last_s
        if is_first_process() and not sys.stderr.isatty() and time.monotonic() - last_s >= _SECONDS_BETWEEN_LINES:
            last_s = time.monotonic()
            click.echo(f"validating {done}/{total} frames", err=True)

    folder = next(name for name, _ in shares_of(run.data) if not is_simulation(name))
    validator = Validator(folder, run.val_split, config, workers=run.workers, should_stop=stopping, on_frame=on_frame)

    def validate(network: AnyNetwork, step: int, processes: Processes) -> Validated | None:
        found = validator(network, step, processes)
        if found is not None:
            on_validated(
                f", AP {found.ap:.2f} and loss {found.losses['total']:.3f} on {run.val_split or 'all'} at {step}"
            )
        return found

    return validate


def _say_nothing(done: int, note: str) -> None:
    """Report no step: another process does."""


def _how_to_go_on(out: str | Path) -> str:
    written = checkpoints(Path(out) / "checkpoints")
    if not written:
        return f"no checkpoint yet: --out {out} --resume begins again"
    return f"last checkpoint: {written[-1]}; to continue: avod train --out {out} --resume"
