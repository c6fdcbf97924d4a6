"""What the commands have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import click
import torch
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from cadet import kitti
from cadet.errors import CadetError

F = TypeVar("F", bound=Callable[..., Any])

_PRECISIONS = {"bf16": torch.bfloat16}

data_option = click.option(
    "--data", metavar="DIR", required=True, type=click.Path(path_type=Path), help="A KITTI folder, real or ours."
)
checkpoint_option = click.option(
    "--checkpoint",
    metavar="DIR|NAME",
    required=True,
    type=click.Path(path_type=Path),
    help="A checkpoint, a training's folder, whose last is meant, or the package's own tiny_car.",
)
frames_option = click.option("--frames", type=click.IntRange(1), help="No more than this many, the first.")


def split_option(default: str | None) -> Callable[[F], F]:
    """Make the option that chooses a split."""
    return click.option(
        "--split", metavar="NAME", default=default, show_default=True, help="A list of ImageSets, or 'all'."
    )


def device_options(command: F) -> F:
    """Add the options that say where and how the network runs."""
    options = (
        click.option("--device", metavar="NAME", default="cpu", show_default=True, help="cpu, cuda, cuda:1, ..."),
        click.option("--amp", type=click.Choice(list(_PRECISIONS)), help="Arithmetic of layers.  [default: float32]"),
        click.option(
            "--workers", type=click.IntRange(0, 256), default=0, show_default=True, help="Processes that read frames."
        ),
    )
    for option in options:
        command = option(command)
    return command


def resolve_device(name: str) -> torch.device:
    """Find a device.

    Raises:
        CadetError: an unknown one, or one that this machine lacks.
    """
    try:
        device = torch.device(name)
        torch.empty(1, device=device)
    except (RuntimeError, AssertionError) as error:
        raise CadetError(f"--device: {name!r} cannot be used: {str(error).splitlines()[0]}") from None
    return device


def resolve_precision(name: str | None) -> torch.dtype | None:
    """Find a type of arithmetic; None for float32."""
    return None if name is None else _PRECISIONS[name]


def frame_ids(root: Path, split: str | None, limit: int | None) -> tuple[str, ...]:
    """List the frames of a split.

    Raises:
        MissingFileError: no folder or split.
        CadetError: no frame.
    """
    ids = kitti.Dataset(root, resolve_split(split)).ids[:limit]
    if not ids:
        raise CadetError(f"{root}: no frames")
    return ids


def resolve_split(name: str | None) -> str | None:
    """Return the split's name; None, which "all" becomes, for every frame."""
    return None if name == "all" else name


@contextmanager
def progress(total: int, text: str) -> Iterator[Callable[[int, str], None]]:
    """Show a bar on a terminal; yields what hears how many are done, and says something beside the bar."""
    console = Console(stderr=True, highlight=False)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[note]}"))
    with Progress(*columns, TimeRemainingColumn(), console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(text, total=total, note="")
        yield lambda done, note: bar.update(task, completed=done, note=note)
