"""`cadet eval`: KITTI's average precision, and what stands behind it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from rich import box
from rich.console import Console
from rich.table import Table

from cadet._util.checks import MAX_SEED
from cadet.cli.names import names_option
from cadet.errors import CadetError
from cadet.evaluation import LEVELS, EvalClass, Report, Rules
from cadet.evaluation.analysis import Analysis, analyze
from cadet.evaluation.analysis.bins import EDGES, parse_by
from cadet.evaluation.analysis.result import PARTS
from cadet.evaluation.analysis.run import DRAWS, MAX_DRAWS
from cadet.evaluation.limits import CLASSES, METRICS, MIN_OVERLAP
from cadet.evaluation.report import RECALLS
from cadet.evaluation.sources import BOXES_2D
from cadet.figures.picture import check_picture_path
from cadet.formats.kitti.label import is_object_type

recall_option = click.option(
    "--recall", type=click.Choice(list(RECALLS)), default="r40", show_default=True, help="Recall positions."
)


@click.command(name="eval")
@click.argument("gt", type=click.Path(path_type=Path))
@click.argument("det", type=click.Path(path_type=Path))
@click.argument("det_b", type=click.Path(path_type=Path), required=False)
@names_option("--classes", help=f"Classes to evaluate.  [default: the file's, or {','.join(CLASSES)}]")
@recall_option
@click.option(
    "--min-overlap",
    metavar="SET",
    default="strict",
    show_default=True,
    help=f"{' or '.join(MIN_OVERLAP)}, or limits such as Car=0.5,Van=0.7/0.5/0.5 ({', '.join(METRICS)}).",
)
@click.option(
    "--levels",
    metavar="SET|FILE",
    default="kitti",
    show_default=True,
    help=f"Difficulties: {' or '.join(LEVELS)}, or a .toml with own levels and classes.",
)
@click.option("--split", metavar="NAME|FILE", help="Evaluate only the frames of a list of ImageSets, or of a file.")
@click.option(
    "--frames",
    type=click.Choice(("results", "all")),
    default="results",
    show_default=True,
    help="Evaluate those that have a result file, or all: a missing file is no detections.",
)
@click.option(
    "--boxes-2d",
    type=click.Choice(BOXES_2D),
    default=BOXES_2D[0],
    show_default=True,
    help="Where detections' 2D boxes come from: their files, or 3D boxes and calib.",
)
@names_option(
    "--parts",
    help="Show more: operating, the thresholds of the best F1; errors, AP without one kind of error, and the boxes' "
    "errors; confusion, which class is taken for which; centers, nuScenes' AP by distance of centers, and its errors.",
)
@click.option(
    "--by",
    metavar="WHAT[=EDGES]",
    multiple=True,
    help=f"Show AP by {', '.join(EDGES)}, as in --by distance=0,20,40; may be repeated.",
)
@click.option("--details", is_flag=True, help="Show all parts, by distance and occlusion.")
@click.option(
    "--bootstrap",
    metavar="N",
    type=click.IntRange(0, MAX_DRAWS),
    default=0,
    help=f"Show 95 % intervals of N draws of frames.  [default for DET_B: {DRAWS}]",
)
@click.option("--groups", metavar="frames|episodes|FILE", help="Unit of the draws.  [default: episodes if known]")
@click.option(
    "--seed", type=click.IntRange(0, MAX_SEED), default=0, show_default=True, help="Random seed of the draws."
)
@click.option("--json", "as_json", is_flag=True, help="Print everything, with curves, as JSON.")
@click.option("--markdown", "as_markdown", is_flag=True, help="Print Markdown.")
@click.option("--plot", type=click.Path(path_type=Path, dir_okay=False), help="Draw the curves to a .png or .jpg.")
def evaluate_command(
    gt: Path,
    det: Path,
    det_b: Path | None,
    classes: tuple[str, ...],
    recall: str,
    min_overlap: str,
    levels: str,
    split: str | None,
    frames: str,
    boxes_2d: str,
    parts: tuple[str, ...],
    by: tuple[str, ...],
    details: bool,
    bootstrap: int,
    groups: str | None,
    seed: int,
    as_json: bool,
    as_markdown: bool,
    plot: Path | None,
) -> None:
    """Compute KITTI's AP of the result files in DET against the labels in GT, as the official program does.

    With DET_B, tell whether its detections are better.

    \b
    cadet eval out results
    cadet eval out results --parts errors --by distance   # where AP is lost
    cadet eval out results others --split val       # is B better?
    cadet eval out results --details --json > report.json
    """  # noqa: D301 - click reads the backspace
    if as_json and as_markdown:
        raise CadetError("--json and --markdown exclude each other")
    if plot is not None:
        check_picture_path(plot)
    bins: dict[str, Any] = {"distance": None, "occlusion": None} if details else {}
    analysis = analyze(
        gt,
        det,
        det_b,
        parts=PARTS if details else parts,
        by={**bins, **parse_by(by)},
        bootstrap=bootstrap,
        groups=groups,
        seed=seed,
        recall=recall,
        min_overlap=min_overlap if min_overlap in MIN_OVERLAP else _limits(min_overlap),
        split=split,
        frames=frames,
        boxes_2d=boxes_2d,
        **_rules(levels, classes),
    )
    if plot is not None:
        analysis.report.plot(plot)
    if as_json:
        click.echo(analysis.to_json(), nl=False)
    elif as_markdown:
        click.echo(analysis.to_markdown(), nl=False)
    else:
        print_analysis(analysis)


def _rules(levels: str, classes: tuple[str, ...]) -> dict[str, Any]:
    """Find the levels and classes: sets by name, or those of a file, of which `--classes` chooses."""
    own: dict[str, EvalClass] = {}
    rules: dict[str, Any] = {"levels": levels, "classes": CLASSES}
    if levels not in LEVELS:
        if not levels.endswith(".toml"):
            raise CadetError(f"--levels: expected {' or '.join(LEVELS)}, or a .toml file, got {levels!r}")
        read = Rules.read(levels)
        own = {entry.name: entry for entry in read.classes}
        rules = {"levels": read.levels or "kitti", "classes": read.classes or CLASSES}
    if classes:
        rules["classes"] = [own.get(name, name) for name in classes]
    return rules


def _limits(text: str) -> dict[str, float | list[float]]:
    limits: dict[str, float | list[float]] = {}
    for part in text.split(","):
        name, _, numbers = part.strip().partition("=")
        try:
            values = [float(number) for number in numbers.split("/")]
        except ValueError:
            values = []
        if not is_object_type(name) or not values:
            known = " or ".join(MIN_OVERLAP)
            raise CadetError(
                f"--min-overlap: expected {known}, or limits such as Car=0.5 or Car=0.7/0.5/0.5, got {part!r}"
            )
        limits[name] = values[0] if len(values) == 1 else values
    return limits


def print_analysis(analysis: Analysis) -> None:
    """Print an evaluation and its analysis, as `cadet eval` and `avod eval` do."""
    console = Console(highlight=False)
    _print_report(analysis.report, console)
    for section in analysis.sections():
        click.echo(f"\n{section.to_text()}")
    for note in analysis.notes:
        console.print(f"Note: {note}", markup=False, soft_wrap=True, style="yellow")


def _print_report(report: Report, console: Console) -> None:
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
