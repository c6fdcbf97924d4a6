"""Batches of samples for the steps of a training, made by other processes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from itertools import islice
from typing import Any

import torch
from torch.utils.data import DataLoader

from avod.config import TrainingConfig
from avod.data.dataset import TrainingData
from avod.data.mixed import MixedData
from avod.data.order import StepSampler
from avod.data.packing import PackedSample, on_device
from avod.data.sample import Sample
from avod.data.simulated import SimulatedData
from avod.data.workers import as_it_is, outlive_signals, running
from avod.train.processes import Processes
from cadet.errors import CadetError
from cadet.formats.kitti.files.unreadable import READING_ERRORS


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
    loader: DataLoader[Any] = DataLoader(
        data,
        batch_sampler=sampler,
        num_workers=min(workers, len(sampler) * training.frames_per_step),
        collate_fn=as_it_is,
        pin_memory=processes.device.type == "cuda",
        persistent_workers=workers > 0,
        worker_init_fn=outlive_signals,
    )
    return running(loader)


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
