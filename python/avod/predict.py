"""Detection over frames from anywhere, and its measurement."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass

import torch

from avod.data.dataset import sample_from_frame
from avod.data.frames import Data, kept_running, open_frames
from avod.data.loading import prepared
from avod.data.packing import on_device
from avod.detector import Detector
from avod.results import detections
from cadet.errors import CadetError
from cadet.formats.kitti import Label
from cadet.formats.kitti.files.unreadable import READING_ERRORS, Unreadable


def predict(
    detector: Detector,
    data: Data,
    ids: tuple[str, ...],
    *,
    workers: int = 0,
    unreadable: Unreadable | None = None,
) -> Iterator[tuple[str, tuple[Label, ...]]]:
    """Detect objects in frames.

    Args:
        detector: the detector.
        data: a KITTI folder, shards, or "sim:" and a simulation's TOML file; open or not.
        ids: of the frames.
        workers: processes that read and prepare frames, or that simulate them; 0 does so in between.
        unreadable: gets the frames that cannot be read, which are left out; None for an error at the first.

    Yields:
        Each id in turn, and labels with scores, best first.

    Raises:
        CadetError: a frame that cannot be read.
    """
    for frame_id, (labels,) in predict_all([detector], data, ids, workers=workers, unreadable=unreadable):
        yield frame_id, labels


def predict_all(
    detectors: Sequence[Detector],
    data: Data,
    ids: tuple[str, ...],
    *,
    workers: int = 0,
    unreadable: Unreadable | None = None,
) -> Generator[tuple[str, list[tuple[Label, ...]]], None, None]:
    """Detect objects with several detectors, such as the checkpoints of a training; each frame is read once.

    Args:
        detectors: one or more, whose inputs are the same.
        data: a KITTI folder, shards, or "sim:" and a simulation's TOML file; open or not.
        ids: of the frames.
        workers: processes that read and prepare frames, or that simulate them; 0 does so in between.
        unreadable: gets the frames that cannot be read, which are left out; None for an error at the first.

    Yields:
        Each id in turn, and every detector's labels with scores, best first.

    Raises:
        CadetError: a frame that cannot be read, or detectors that need different inputs.
    """
    config = detectors[0].config
    for name in ("classes", "ground", "bev", "image", "anchors"):
        if any(getattr(detector.config, name) != getattr(config, name) for detector in detectors):
            raise CadetError(f"these detectors need different inputs, their {name!r} differ: run them one by one")
    with prepared(open_frames(data), ids, config, workers) as items:
        for frame_id, item in zip(ids, items, strict=True):
            if isinstance(item, READING_ERRORS):
                if unreadable is None:
                    raise item
                unreadable.add(frame_id, item)
                continue
            sample, calib = item
            sample = on_device(sample, detectors[0].device)
            yield frame_id, [detector.detect_samples([sample], [calib])[0] for detector in detectors]


@dataclass(frozen=True)
class Timing:
    """Mean milliseconds a frame, stage by stage.

    Attributes:
        num_frames: that were measured, after the first, which warms up.
        read_ms: files to memory.
        prepare_ms: maps, anchors and their filter, the image's resizing.
        network_ms: both stages.
        decode_ms: boxes, suppression, headings, labels.
    """

    num_frames: int
    read_ms: float
    prepare_ms: float
    network_ms: float
    decode_ms: float

    @property
    def inference_ms(self) -> float:
        """All but reading, as the paper counts."""
        return self.prepare_ms + self.network_ms + self.decode_ms


def measure(detector: Detector, data: Data, ids: tuple[str, ...]) -> Timing:
    """Time detection frame by frame, in this process alone, after one frame that is not counted.

    Args:
        detector: the detector.
        data: a KITTI folder, shards, or "sim:" and a simulation's TOML file; open or not.
        ids: of the frames; the first is run once more beforehand.
    """
    sums, frames = [0.0] * 4, open_frames(data)
    with kept_running(frames, 0):
        for number, frame_id in enumerate((ids[0], *ids)):
            marks = [time.perf_counter()]
            frame = frames.read_frame(frame_id)
            marks.append(time.perf_counter())
            sample = sample_from_frame(frame, frame_id, detector.config)
            marks.append(time.perf_counter())
            sample = sample.to(detector.device)
            (outputs,) = detector.run([sample])
            _wait(detector.device)
            marks.append(time.perf_counter())
            detections(detector.network, outputs, sample, frame.calib, detector.config)
            marks.append(time.perf_counter())
            if number > 0:
                sums = [total + end - start for total, start, end in zip(sums, marks, marks[1:], strict=False)]
    return Timing(len(ids), *(1e3 * total / len(ids) for total in sums))


def _wait(device: torch.device) -> None:
    if device.type == "cuda":
        torch.cuda.synchronize(device)
