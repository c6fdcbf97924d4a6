"""Frames by their ids, wherever they come from: a KITTI folder, a raw drive, shards, or the simulator."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Final, TypeAlias

from cadet import kitti
from cadet.errors import CadetError
from cadet.formats.kitti import Frame, Label, labels_from_text, text_from_labels
from cadet.formats.kitti_sequences import RawDrive
from cadet.formats.kitti_sequences.raw_drive import is_raw_drive
from cadet.formats.webdataset import ShardDataset, open_dataset
from cadet.simulation.simulation import Simulation
from cadet.simulation.streaming import FrameStream

PREFIX: Final = "sim:"
"""Begins the name of a simulation's file where data are named."""
_MOST_FRAMES: Final = 10**9


class SimulatedFrames:
    """The frames of a simulation, named by their places in it, as `cadet-gen` names them: "000000", "000001", ...

    A frame can be read at any place, at the cost of driving there from the start of its episode, unless the one before
    it was read last and `kept_running` holds.

    Args:
        name: "sim:" and a TOML file of `cadet.Simulation`.

    Attributes:
        folder: the file.
        simulation: what it holds.

    Raises:
        MissingFileError: no such file.
        CadetError: a bad file.
    """

    def __init__(self, name: str) -> None:
        self.folder = Path(name.removeprefix(PREFIX))
        self.simulation = Simulation.read(self.folder)
        self._labels: dict[str, tuple[Label, ...]] = {}
        self._workers: int | None = None
        self._stream: FrameStream | None = None

    def first(self, count: int) -> tuple[str, ...]:
        """Return the ids of the first `count` frames."""
        return tuple(f"{place:06d}" for place in range(count))

    def read_frame(self, frame_id: str, *, has_extras: bool = True) -> Frame:
        """Simulate a frame; `has_extras` is for folders, whose further files cost time.

        Raises:
            CadetError: an id that is no place, or what the simulator raises.
        """
        place = _place(frame_id, self.folder)
        if self._stream is None or self._stream.position != place:
            self._close()
            self._stream = self.simulation.stream(workers=self._workers or 0, first=place)
        frame = next(self._stream)
        self._labels[frame_id] = frame.labels
        if self._workers is None:
            self._close()
        return frame

    def read_labels(self, frame_id: str) -> tuple[Label, ...]:
        """Return a frame's labels with the digits of a file; a frame that was read before is not simulated again."""
        if frame_id not in self._labels:
            self.read_frame(frame_id)
        return labels_from_text(text_from_labels(self._labels[frame_id]))

    @contextmanager
    def kept_running(self, workers: int) -> Iterator[None]:
        """Keep the simulator meanwhile, so that frames that are read in their order cost no more than in a stream.

        Args:
            workers: processes that simulate ahead; 0 simulates in between.
        """
        self._workers = workers
        try:
            yield
        finally:
            self._workers = None
            self._close()

    def _close(self) -> None:
        if self._stream is not None:
            self._stream.close()
        self._stream = None


Frames: TypeAlias = kitti.Dataset | RawDrive | ShardDataset | SimulatedFrames
Data: TypeAlias = str | Path | Frames


def open_frames(data: Data, split: str | None = None) -> Frames:
    """Open a KITTI folder, a raw drive, shards in a folder or by a pattern, or "sim:" and a simulation's TOML file.

    Args:
        data: as above; what is open already is returned as it is.
        split: a list of `ImageSets`, or a folder of shards; None for every frame.

    Raises:
        MissingFileError: no such folder, shard, split, or file.
        CadetError: damaged shards, a bad simulation, or a split of a raw drive.
    """
    if not isinstance(data, str | Path):
        return data
    if is_simulation(data):
        return SimulatedFrames(str(data))
    if not is_raw_drive(Path(data)):
        return open_dataset(data, split)
    if split is not None:
        raise CadetError(f"{data}: a raw drive has no split {split!r}: take --split all")
    return RawDrive(data)


def kept_running(frames: Frames, workers: int) -> AbstractContextManager[None]:
    """Keep the simulator meanwhile, if frames come from one."""
    return frames.kept_running(workers) if isinstance(frames, SimulatedFrames) else nullcontext()


def is_simulation(data: str | Path) -> bool:
    """Tell whether a name of data is a simulation's."""
    return str(data).startswith(PREFIX)


def _place(frame_id: str, file: Path) -> int:
    if not (frame_id.isascii() and frame_id.isdecimal() and int(frame_id[:10]) < _MOST_FRAMES):
        raise CadetError(f"{file}: frame {frame_id[:40]!r}: expected its place in the simulation, such as 000012")
    return int(frame_id)
