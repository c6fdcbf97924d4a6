"""Which frame comes when in training, as a function of seed and step alone: resuming and workers change nothing."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import Sampler

from avod.config import TrainingConfig
from avod.data.augmentation import Augmentation
from cadet.formats.kitti.files.folder import is_numbered


def stream_seed(seed: int, name: str, *numbers: int) -> int:
    """Name a random stream: the same seed, name and numbers give the same 63 bits everywhere."""
    words = [seed, zlib.crc32(name.encode()), *numbers]
    return int(np.random.SeedSequence(words).generate_state(1, np.uint64)[0] >> np.uint64(1))


def torch_generator(seed: int, name: str, *numbers: int) -> torch.Generator:
    """Make a generator on the CPU for a named stream."""
    return torch.Generator().manual_seed(stream_seed(seed, name, *numbers))


@contextmanager
def seeded(device: torch.device, seed: int) -> Iterator[None]:
    """Let PyTorch's own generators, which dropout and new weights draw from, begin at a seed meanwhile.

    Afterward they are where the caller had them.

    Args:
        device: whose generator is seeded, besides that of the CPU.
        seed: of both.
    """
    devices = [] if device.type == "cpu" else [device]
    with torch.random.fork_rng(devices, device_type=device.type):
        torch.set_rng_state(torch.Generator().manual_seed(seed).get_state())
        for one in devices:
            getattr(torch, one.type).set_rng_state(torch.Generator(one).manual_seed(seed).get_state(), one)
        yield


def frame_number(frame_id: str) -> int:
    """Return a number for a frame's streams: that of six digits themselves, of another id a checksum."""
    return int(frame_id) if is_numbered(frame_id) else zlib.crc32(frame_id.encode())


@dataclass(frozen=True)
class Entry:
    """The frame that is read for one index, and its augmentation.

    Attributes:
        frame: its place in the list of frames.
        augmentation: how it is changed.
    """

    frame: int
    augmentation: Augmentation


class Order:
    """Shuffled epochs over the frames, each in every combination of the augmentations.

    Args:
        num_frames: frames in the list.
        config: which augmentations there are.
        seed: of the shuffling and of the augmentations' draws.
    """

    def __init__(self, num_frames: int, config: TrainingConfig, seed: int) -> None:
        self._changes = [
            (is_mirrored, has_jitter)
            for is_mirrored in ((False, True) if config.flip else (False,))
            for has_jitter in ((False, True) if config.pca_jitter else (False,))
        ]
        self._num_entries = num_frames * len(self._changes)
        self._seed = seed

    def entry(self, index: int) -> Entry:
        """Return what comes at an index, counted from the start of training."""
        epoch, place = divmod(index, self._num_entries)
        frame, change = divmod(int(_permutation(self._seed, epoch, self._num_entries)[place]), len(self._changes))
        is_mirrored, has_jitter = self._changes[change]
        return Entry(frame, Augmentation(is_mirrored, has_jitter, (self._seed, index)))


class StepSampler(Sampler[list[int]]):
    """The indices of each step, for one of several processes.

    Args:
        first_step: where training begins or goes on.
        num_steps: where it ends.
        frames_per_step: of this process.
        rank: this process.
        world_size: how many processes share a step.
    """

    def __init__(
        self, first_step: int, num_steps: int, frames_per_step: int, rank: int = 0, world_size: int = 1
    ) -> None:
        self._steps = range(first_step, num_steps)
        self._frames_per_step = frames_per_step
        self._rank, self._world_size = rank, world_size

    def __len__(self) -> int:
        return len(self._steps)

    def __iter__(self) -> Iterator[list[int]]:
        for step in self._steps:
            first = (step * self._world_size + self._rank) * self._frames_per_step
            yield list(range(first, first + self._frames_per_step))


@lru_cache(maxsize=2)
def _permutation(seed: int, epoch: int, count: int) -> NDArray[np.intp]:
    return np.random.default_rng(stream_seed(seed, "epoch", epoch)).permutation(count)
