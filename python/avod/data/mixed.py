"""Recorded frames and the live simulator in one training, each in its share of every thousand samples."""

from __future__ import annotations

import contextlib
import threading
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from avod.config import Config
from avod.data.dataset import TrainingData
from avod.data.frames import is_simulation
from avod.data.mixture import Turns
from avod.data.order import stream_seed
from avod.data.packing import PackedSample
from avod.data.prefetch import prefetched
from avod.data.sample import Sample
from avod.data.simulated import SimulatedData
from cadet.datasets.object_bank import ObjectBank
from cadet.errors import CadetError

_SIMULATED, _RECORDED = 0, 1
_READY: Final = 4


class MixedData:
    """Endless samples of a simulation and of folders, in a drawn order that follows from seed and place alone.

    Args:
        folders: with their shares, which sum to 1: one simulation, and one or more folders.
        split: of the folders: as for `TrainingData`.
        config: the detector and its training.
        seed: of all orders.
        bank: objects to paste into the frames.

    Raises:
        CadetError: several simulations, or what `TrainingData` and `SimulatedData` raise.
    """

    def __init__(
        self,
        folders: tuple[tuple[Path, float], ...],
        split: str | None,
        config: Config,
        seed: int,
        bank: ObjectBank | None = None,
    ) -> None:
        live = [(name, share) for name, share in folders if is_simulation(name)]
        if len(live) > 1:
            raise CadetError(f"{live[1][0]}: a training has one simulation: mix districts and weathers in its file")
        ((name, share),) = live
        recorded = [pair for pair in folders if not is_simulation(pair[0])]
        self._simulated = SimulatedData(str(name), config, seed, bank)
        self._recorded = TrainingData(recorded if len(recorded) > 1 else recorded[0][0], split, config, seed, bank)
        self._turns = Turns((share, 1.0 - share), stream_seed(seed, "live"))

    @property
    def num_frames(self) -> int:
        """How many recorded frames there are to learn from."""
        return self._recorded.num_frames

    @property
    def checksum(self) -> int:
        """Tell simulations and lists of frames apart."""
        return zlib.crc32(f"{self._simulated.checksum}/{self._recorded.checksum}".encode())

    @contextlib.contextmanager
    def samples(
        self, first: int, rank: int, world_size: int, workers: int
    ) -> Iterator[Iterator[Sample | PackedSample | CadetError | OSError]]:
        """Run the simulator meanwhile: as `SimulatedData.samples`. Recorded frames are read beside it, one by one."""
        simulated = self._turns.before(first, _SIMULATED)
        recorded = self._read(self._turns.before(first, _RECORDED), rank, world_size)
        is_over = threading.Event()
        with contextlib.ExitStack() as stack:
            live = stack.enter_context(self._simulated.samples(simulated, rank, world_size, workers))
            if workers > 0:
                recorded = stack.enter_context(prefetched(recorded, _READY, is_over))
            yield self._mixed(first, live, recorded)

    def _read(self, first: int, rank: int, world_size: int) -> Iterator[Sample | PackedSample | CadetError | OSError]:
        while True:
            yield self._recorded[first * world_size + rank]
            first += 1

    def _mixed(
        self, index: int, live: Iterator[Sample], recorded: Iterator[Sample | PackedSample | CadetError | OSError]
    ) -> Iterator[Sample | PackedSample | CadetError | OSError]:
        while True:
            yield next(recorded if self._turns.turn(index)[0] == _RECORDED else live)
            index += 1
