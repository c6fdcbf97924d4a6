"""Samples that other processes read and prepare: for the steps of a training, and for detection."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from itertools import islice
from typing import Any

import cv2
import torch
from torch.utils.data import DataLoader, Dataset
from torch.utils.data.dataloader import _MultiProcessingDataLoaderIter

from avod.config import Config, TrainingConfig
from avod.data.dataset import DetectionData, TrainingData
from avod.data.frames import Frames, SimulatedFrames, kept_running
from avod.data.mixed import MixedData
from avod.data.order import StepSampler
from avod.data.packing import PackedSample, on_device
from avod.data.sample import Sample
from avod.data.simulated import SimulatedData
from avod.device import Processes
from cadet._util.operating_system import ENDING_SIGNALS
from cadet.errors import CadetError
from cadet.formats.kitti.files.unreadable import READING_ERRORS


@contextmanager
def running(loader: DataLoader[Any]) -> Iterator[Iterator[Any]]:
    """Run a loader's workers meanwhile, each with one thread of OpenCV's.

    The number is set before they are forked: OpenCV's own threads do not come along, and a child that changes their
    number waits for them for ever. The loader's own draw, a seed for its workers, is not taken from the caller's
    generator. At the end workers are told to go, whatever still refers to the iterator, such as an
    error's traceback: this process waits for them before it ends, and they may outlive signals.
    """
    loader.generator = torch.Generator()
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        iterator = iter(loader)
    finally:
        cv2.setNumThreads(threads)
    try:
        yield iterator
    finally:
        if isinstance(iterator, _MultiProcessingDataLoaderIter):
            iterator._shutdown_workers()


@contextmanager
def prepared(frames: Frames, ids: tuple[str, ...], config: Config, workers: int) -> Iterator[Iterator[Any]]:
    """Read and prepare frames meanwhile, in their order; yields an iterator over the items of `DetectionData`.

    Args:
        frames: from anywhere.
        ids: of those that are wanted.
        config: the detector.
        workers: processes that read and prepare frames, or that simulate them; 0 does so in between.
    """
    num_readers = 0 if isinstance(frames, SimulatedFrames) else min(workers, len(ids))
    data = DetectionData(frames, ids, config)
    with kept_running(frames, workers), running(_loader(data, num_readers, batch_size=None)) as items:
        yield items


def batches(
    data: TrainingData | SimulatedData | MixedData,
    training: TrainingConfig,
    first_step: int,
    processes: Processes,
    workers: int,
) -> AbstractContextManager[Iterator[list[Sample | PackedSample | CadetError | OSError]]]:
    """Return what iterates, meanwhile, over the samples of each step, or the errors that reading them raised.

    Args:
        data: the frames.
        training: where training ends, and how many frames a step has.
        first_step: where it begins or goes on.
        processes: each has frames of its own.
        workers: processes that read samples, or simulate them; 0 does so in between.
    """
    if not isinstance(data, TrainingData):
        return _simulated(data, training, first_step, processes, workers)
    sampler = StepSampler(first_step, training.steps, training.frames_per_step, processes.rank, processes.world_size)
    num_readers = min(workers, len(sampler) * training.frames_per_step)
    return running(_loader(data, num_readers, batch_sampler=sampler, pin_memory=processes.device.type == "cuda"))


@contextmanager
def _simulated(
    data: SimulatedData | MixedData, training: TrainingConfig, first_step: int, processes: Processes, workers: int
) -> Iterator[Iterator[list[Sample | PackedSample | CadetError | OSError]]]:
    count = training.frames_per_step
    with data.samples(first_step * count, processes.rank, processes.world_size, workers) as samples:
        yield (list(islice(samples, count)) for _ in range(first_step, training.steps))


def whole(samples: list[Sample | PackedSample | CadetError | OSError], device: torch.device) -> list[Sample]:
    """Bring samples to a device.

    Raises:
        CadetError, OSError: what reading one of them raised.
    """
    moved = []
    for sample in samples:
        if isinstance(sample, READING_ERRORS):
            raise sample
        moved.append(on_device(sample, device))
    return moved


def _loader(data: Dataset[Any], num_workers: int, **settings: Any) -> DataLoader[Any]:
    return DataLoader(data, num_workers=num_workers, collate_fn=_as_it_is, worker_init_fn=_outlive_signals, **settings)


def _outlive_signals(_: int) -> None:
    """Let a worker end with its parent and not before it.

    Ctrl-C and most managers of jobs signal all processes of a group, and the parent still trains to the end of its
    step. They end when they are told to (`running`), or without a parent.
    """
    for number in (signal.SIGINT, *ENDING_SIGNALS):
        signal.signal(number, signal.SIG_IGN)


def _as_it_is(item: Any) -> Any:
    """Return what a dataset gave: samples are not stacked."""
    return item
