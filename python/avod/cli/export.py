"""`avod export`: a detector's network as ONNX files."""

from __future__ import annotations

from pathlib import Path

import click

from avod.cli.options import checkpoint_option
from avod.detector import Detector
from avod.export import export_onnx


@click.command(name="export")
@checkpoint_option
@click.option("--out", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Where the files go.")
def export_command(checkpoint: Path, out: Path) -> None:
    """Write a detector's network as ONNX files, one for each part; maps, crops, and boxes stay with the caller."""
    for file in export_onnx(Detector(checkpoint, device="cpu"), out):
        click.echo(f"wrote {file}")
