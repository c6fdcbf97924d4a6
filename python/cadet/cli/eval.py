"""`cadet eval`: KITTI's average precision."""

from __future__ import annotations

from pathlib import Path

import click
from rich import box
from rich.console import Console
from rich.table import Table

from cadet.errors import CadetError
from cadet.evaluation import LEVELS, Report, evaluate
from cadet.evaluation.limits import CLASSES, KNOWN_CLASSES, METRICS, MIN_OVERLAP
from cadet.evaluation.report import RECALLS
from cadet.view.picture import check_picture_path


@click.command(name="eval")
@click.argument("gt", type=click.Path(path_type=Path))
@click.argument("det", type=click.Path(path_type=Path))
@click.option("--classes", metavar="LIST", default=",".join(CLASSES), show_default=True, help="Classes to evaluate.")
@click.option("--recall", type=click.Choice(list(RECALLS)), default="r40", show_default=True, help="Recall positions.")
@click.option(
    "--min-overlap",
    metavar="SET",
    default="strict",
    show_default=True,
    help=f"{' or '.join(MIN_OVERLAP)}, or limits such as Car=0.5,Van=0.7/0.5/0.5 ({', '.join(METRICS)}).",
)
@click.option("--levels", type=click.Choice(list(LEVELS)), default="kitti", show_default=True, help="Difficulties.")
@click.option("--split", metavar="NAME|FILE", help="Evaluate the frames of a list of ImageSets, or of a file alone.")
@click.option("--all-frames", is_flag=True, help="Count a missing result file as no detections.")
@click.option("--json", "as_json", is_flag=True, help="Print everything, whole curves too, as JSON.")
@click.option("--markdown", "as_markdown", is_flag=True, help="Print Markdown.")
@click.option("--plot", type=click.Path(path_type=Path, dir_okay=False), help="Draw the curves: a .png or .jpg.")
def evaluate_command(
    gt: Path,
    det: Path,
    classes: str,
    recall: str,
    min_overlap: str,
    levels: str,
    split: str | None,
    all_frames: bool,
    as_json: bool,
    as_markdown: bool,
    plot: Path | None,
) -> None:
    """Compute KITTI's AP of the result files in DET against the labels in GT, as the official program does.

    \b
    cadet eval out results
    cadet eval out/training/label_2 results --split val --levels large_small
    cadet eval out results --json > report.json
    """  # noqa: D301 - click reads the backspace
    if as_json and as_markdown:
        raise CadetError("--json and --markdown exclude each other")
    if plot is not None:
        check_picture_path(plot)
    report = evaluate(
        gt,
        det,
        classes=tuple(name.strip() for name in classes.split(",")),
        recall=recall,
        min_overlap=min_overlap if min_overlap in MIN_OVERLAP else _limits(min_overlap),
        levels=levels,
        split=split,
        frames="all" if all_frames else "results",
    )
    if plot is not None:
        report.plot(plot)
    if as_json:
        click.echo(report.to_json(), nl=False)
    elif as_markdown:
        click.echo(report.to_markdown(), nl=False)
    else:
        _print(report, Console(highlight=False))


def _limits(text: str) -> dict[str, float | list[float]]:
    limits: dict[str, float | list[float]] = {}
    for part in text.split(","):
        name, _, numbers = part.strip().partition("=")
        try:
            values = [float(number) for number in numbers.split("/")]
        except ValueError:
            values = []
        if name not in KNOWN_CLASSES or not values:
            known = " or ".join(MIN_OVERLAP)
            raise CadetError(
                f"--min-overlap: expected {known}, or limits such as Car=0.5 or Car=0.7/0.5/0.5, got {part!r}"
            )
        limits[name] = values[0] if len(values) == 1 else values
    return limits


def _print(report: Report, console: Console) -> None:
    header, *rows = report.table()
    console.print(report.title(), markup=False, soft_wrap=True, style="bold")
    table = Table(box=box.SIMPLE_HEAD)
    for index, name in enumerate(header):
        table.add_column(name, justify="left" if index < len(header) - len(report.levels) else "right", no_wrap=True)
    shown = ""
    for row in rows:
        is_last_of_class = row[1] == "objects"
        style = "dim" if is_last_of_class else None
        table.add_row(*(["", *row[1:]] if row[0] == shown else row), style=style, end_section=is_last_of_class)
        shown = row[0]
    console.print(table)
    console.print(report.subtitle(), markup=False, soft_wrap=True)
    for warning in report.warnings:
        console.print(f"Note: {warning}", markup=False, soft_wrap=True, style="yellow")
