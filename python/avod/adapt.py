"""Self-training: a detector adapts to frames without labels by learning from what it is sure of in them.

Reference: Yang et al., "ST3D: Self-training for Unsupervised Domain Adaptation on 3D Object Detection" (CVPR 2021).
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final

from avod.config import Config
from avod.data.mixture import shares_of
from avod.detector import Detector
from avod.predict import predict
from avod.train import Run, train
from avod.train.checkpoint import read_checkpoint
from avod.train.settings import has_record
from cadet import kitti
from cadet._util.checks import Limits, check_fields
from cadet._util.plain_text import json_from_text
from cadet.errors import CadetError
from cadet.formats.kitti import Label, text_from_labels
from cadet.formats.kitti.files.folder import REQUIRED, file_path, found_path, write_whole
from cadet.formats.kitti.files.unreadable import Unreadable
from cadet.formats.kitti.image_sets import ImageSet, write_image_set
from cadet.formats.kitti_sequences import RawDrive

UNSURE: Final = "Unsure"
"""Type of what is neither learned from nor background."""
_SLOWER: Final = 3.0
"""What the learning rate is divided by."""
_AVERAGE_DECAY: Final = 0.99
_UNKNOWN_OCCLUSION: Final = 3


@dataclass(frozen=True, kw_only=True)
class Adaptation:
    """How a detector adapts.

    Raises:
        CadetError: a number outside its range.
    """

    rounds: Annotated[int, Limits(1, 100)] = 2
    """Of finding objects and learning from them."""
    steps: Annotated[int, Limits(1, 999_999_999)] = 400
    """Of each round's training."""
    sure: Annotated[float, Limits(0, 1)] = 0.5
    """Objects with at least this score are learned from ..."""
    unsure: Annotated[float, Limits(0, 1)] = 0.25
    """... those with at least this one are left open, and others are background."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.unsure > self.sure:
            raise CadetError(f"Adaptation.unsure: expected at most sure, {self.sure:g}, got {self.unsure:g}")


def adapt(
    checkpoint: str | Path,
    target: kitti.Dataset | RawDrive,
    run: Run,
    adaptation: Adaptation,
    *,
    on_frame: Callable[[int, int], None] = lambda number, done: None,
    on_step: Callable[[int, int, dict[str, Any]], None] = lambda number, done, losses: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Path | None:
    """Adapt a detector to frames whose labels, if there are any, are not looked at.

    Each round finds objects in all of them, mirrored too, and then tunes the weights on what it found and on labeled
    frames, half and half.

    Args:
        checkpoint: the detector to begin with, as `Detector` takes it.
        target: the frames.
        run: the labeled frames, such as those that the detector learned from, and the folder where the rounds go; with
            `resume` those that are there are not done again.
        adaptation: how often, how long, and from what.
        on_frame: called with a round, counted from 1, and how many frames it has looked at.
        on_step: called after each step with its round, how many of that are done, and its losses.
        should_stop: called after each step; on True training writes a checkpoint and ends.

    Returns:
        The last round's checkpoint; None if it was told to stop: with `Run.resume` it goes on.

    Raises:
        CadetError: no object is sure, the folder holds rounds already, or as for `predict` and `train`.
    """
    weights = Path(checkpoint)
    config = _tuning(weights, adaptation)
    _check_begun(run, checkpoint, adaptation)
    for number in range(1, adaptation.rounds + 1):
        out = Path(run.out) / f"round_{number}"
        found = out / "found"
        if not found.is_dir():
            labels = _found(weights, target, run, adaptation, partial(on_frame, number))
            _write_found(found, labels, target, run.split, adaptation)
        half = tuple((folder, share / 2.0) for folder, share in shares_of(run.data))
        is_begun = has_record(out)
        settings = replace(
            run,
            data=(*half, (found, 0.5)),
            out=out,
            init=None if is_begun else weights,
            resume=is_begun,
        )
        last = train(config, settings, on_step=partial(on_step, number), should_stop=should_stop)
        if last.name != f"{adaptation.steps:09d}":
            return None
        weights = last
    return weights


def pseudo_labels(labels: Iterable[Label], adaptation: Adaptation) -> tuple[Label, ...]:
    """Turn detections into labels to learn from: of their own type where they are sure, else of type `UNSURE`."""
    return tuple(
        replace(
            label,
            type=label.type if (label.score or 0.0) >= adaptation.sure else UNSURE,
            occluded=_UNKNOWN_OCCLUSION,
            score=None,
        )
        for label in labels
        if (label.score or 0.0) >= adaptation.unsure
    )


def _check_begun(run: Run, checkpoint: str | Path, adaptation: Adaptation) -> None:
    """Write down what rounds follow from, or compare it with what they were begun with."""
    path = Path(run.out) / "adaptation.json"
    settings = {"checkpoint": str(checkpoint), "seed": run.seed, **asdict(adaptation)}
    del settings["rounds"]
    if not path.exists():
        write_whole({path: (json.dumps(settings, indent=1) + "\n").encode()})
    elif not run.resume:
        raise CadetError(f"{path.parent}: an adaptation was begun there: name a new folder, or go on with --resume")
    elif (begun := json_from_text(path.read_bytes(), str(path))) != settings:
        raise CadetError(f"{path}: begun with {begun}, and is to go on with {settings}: change nothing but --rounds")


def _tuning(weights: Path, adaptation: Adaptation) -> Config:
    config = read_checkpoint(weights).config
    training = replace(
        config.training,
        steps=adaptation.steps,
        schedule="one_cycle",
        learning_rate=config.training.learning_rate / _SLOWER,
        average_decay=_AVERAGE_DECAY,
    )
    return replace(config, training=training, ignored_types=tuple(dict.fromkeys((*config.ignored_types, UNSURE))))


def _found(
    weights: Path, target: kitti.Dataset | RawDrive, run: Run, adaptation: Adaptation, on_frame: Callable[[int], None]
) -> Iterator[tuple[str, tuple[Label, ...]]]:
    detector = Detector(weights, device=run.device, precision=run.precision)
    detector.configure({"detection": {"flip": True, "min_score": adaptation.unsure}})
    unreadable = Unreadable(target.folder)
    found = predict(detector, target, target.ids, workers=run.workers, unreadable=unreadable)
    for done, item in enumerate(found, start=1):
        yield item
        on_frame(done)
    unreadable.say(len(target.ids))


def _write_found(
    folder: Path,
    found: Iterable[tuple[str, tuple[Label, ...]]],
    target: kitti.Dataset | RawDrive,
    split: str | None,
    adaptation: Adaptation,
) -> None:
    """Make a KITTI folder of what was found, whole or not at all: its other files are links to the target's."""
    aside = folder.with_name(f".{folder.name}.partial")
    shutil.rmtree(aside, ignore_errors=True)
    training = aside / "training"
    for kind in (*REQUIRED, "label_2"):
        (training / kind).mkdir(parents=True)
    ids = []
    for frame_id, labels in found:
        for kind, path in _inputs(training, target, frame_id):
            if path.exists():
                (training / kind).mkdir(exist_ok=True)
                (training / kind / path.name).symlink_to(path.resolve())
        text = text_from_labels(pseudo_labels(labels, adaptation))
        file_path(training, "label_2", frame_id).write_text(text, "ascii")
        ids.append(frame_id)
    if split is not None:
        write_image_set(aside, split, ImageSet(tuple(ids)))
    aside.rename(folder)


def _inputs(training: Path, target: kitti.Dataset | RawDrive, frame_id: str) -> list[tuple[str, Path]]:
    """List a frame's files to link, some of which may lack; a drive has one calibration, which is written down."""
    if isinstance(target, kitti.Dataset):
        return [(kind, found_path(target.folder, kind, frame_id)) for kind in (*REQUIRED, "planes")]
    file_path(training, "calib", frame_id).write_text(target.calib.to_text(), "ascii")
    return [(kind, target.path(kind, frame_id)) for kind in ("image_2", "velodyne")]
