"""`avod`: train, adapt, predict, eval, worth, export, clusters, bench, view."""

from __future__ import annotations

import contextlib
import itertools
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from avod.cli.adapt import adapt_command
from avod.cli.clusters import clusters_command
from avod.cli.export import export_command
from avod.cli.options import (
    checkpoint_option,
    data_option,
    detection_options,
    detection_settings,
    device_options,
    frames_of,
    num_frames_option,
    progress,
    resolve_device,
    resolve_precision,
    resolve_workers,
    set_option,
    split_option,
)
from avod.cli.train import train_command
from avod.cli.worth import worth_command
from avod.data.frames import is_simulation, open_frames
from avod.detector import Detector
from avod.evaluate import ABLATIONS, Scored, ablation, ablation_table, analyze_detectors, best, score
from avod.figures import detection_figure, loss_figure
from avod.film import Film
from avod.predict import measure, predict
from avod.train.checkpoint import checkpoints, keep_checkpoint
from avod.train.log import read_log, read_validations
from cadet import __version__
from cadet._util.sink import LocalSink
from cadet.cli.eval import print_analysis, recall_option
from cadet.cli.task_group import TaskGroup
from cadet.errors import CadetError, MissingFileError
from cadet.evaluation.analysis import Analysis
from cadet.evaluation.analysis.result import PARTS
from cadet.evaluation.analysis.tables import Section
from cadet.evaluation.limits import MIN_OVERLAP
from cadet.figures.picture import check_picture_path, write_picture
from cadet.formats.kitti import text_from_labels
from cadet.formats.kitti.files.folder import check_id
from cadet.formats.kitti.files.unreadable import Unreadable


@click.group(
    cls=TaskGroup,
    tasks={
        "Train": ("train", "adapt", "worth", "clusters"),
        "Detect": ("predict", "export", "bench"),
        "Judge": ("eval", "view"),
    },
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="cadet makes, shows, and checks datasets: cadet --help.",
)
@click.version_option(__version__, prog_name="avod")
def avod() -> None:
    """Train detectors of 3D objects on KITTI folders, and detect with them."""


avod.add_command(train_command)
avod.add_command(adapt_command)
avod.add_command(clusters_command)
avod.add_command(worth_command)
avod.add_command(export_command)


@avod.command(name="predict")
@checkpoint_option
@data_option
@split_option("all")
@num_frames_option
@click.option("--out", metavar="DIR", type=click.Path(path_type=Path), help="Where result files go.")
@click.option("--video", metavar="FILE", type=click.Path(path_type=Path), help="Draw a film of them, an .mp4.")
@click.option("--hz", type=click.FloatRange(0.1, 240), default=10.0, show_default=True, help="Its frames a second.")
@detection_options
@device_options
def predict_command(
    checkpoint: Path,
    data: Path,
    split: str | None,
    num_frames: int | None,
    out: Path | None,
    video: Path | None,
    hz: float,
    proposals: int | None,
    min_score: float | None,
    nms_iou: float | None,
    settings: tuple[str, ...],
    device: str,
    precision: str,
    workers: int | None,
) -> None:
    """Write KITTI's result files: an empty one for a frame without detections, none for a frame that cannot be read.

    \b
    avod predict --data kitti --out results
    avod predict --data 2011_09_26/2011_09_26_drive_0013_sync --video drive.mp4 --min-score 0.4
    """  # noqa: D301 - click reads the backspace
    if out is None and video is None:
        raise CadetError("predict needs --out, --video, or both")
    if video is not None and is_simulation(data):
        raise CadetError(f"--video: {data} is a simulation: write its frames with cadet-gen first")
    changes = detection_settings(settings, proposals, min_score, nms_iou)
    detector = _detector(checkpoint, device, precision, changes)
    samples, ids = frames_of(data, split, num_frames)
    unreadable, count = Unreadable(data), 0
    sink = None if out is None else LocalSink(out)
    film = contextlib.nullcontext() if video is None else Film(video, hz)
    results = predict(detector, samples, ids, workers=resolve_workers(workers), unreadable=unreadable)
    with film, progress(len(ids), "detecting") as advance:
        for done, (frame_id, labels) in enumerate(results, start=1):
            if sink is not None:
                sink.put(f"{frame_id}.txt", text_from_labels(labels).encode("ascii"))
            if isinstance(film, Film):
                film.add(samples.read_frame(frame_id, has_extras=False), labels)
            count += len(labels)
            advance(done, "")
    if sink is not None:
        sink.remove_partial()
    written = " and ".join(str(path) for path in (out, video) if path is not None)
    click.echo(f"{count} detections in {len(ids) - len(unreadable)} frames in {written}", err=True)
    if unreadable:
        raise CadetError(f"{unreadable.text(len(ids))}: they are not in {written}; `cadet check {data}` lists them")


@avod.command(name="eval")
@checkpoint_option
@data_option
@split_option("val")
@num_frames_option
@click.option(
    "--last", type=click.IntRange(1), help="Evaluate the last N checkpoints of a run; keep the best in best/."
)
@click.option("--levels", type=click.Choice(["kitti", "large_small"]), default="kitti", show_default=True)
@click.option("--min-overlap", type=click.Choice(list(MIN_OVERLAP)), default="strict", show_default=True)
@recall_option
@click.option("--plot", type=click.Path(path_type=Path, dir_okay=False), help="Draw the curves to a .png or .jpg.")
@click.option("--details", is_flag=True, help="Show what cadet eval --details shows.")
@click.option("--ablate", is_flag=True, help="Evaluate again without the image and without the LIDAR.")
@click.option("--json", "as_json", is_flag=True, help="Print everything, with curves and details, as JSON.")
@detection_options
@device_options
def evaluate_command(
    checkpoint: Path,
    data: Path,
    split: str | None,
    num_frames: int | None,
    last: int | None,
    levels: str,
    min_overlap: str,
    recall: str,
    plot: Path | None,
    details: bool,
    ablate: bool,
    as_json: bool,
    proposals: int | None,
    min_score: float | None,
    nms_iou: float | None,
    settings: tuple[str, ...],
    device: str,
    precision: str,
    workers: int | None,
) -> None:
    """Print KITTI's AP as cadet eval does; with --details, where AP is lost."""
    if plot is not None:
        check_picture_path(plot)
    samples, ids = frames_of(data, split, num_frames)
    paths = [checkpoint]
    if last is not None:
        folder = checkpoint / "checkpoints"
        paths = checkpoints(folder if folder.is_dir() else checkpoint)[-last:]
        if not paths:
            raise MissingFileError(f"{checkpoint}: no checkpoints")
    changes = detection_settings(settings, proposals, min_score, nms_iou)
    detectors = [_detector(path, device, precision, changes) for path in paths]
    names = detectors[0].config.class_names
    ablated: dict[str, Analysis] = {}
    done = itertools.count(1)
    rules: dict[str, Any] = {"levels": levels, "min_overlap": min_overlap, "recall": recall}
    rules["workers"] = resolve_workers(workers)
    rules |= {"parts": ("centers",)} if ablate else {}
    rules |= {"parts": PARTS, "by": ("distance", "occlusion")} if details or as_json else {}
    with progress((1 + len(ABLATIONS) * ablate) * len(ids), "evaluating") as advance:
        rules["on_frame"] = lambda: advance(next(done), "")
        analyses = analyze_detectors(detectors, samples, ids, **rules)
        reports = [analysis.report for analysis in analyses]
        scored = [Scored(path, report, score(report, names)) for path, report in zip(paths, reports, strict=True)]
        chosen = best(scored)
        number = scored.index(chosen)
        analysis = analyses[number]
        if ablate:
            ablated = {"both": analysis, **ablation(detectors[number], samples, ids, **rules)}
    if last is not None:
        for item in scored:
            click.echo(f"{item.path.name}  {item.value:.2f}{'  best' if item is chosen else ''}", err=as_json)
        keep_checkpoint(chosen.path, checkpoint / "best")
    if plot is not None:
        chosen.report.plot(plot)
    if as_json:
        masked = {name: _ablation_values(one) for name, one in ablated.items()}
        values = analysis.to_dict() | ({"ablation": masked} if masked else {})
        click.echo(json.dumps(values, indent=1, allow_nan=False))
    else:
        click.echo(f"{len(ids)} frames, {chosen.path}")
        print_analysis(analysis)
        if ablated:
            click.echo(f"\n{ablation_table(ablated, names).to_text()}")


def _ablation_values(analysis: Analysis) -> dict[str, Any]:
    values = analysis.to_dict()
    return {name: values.get(name, {}) for name in ("ap", "centers")}


@avod.command(name="bench")
@checkpoint_option
@data_option
@split_option("all")
@click.option("--num-frames", type=click.IntRange(1), default=2000, show_default=True, help="How many, from the first.")
@set_option
@device_options
def bench_command(
    checkpoint: Path,
    data: Path,
    split: str | None,
    num_frames: int,
    settings: tuple[str, ...],
    device: str,
    precision: str,
    workers: int | None,
) -> None:
    """Print the mean time of inference by stage, as the paper measures it, in one process."""
    if workers:
        raise CadetError("--workers: stages are timed one after the other, in one process")
    detector = _detector(checkpoint, device, precision, detection_settings(settings))
    timing = measure(detector, *frames_of(data, split, num_frames))
    stages = {
        "maps, anchors, image": timing.prepare_ms,
        "network": timing.network_ms,
        "boxes": timing.decode_ms,
        "inference": timing.inference_ms,
        "reading files (apart)": timing.read_ms,
    }
    rows = (("Stage", "ms"), *((name, f"{value:.1f}") for name, value in stages.items()))
    click.echo(Section(f"mean over {timing.num_frames} frames on {detector.device}", rows).to_text())


@avod.command(name="view")
@click.option("--checkpoint", metavar="DIR", type=click.Path(path_type=Path), help="Draw this checkpoint's detections.")
@click.option("--data", metavar="DIR", type=click.Path(path_type=Path), help="The data of the frame, as for predict.")
@click.option("--frame-id", metavar="ID", help="The frame.")
@click.option("--log", metavar="DIR", type=click.Path(path_type=Path), help="Draw the losses of this run instead.")
@click.option("-o", "--out", metavar="FILE", required=True, help="The picture, a .png or .jpg.")
@set_option
@device_options
def view_command(
    checkpoint: Path | None,
    data: Path | None,
    frame_id: str | None,
    log: Path | None,
    out: str,
    settings: tuple[str, ...],
    device: str,
    precision: str,
    workers: int | None,
) -> None:
    """Draw detections beside labels, in the image and from above; or the losses of a training."""
    if workers:
        raise CadetError("--workers: one frame needs none")
    check_picture_path(out)
    if log is not None:
        if checkpoint is not None or data is not None or frame_id is not None:
            raise CadetError("--log draws losses and takes no --checkpoint, --data or --frame-id")
        validations = read_validations(log / "val.csv") if (log / "val.csv").is_file() else []
        figure = loss_figure(read_log(log / "log.csv"), validations)
        click.echo(f"wrote {write_picture(out, figure)}")
        return
    if checkpoint is None or data is None or frame_id is None:
        raise CadetError("view needs --checkpoint, --data and --frame-id, or --log")
    detector = _detector(checkpoint, device, precision, detection_settings(settings))
    frame = open_frames(data).read_frame(check_id(frame_id))
    found = detector.detect_frame(frame)
    click.echo(f"wrote {write_picture(out, detection_figure(frame, found))}")


def _detector(checkpoint: Path, device: str, precision: str, changes: Mapping[str, Any]) -> Detector:
    detector = Detector(checkpoint, device=resolve_device(device), precision=resolve_precision(precision))
    try:
        detector.configure(changes)
    except CadetError as error:
        raise CadetError(f"--set: {str(error).removeprefix('--set: ')}") from None
    return detector
