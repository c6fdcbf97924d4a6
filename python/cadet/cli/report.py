"""`cadet report`: a page of figures about a dataset."""

from __future__ import annotations

from pathlib import Path

import click

from cadet._util.operating_system import num_processors
from cadet.datasets.report import write_report


@click.command(name="report")
@click.argument("root", type=click.Path(path_type=Path))
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), default=Path("report.html"), show_default=True, help="The page."
)
@click.option("--frames", type=click.IntRange(0, 100), default=10, show_default=True, help="Frames in the gallery.")
@click.option("--workers", type=click.IntRange(1, 1024), help="Worker processes.  [default: one per processor]")
def report_command(root: Path, out: Path, frames: int, workers: int | None) -> None:
    """Write one HTML page: counts, mix, distributions beside KITTI's, frames with boxes, scans to turn.

    \b
    cadet report out
    cadet report out -o out.html --frames 20
    """  # noqa: D301 - click reads the backspace
    path = write_report(root, out, num_frames=frames, workers=workers or num_processors())
    click.echo(f"wrote {path}")
