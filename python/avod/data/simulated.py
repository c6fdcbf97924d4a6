"""Frames straight from the simulator as training samples, in an order that is a function of seed and step alone."""

from __future__ import annotations

import contextlib
import json
import threading
import zlib
from collections.abc import Iterator
from itertools import islice
from typing import Final

import numpy as np

from avod.config import Config
from avod.data.augmentation import Augmentation
from avod.data.dataset import sample_from_frame
from avod.data.frames import SimulatedFrames
from avod.data.order import stream_seed
from avod.data.paste import check_bank
from avod.data.prefetch import prefetched
from avod.data.sample import Sample
from avod.data.subset import usable_frames
from cadet.datasets.object_bank import ObjectBank
from cadet.errors import CadetError
from cadet.formats.kitti import Frame

BLOCK: Final = 80
"""Frames that are shuffled together: four episodes of the policy `kitti`, some 250 MB."""
_READY: Final = 4


class SimulatedData:
    """Endless frames of a simulation, each of them new, shuffled by blocks.

    Block by block, the frames that hold enough objects of the classes come in a drawn order; where some hold too few,
    others come twice, so that the block's length, and with it every step's frames, follow from its number alone. Of
    several processes each takes its own share of the episodes.

    Args:
        name: "sim:" and a TOML file of `cadet.Simulation`.
        config: the detector and its training.
        seed: of the order and the augmentations.
        bank: objects to paste into the frames.

    Raises:
        MissingFileError: no such file.
        CadetError: a bad file; a bank that is missing or holds nothing of the classes; sizes that are wanted of objects
            whose mean sizes nobody knows.
    """

    def __init__(self, name: str, config: Config, seed: int, bank: ObjectBank | None = None) -> None:
        check_bank(bank, config)
        if config.augmentation.object_sizes_lwh_m:
            raise CadetError(f"{name}: augmentation.object_sizes_lwh_m needs the mean sizes of a folder's labels")
        self._bank = bank
        self.simulation = SimulatedFrames(name).simulation
        self.config = config
        self._name, self._seed = name, seed

    @property
    def num_frames(self) -> int:
        """None that could be counted."""
        return 0

    @property
    def checksum(self) -> int:
        """Tell simulations apart."""
        return zlib.crc32(json.dumps(self.simulation.identity(), sort_keys=True).encode())

    @contextlib.contextmanager
    def samples(self, first: int, rank: int, world_size: int, workers: int) -> Iterator[Iterator[Sample]]:
        """Run the simulator meanwhile; yields an iterator over the samples of one process without end.

        Args:
            first: how many samples of this process come before.
            rank: this process.
            world_size: how many share the episodes.
            workers: processes that simulate; 0 does so in between.

        Raises:
            CadetError: no frame of a block holds enough objects, or what the simulator raises.
        """
        block = first // BLOCK
        with self.simulation.stream(workers=workers, first=block * BLOCK, shard=(rank, world_size)) as frames:
            if workers == 0:
                yield self._samples(frames, first, rank, world_size)
                return
            is_over = threading.Event()
            # While a block is learned from, the next one is simulated and the next samples are built.
            with (
                prefetched(frames, BLOCK, is_over) as ahead,
                prefetched(self._samples(ahead, first, rank, world_size), _READY, is_over) as samples,
            ):
                yield samples

    def _samples(self, frames: Iterator[Frame], first: int, rank: int, world_size: int) -> Iterator[Sample]:
        index = first
        while True:
            number = index // BLOCK
            block = list(islice(frames, BLOCK))
            if len(block) < BLOCK:
                return
            kept = self._kept(block, number, rank, world_size)
            drawn = np.random.default_rng(stream_seed(self._seed, "block", number, rank)).permutation(BLOCK)
            for place in range(index % BLOCK, BLOCK):
                frame_id, frame = kept[int(drawn[place]) % len(kept)]
                augmentation = self._augmentation(index * world_size + rank)
                yield sample_from_frame(frame, frame_id, self.config, augmentation, bank=self._bank)
                index += 1

    def _kept(self, frames: list[Frame], block: int, rank: int, world_size: int) -> list[tuple[str, Frame]]:
        ids = [self._id(block * BLOCK + place, rank, world_size) for place in range(BLOCK)]
        by_id = dict(zip(ids, frames, strict=True))
        labels = {frame_id: frame.labels for frame_id, frame in by_id.items()}
        place = f"{self._name}: none of the frames {ids[0]} to {ids[-1]}"
        return [(frame_id, by_id[frame_id]) for frame_id in usable_frames(labels, self.config, place)]

    def _id(self, position: int, rank: int, world_size: int) -> str:
        """Return the id that `cadet-gen` gives a frame of this process's share."""
        episode, sample = divmod(position, self.simulation.policy.samples_per_episode)
        return f"{(episode * world_size + rank) * self.simulation.policy.samples_per_episode + sample:06d}"

    def _augmentation(self, index: int) -> Augmentation:
        bits = stream_seed(self._seed, "augmentation", index)
        training = self.config.training
        return Augmentation(
            training.flip and bool(bits & 1),
            training.pca_jitter and bool(bits & 2),
            (self._seed, index),
            self.config.augmentation,
        )
