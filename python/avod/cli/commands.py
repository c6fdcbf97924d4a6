"""`avod`: train, predict, eval, bench, view."""

from __future__ import annotations

import itertools
from pathlib import Path

import click

from avod.cli.options import (
    checkpoint_option,
    data_option,
    device_options,
    frames_of,
    frames_option,
    progress,
    resolve_device,
    resolve_precision,
    resolve_split,
    split_option,
)
from avod.config_file import config_names, load_config
from avod.detector import Detector
from avod.evaluate import Scored, best, evaluate_detector, score, table
from avod.figures import detection_figure, loss_figure
from avod.predict import measure, predict
from avod.train.checkpoint import checkpoints, keep_best
from avod.train.log import read_log
from avod.train.run import Run, train, with_steps
from cadet import __version__, kitti
from cadet.cli.signals import exit_code, how_ended
from cadet.errors import CadetError, MissingFileError
from cadet.evaluation.limits import MIN_OVERLAP
from cadet.kitti import text_from_labels
from cadet.sink import LocalSink
from cadet.view.picture import check_picture_path, write_picture


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="avod")
def avod() -> None:
    """Train AVOD-FPN on KITTI folders and detect 3D objects with it."""


@avod.command(name="train")
@click.option("--config", metavar="NAME|FILE", required=True, help=f"One of {', '.join(config_names())}, or a .toml.")
@data_option
@split_option("train")
@click.option("--out", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Log and checkpoints.")
@click.option("--steps", type=click.IntRange(1), help="Where training ends.  [default: the configuration's]")
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True, help="Of all that is drawn.")
@click.option("--init", metavar="DIR", type=click.Path(path_type=Path), help="Begin at step 0 with these weights.")
@click.option(
    "--resume-from", metavar="DIR", type=click.Path(path_type=Path), help="Go on with optimizer, step and schedule."
)
@click.option("--compile", "is_compiled", is_flag=True, help="Compile the feature pyramids.")
@click.option("--tensorboard", is_flag=True, help="Write TensorBoard's files too.")
@device_options
def train_command(
    config: str,
    data: Path,
    split: str | None,
    out: Path,
    steps: int | None,
    seed: int,
    init: Path | None,
    resume_from: Path | None,
    is_compiled: bool,
    tensorboard: bool,
    device: str,
    amp: str | None,
    workers: int,
) -> int:
    """Train a detector.

    \b
    avod train --config tiny_car --data set --out run
    avod train --config car_default --data kitti --out tuned --resume-from run --steps 150000 --device cuda --amp bf16
    torchrun --nproc-per-node 4 -m avod train ...
    """  # noqa: D301 - click reads the backspace
    settings = with_steps(load_config(config), steps)
    run = Run(
        data=data,
        out=out,
        split=resolve_split(split),
        seed=seed,
        init=init,
        resume_from=resume_from,
        device=resolve_device(device),
        precision=resolve_precision(amp),
        workers=workers,
        is_compiled=is_compiled,
        has_tensorboard=tensorboard,
    )
    try:
        with progress(settings.training.steps, "training", "steps") as advance:
            last = train(
                settings, run, on_step=lambda step, losses: advance(step, f"loss {float(losses['total']):.3f}")
            )
    except KeyboardInterrupt as error:
        click.echo(f"{how_ended(error)}; {_how_to_go_on(out, settings.training.checkpoint_steps)}", err=True)
        return exit_code(error)
    click.echo(f"last checkpoint: {last}", err=True)
    return 0


def _how_to_go_on(out: Path, checkpoint_steps: int) -> str:
    written = checkpoints(out / "checkpoints")
    if not written:
        return f"no checkpoint yet: there is one every {checkpoint_steps} steps"
    return f"last checkpoint: {written[-1]}; go on from it by --resume-from {out}"


@avod.command(name="predict")
@checkpoint_option
@data_option
@split_option("all")
@frames_option
@click.option("--out", metavar="DIR", required=True, type=click.Path(path_type=Path), help="A file for each frame.")
@device_options
def predict_command(
    checkpoint: Path,
    data: Path,
    split: str | None,
    frames: int | None,
    out: Path,
    device: str,
    amp: str | None,
    workers: int,
) -> None:
    """Write KITTI's result files; a frame where nothing is found has an empty one."""
    detector = _detector(checkpoint, device, amp)
    samples, ids = frames_of(data, split, frames)
    sink = LocalSink(out)
    count = 0
    with progress(len(ids), "detecting") as advance:
        for done, (frame_id, labels) in enumerate(predict(detector, samples, ids, workers=workers), start=1):
            sink.put(f"{frame_id}.txt", text_from_labels(labels).encode("ascii"))
            count += len(labels)
            advance(done, "")
    sink.remove_partial()
    click.echo(f"{count} detections in {len(ids)} frames in {out}", err=True)


@avod.command(name="eval")
@checkpoint_option
@data_option
@split_option("val")
@frames_option
@click.option(
    "--last", type=click.IntRange(1), help="Evaluate this many last checkpoints of a training; keep the best in best/."
)
@click.option("--levels", type=click.Choice(["kitti", "large_small"]), default="kitti", show_default=True)
@click.option("--min-overlap", type=click.Choice(list(MIN_OVERLAP)), default="strict", show_default=True)
@click.option("--plot", type=click.Path(path_type=Path, dir_okay=False), help="Draw the curves: a .png or .jpg.")
@device_options
def evaluate_command(
    checkpoint: Path,
    data: Path,
    split: str | None,
    frames: int | None,
    last: int | None,
    levels: str,
    min_overlap: str,
    plot: Path | None,
    device: str,
    amp: str | None,
    workers: int,
) -> None:
    """Print AP 3D and BEV, with 11 and with 40 recall positions."""
    if plot is not None:
        check_picture_path(plot)
    samples, ids = frames_of(data, split, frames)
    paths = [checkpoint]
    if last is not None:
        folder = checkpoint / "checkpoints"
        paths = checkpoints(folder if folder.is_dir() else checkpoint)[-last:]
        if not paths:
            raise MissingFileError(f"{checkpoint}: no checkpoints")
    scored, done = [], itertools.count(1)
    names: tuple[str, ...] = ()
    with progress(len(paths) * len(ids), "evaluating") as advance:
        for path in paths:
            detector = _detector(path, device, amp)
            names = detector.config.class_names
            report = evaluate_detector(
                detector,
                samples,
                ids,
                levels=levels,
                min_overlap=min_overlap,
                workers=workers,
                on_frame=lambda: advance(next(done), ""),
            )
            scored.append(Scored(path, report, score(report, names)))
    chosen = best(scored)
    if last is not None:
        for item in scored:
            click.echo(f"{item.path.name}  {item.value:.2f}{'  best' if item is chosen else ''}")
        keep_best(chosen.path, checkpoint / "best")
    if plot is not None:
        chosen.report.plot(plot)
    _print(table(chosen.report, names), f"{len(ids)} frames, {chosen.path}")
    for warning in chosen.report.warnings:
        click.echo(f"Note: {warning}")


@avod.command(name="bench")
@checkpoint_option
@data_option
@split_option("all")
@click.option("--frames", type=click.IntRange(1), default=2000, show_default=True, help="The first so many.")
@device_options
def bench_command(
    checkpoint: Path, data: Path, split: str | None, frames: int, device: str, amp: str | None, workers: int
) -> None:
    """Print the mean time of inference by stage, as the paper measures it, in one process."""
    if workers:
        raise CadetError("--workers: stages are timed one after the other, in one process")
    detector = _detector(checkpoint, device, amp)
    timing = measure(detector, *frames_of(data, split, frames))
    stages = {
        "maps, anchors, image": timing.prepare_ms,
        "network": timing.network_ms,
        "boxes": timing.decode_ms,
        "inference": timing.inference_ms,
        "reading files (apart)": timing.read_ms,
    }
    _print(
        [["Stage", "ms"], *([name, f"{value:.1f}"] for name, value in stages.items())],
        f"mean over {timing.num_frames} frames on {detector.device}",
    )


@avod.command(name="view")
@click.option("--checkpoint", metavar="DIR", type=click.Path(path_type=Path), help="Draw its detections ...")
@click.option("--data", metavar="DIR", type=click.Path(path_type=Path), help="... in a frame of this folder.")
@click.option("--frame", "frame_id", metavar="ID", help="The frame.")
@click.option("--log", metavar="DIR", type=click.Path(path_type=Path), help="Draw the losses of this training instead.")
@click.option("-o", "--output", metavar="FILE", required=True, help="A .png or .jpg.")
@device_options
def view_command(
    checkpoint: Path | None,
    data: Path | None,
    frame_id: str | None,
    log: Path | None,
    output: str,
    device: str,
    amp: str | None,
    workers: int,
) -> None:
    """Draw detections beside labels, in the image and from above; or the losses of a training."""
    if workers:
        raise CadetError("--workers: one frame needs none")
    check_picture_path(output)
    if log is not None:
        if checkpoint is not None or data is not None or frame_id is not None:
            raise CadetError("--log draws losses and takes no --checkpoint, --data or --frame")
        click.echo(f"wrote {write_picture(output, loss_figure(read_log(log / 'log.csv')))}")
        return
    if checkpoint is None or data is None or frame_id is None:
        raise CadetError("view needs --checkpoint, --data and --frame, or --log")
    detector = _detector(checkpoint, device, amp)
    frame = kitti.read_frame(data, frame_id)
    found = detector.detect(frame.points_velo, frame.image, frame.calib, frame.plane)
    click.echo(f"wrote {write_picture(output, detection_figure(frame, found))}")


def _detector(checkpoint: Path, device: str, amp: str | None) -> Detector:
    return Detector.load(checkpoint, device=resolve_device(device), precision=resolve_precision(amp))


def _print(rows: list[list[str]], title: str) -> None:
    """Print a table, its header first; wider than the terminal rather than cut off."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    click.echo(title)
    for row in rows:
        numbers = [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        click.echo("  ".join([row[0].ljust(widths[0]), *numbers]))
