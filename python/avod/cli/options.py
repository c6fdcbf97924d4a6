"""What the commands have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import click
import torch
from click.core import ParameterSource
from rich.console import Console

from avod import device
from avod.cli.stopping import Stopping
from avod.config.base import table_of_settings
from avod.data.frames import Frames, SimulatedFrames, is_simulation, open_frames
from avod.train import Run
from cadet._util.operating_system import num_processors
from cadet.cli.progress import reporter
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.folder import sample_folder, set_root
from cadet.formats.kitti.files.unreadable import Unreadable, frames_with_files
from cadet.formats.kitti.image_sets import LISTS, check_not_empty, list_paths
from cadet.formats.kitti_sequences.raw_drive import is_raw_drive
from cadet.formats.webdataset.dataset import is_pattern, is_shard_folder

F = TypeVar("F", bound=Callable[..., Any])

DEFAULT_THREADS = 4
"""The most threads of the CPU that commands take unasked."""

DEFAULT_WORKERS = 16
"""The most processes that read frames unasked."""

_USUAL = ("train", "val", "trainval")
_PRECISIONS = {"float32": None, "bfloat16": torch.bfloat16}

data_option = click.option(
    "--data",
    metavar="DIR|SHARDS|sim:FILE",
    required=True,
    type=click.Path(path_type=Path),
    help="A KITTI folder, one of KITTI's raw drives, shards ('set/val/{000000..000009}.tar'), or a simulation's TOML "
    "file, with --num-frames.",
)
checkpoint_option = click.option(
    "--checkpoint",
    metavar="DIR|NAME",
    default="center_all",
    show_default=True,
    type=click.Path(path_type=Path),
    help="A checkpoint, a run's directory (its last checkpoint), or a packaged one such as tiny_car.",
)
num_frames_option = click.option("--num-frames", type=click.IntRange(1), help="At most this many, from the first.")


def split_option(default: str | None) -> Callable[[F], F]:
    """Make the option that chooses a split."""
    return click.option(
        "--split", metavar="NAME", default=default, show_default=True, help="A list of ImageSets, or 'all'."
    )


def device_options(command: F) -> F:
    """Add the options that say where and how the network runs."""
    options = (
        click.option("--device", metavar="NAME", default="cpu", show_default=True, help="cpu, cuda, cuda:1, ..."),
        click.option(
            "--precision",
            type=click.Choice(list(_PRECISIONS)),
            default="float32",
            show_default=True,
            help="Precision of the layers.",
        ),
        click.option(
            "--workers",
            type=click.IntRange(0, 256),
            help=f"Processes that read frames.  [default: this machine's processors, at most {DEFAULT_WORKERS}]",
        ),
        click.option(
            "--threads",
            type=click.IntRange(1, 1024),
            expose_value=False,
            callback=_set_threads,
            help=f"Threads on the CPU.  [default: all, at most {DEFAULT_THREADS}]",
        ),
    )
    for option in options:
        command = option(command)
    return command


set_option = click.option(
    "--set",
    "settings",
    metavar="KEY=VALUE",
    multiple=True,
    help="Change the configuration, as in detection.min_score=0.5; may be repeated.",
)


def detection_options(command: F) -> F:
    """Add the options that change settings of detection for one run."""
    options = (
        click.option("--proposals", type=click.IntRange(1, 65536), help="Short for --set rpn.proposals=N."),
        click.option("--min-score", type=click.FloatRange(0, 1), help="Short for --set detection.min_score=S."),
        click.option("--nms-iou", type=click.FloatRange(0, 1), help="Short for --set detection.nms_iou=IOU."),
        set_option,
    )
    for option in options:
        command = option(command)
    return command


def detection_settings(
    settings: tuple[str, ...],
    proposals: int | None = None,
    min_score: float | None = None,
    nms_iou: float | None = None,
) -> dict[str, Any]:
    """Return what the options of `detection_options` change, as tables of a configuration.

    Raises:
        CadetError: a setting that is none.
    """
    short = {"rpn.proposals": proposals, "detection.min_score": min_score, "detection.nms_iou": nms_iou}
    return table_of_settings([*settings, *(f"{key}={value}" for key, value in short.items() if value is not None)])


def loss_text(losses: Mapping[str, Any]) -> str:
    """Say what the total loss of a step is; a step without losses was left out."""
    return f"loss {float(losses['total']):.3f}" if losses else "left out"


def resolve_workers(count: int | None) -> int:
    """Return how many processes read frames; None for as many as processors that this process may use."""
    return min(num_processors(), DEFAULT_WORKERS) if count is None else count


def resolve_device(name: str) -> torch.device:
    """Find a device.

    Raises:
        CadetError: an unknown one, or one that this machine lacks.
    """
    try:
        return device.resolve_device(device.name_of_process(name))
    except CadetError as error:
        raise CadetError(f"--{error}") from None


def _set_threads(context: click.Context, parameter: click.Parameter, value: int | None) -> None:
    """Set PyTorch's threads; None for as many as PyTorch would take, but no more than help a small network."""
    torch.set_num_threads(min(torch.get_num_threads(), DEFAULT_THREADS) if value is None else value)


def resolve_precision(name: str) -> torch.dtype | None:
    """Find a type of arithmetic; None is float32."""
    return _PRECISIONS[name]


def frames_of(root: Path, split: str | None, limit: int | None) -> tuple[Frames, tuple[str, ...]]:
    """Open the frames of a split, those of `root/testing` for "test", and return their ids, the first `limit` of them.

    Raises:
        MissingFileError: no folder or split, no frame in it, or none with image, scan, or calibration.
        CadetError: a split of shards that are named, or of a simulation, or a simulation without a limit.
    """
    name = resolve_split(split)
    check_no_split(root)
    check_split(root, name)
    frames = open_frames(root, name)
    if isinstance(frames, SimulatedFrames):
        if limit is None:
            raise CadetError(f"{root}: a simulation has no end: say by --num-frames how many frames to take")
        return frames, frames.first(limit)
    check_not_empty(frames.ids, root, name)
    frames_with_files(frames, Unreadable(root), root)
    return frames, frames.ids[:limit]


def check_no_split(root: str | Path) -> None:
    """Refuse a --split in the command of shards that were named one by one, or of a simulation.

    Raises:
        CadetError: it is there.
    """
    is_given = click.get_current_context().get_parameter_source("split") != ParameterSource.DEFAULT
    if is_given and (is_pattern(root) or is_simulation(root)):
        raise CadetError("--split: shards that --data names are all read, and a simulation has no splits")


def check_split(root: Path, name: str | None) -> None:
    """Say what to do where a folder lacks a list that is asked for, as KITTI's own archives do.

    Raises:
        MissingFileError: there is no such list, or no KITTI folder.
    """
    if is_pattern(root) or is_simulation(root) or is_shard_folder(root) or is_raw_drive(root):
        return
    sample_folder(root)
    folder, lists = set_root(root) / LISTS, list_paths(root)
    if name in (None, "test") or name in lists:
        return
    present = ", ".join(sorted(lists))
    hint = f"choose another list ({present}) or --split all" if present else "--split all takes every frame"
    if name in _USUAL:
        hint += (
            "; KITTI's archives hold no lists: its usual split, 3,712 frames to train and 3,769 to validate, is the "
            f"train.txt and val.txt that most detectors' repositories carry; put them into {folder}"
        )
    raise MissingFileError(f"{folder / f'{name}.txt'}: no such split: {hint}")


def parse_data(texts: Sequence[str]) -> tuple[tuple[Path, float], ...]:
    """Read folders with their shares, as in "set:0.8"; one alone needs none.

    Raises:
        CadetError: several folders, and one without a share.
    """
    parsed = [_folder_and_share(text) for text in texts]
    for folder, share in parsed:
        if share is None and len(parsed) > 1:
            raise CadetError(f"--data {folder}: several folders need a share each, as in --data {folder}:0.5")
    return tuple((folder, 1.0 if share is None else share) for folder, share in parsed)


def _folder_and_share(text: str) -> tuple[Path, float | None]:
    name, colon, share = text.rpartition(":")
    if colon and not Path(text).exists():
        try:
            return Path(name), float(share)
        except ValueError:
            pass
    return Path(text), None


def resolve_split(name: str | None) -> str | None:
    """Return the split's name; None, which "all" becomes, for every frame."""
    return None if name == "all" else name


def run_of(
    data: Path,
    out: Path,
    *,
    split: str,
    seed: int | None,
    resume: bool,
    device: str,
    precision: str,
    workers: int | None,
) -> Run:
    """Make the settings of a training that keeps its last checkpoint alone."""
    return Run(
        data=data,
        out=out,
        split=resolve_split(split),
        seed=seed,
        resume=resume,
        keep=1,
        device=resolve_device(device),
        precision=resolve_precision(precision),
        workers=resolve_workers(workers),
    )


def how_to_continue(stopping: Stopping) -> int:
    """Say how to go on with what was stopped; return the exit code."""
    click.echo(f"{stopping.reason}; to continue: the same command with --resume", err=True)
    return stopping.exit_code


seed_option = click.option(
    "--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True, help="Random seed."
)


@contextmanager
def progress(total: int, text: str, unit: str = "frames") -> Iterator[Callable[[int, str], None]]:
    """Show a bar on a terminal and print lines elsewhere; yields a callback that takes the count done and a note.

    What the first call counts beyond 1 was done before, by the training that is resumed.
    """
    num_done = 0
    with reporter(Console(stderr=True, highlight=False), total, text=text, unit=unit) as report:

        def advance(done: int, note: str) -> None:
            nonlocal num_done
            if num_done == 0 and done > 1:
                report.advance(done - 1, is_new=False)
            report.advance(note=note)
            num_done = done

        yield advance
