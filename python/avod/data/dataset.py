"""KITTI folders, real or generated, and shards of them, as samples."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from torch.utils.data import Dataset, get_worker_info

from avod.config import Config, Size
from avod.data.augmentation import UNCHANGED, Augmentation
from avod.data.build import build_sample, ground_plane
from avod.data.frames import Frames
from avod.data.mixture import Folders, Mixture, set_seed, shares_of
from avod.data.object_sizes import size_shifts_m
from avod.data.order import Order
from avod.data.packing import PackedSample, packed
from avod.data.paste import DamagedBankError, check_bank, paste_objects
from avod.data.sample import Sample
from avod.data.subset import draw_frames, usable_frames
from cadet import kitti
from cadet._util.notices import notice
from cadet.datasets.object_bank import ObjectBank
from cadet.errors import CadetError
from cadet.formats.kitti import Calibration, Label
from cadet.formats.kitti.files.folder import REQUIRED
from cadet.formats.kitti.files.unreadable import READING_ERRORS, Unreadable, frames_with_files
from cadet.formats.kitti.frame import Frame
from cadet.formats.webdataset import ShardDataset, open_dataset

_MOST_TRIED: Final = 20
"""Number of frames in a row that are never unreadable by chance where most can be read."""


def sample_from_frame(
    frame: Frame,
    frame_id: str,
    config: Config,
    augmentation: Augmentation = UNCHANGED,
    grounds: dict[str, NDArray[np.float64]] | None = None,
    maps: NDArray[np.float32] | None = None,
    bank: ObjectBank | None = None,
) -> Sample:
    """Make a sample of a frame; the ground is estimated from the scan where it has no plane, or where `config` says so.

    `grounds` holds the ground of frames that were seen before, by id, and gets this one's; `maps` is memory for maps;
    objects of `bank` are pasted into the frame.

    Raises:
        CadetError: what `build_sample` raises, the frame named, or a damaged bank.
    """
    try:
        ground = (grounds or {}).get(frame_id)
        if ground is None:
            ground = ground_plane(frame.points_velo, frame.calib, frame.plane, config, frame_id)
        if grounds is not None:
            grounds[frame_id] = ground
        if bank is not None:
            frame = paste_objects(frame, ground, bank, config.class_names, augmentation)
        return build_sample(
            frame.points_velo,
            frame.image,
            frame.calib,
            frame.plane,
            config,
            labels=frame.labels,
            augmentation=augmentation,
            ground=ground,
            maps=maps,
            frame_id=frame_id,
        )
    except DamagedBankError:
        raise
    except CadetError as error:
        raise CadetError(f"frame {frame_id}: {error}") from None


class TrainingData(Dataset[Any]):
    """The frames of folders that hold enough objects of the classes, shuffled and changed, endlessly.

    A frame that cannot be read is left out with a warning, and frames that its index draws take its turn, so that
    training stays a function of seed and data. An item is a sample, or the error that reading the last of them raised,
    so that the error comes whole out of a worker.

    Args:
        data: a KITTI folder, a folder of shards, or a pattern that names shards, as `open_dataset` takes them; or
            several with their shares.
        split: a list of their `ImageSets`; None for every frame.
        config: the detector and its training.
        seed: of the order and the augmentations.
        bank: of the objects that are pasted; needed where the configuration asks for some, and refused where it does
            not.
        frames: learn from only this many of them, of the last folder's where there are several, drawn by `seed`; None
            for all.

    Raises:
        MissingFileError: no folder, split or label file.
        CadetError: more than half of a folder's frames lack a file, or have labels that cannot be read; a bank that is
            missing, or that holds nothing of the classes; no frame of a folder holds enough
            objects of the classes, or fewer do than `frames`, or shares that are none.
    """

    def __init__(
        self,
        data: Folders,
        split: str | None,
        config: Config,
        seed: int,
        bank: ObjectBank | None = None,
        frames: int | None = None,
    ) -> None:
        folders = shares_of(data)
        check_bank(bank, config)
        self.config = config
        drawn = [None] * (len(folders) - 1) + [None if frames is None else (frames, seed)]
        self._sets = [
            _Set.read(root, split, config, few, has_prefix=len(folders) > 1)
            for (root, _), few in zip(folders, drawn, strict=True)
        ]
        orders = [
            Order(len(item.ids), config.training, set_seed(seed, number, len(folders)))
            for number, item in enumerate(self._sets)
        ]
        self._mixture = Mixture(orders, [share for _, share in folders], seed)
        self._maker = _Maker(config, bank)

    @property
    def ids(self) -> tuple[str, ...]:
        """Name all frames; those of several folders begin with the folder's number."""
        if len(self._sets) == 1:
            return self._sets[0].ids
        return tuple(f"{number}/{frame_id}" for number, item in enumerate(self._sets) for frame_id in item.ids)

    @property
    def num_frames(self) -> int:
        """How many frames there are to learn from."""
        return len(self.ids)

    @property
    def checksum(self) -> int:
        """Tell lists of frames apart: their ids in their order."""
        return zlib.crc32("\n".join(self.ids).encode())

    def __getitem__(self, index: int) -> Sample | PackedSample | CadetError | OSError:
        number, entry = self._mixture.entry(index)
        item = self._sets[number]
        augmentation = replace(entry.augmentation, settings=self.config.augmentation, size_shifts_m=item.size_shifts_m)
        error: CadetError | OSError | None = None
        for frame_id in item.tried(index, entry.frame):
            try:
                frame = item.frames.read_frame(frame_id, has_extras=False)
                return self._maker.make(frame, item.name_of(frame_id), augmentation, item.grounds)
            except DamagedBankError as caught:
                return caught
            except READING_ERRORS as caught:
                error = caught
                item.unreadable.add(frame_id, caught)
                notice(
                    [f"frame {item.name_of(frame_id)} is left out, others take its turn: {caught}"],
                    about=str(item.frames.folder),
                    key=frame_id,
                )
        return error or CadetError(f"{item.unreadable.text(len(item.ids))}: too many to train without them")


@dataclass(frozen=True)
class _Set:
    """One folder's frames.

    Attributes:
        frames: of a KITTI folder or of shards.
        ids: of the frames that are learned from.
        size_shifts_m: by which its objects' sizes differ from those that are wanted, class by class; empty for none.
        prefix: of its frames' names in messages.
        unreadable: frames that were found not to be.
        grounds: the ground of frames that were seen before.
    """

    frames: kitti.Dataset | ShardDataset
    ids: tuple[str, ...]
    size_shifts_m: tuple[Size, ...]
    prefix: str
    unreadable: Unreadable
    grounds: dict[str, NDArray[np.float64]] = field(default_factory=dict)

    @classmethod
    def read(
        cls, root: Path, split: str | None, config: Config, drawn: tuple[int, int] | None, *, has_prefix: bool
    ) -> _Set:
        """Read which frames of a folder hold enough objects of the classes; `drawn`: how many, and a seed."""
        frames = open_dataset(root, split)
        labels = readable_labels(frames, root)
        ids = usable_frames(labels, config, f"{root}: none of the {len(labels)} frames{_in(split)}")
        if drawn is not None:
            if drawn[0] > len(ids):
                raise CadetError(f"--num-frames {drawn[0]}: {root}: {len(ids)} frames{_in(split)} hold enough objects")
            ids = draw_frames(ids, *drawn)
        shifts = size_shifts_m((label for i in ids for label in labels[i]), config.class_names, config.augmentation)
        return cls(frames, ids, shifts, f"{root}/" if has_prefix else "", Unreadable(root))

    def tried(self, index: int, first: int) -> Iterator[str]:
        """Yield the frame whose turn it is, and those that take its turn where none before can be read."""
        if self.ids[first] not in self.unreadable:
            yield self.ids[first]
        for place in np.random.default_rng([index, first]).integers(len(self.ids), size=_MOST_TRIED):
            if self.ids[place] not in self.unreadable:
                yield self.ids[place]

    def name_of(self, frame_id: str) -> str:
        """Name a frame in messages."""
        return self.prefix + frame_id


def readable_labels(frames: kitti.Dataset | ShardDataset, root: str | Path) -> dict[str, tuple[Label, ...]]:
    """Read the labels of all frames that have their files, in order; those that cannot be read are left out.

    Raises:
        MissingFileError: no frame has an image, a scan, a calibration, or labels.
        CadetError: more than half of the frames lack a file, or have labels that cannot be read.
    """
    unreadable, labels = Unreadable(root), {}
    for frame_id in frames_with_files(frames, unreadable, root, (*REQUIRED, "label_2")):
        try:
            labels[frame_id] = frames.read_labels(frame_id)
        except READING_ERRORS as error:
            unreadable.add(frame_id, error)
    unreadable.say(len(frames.ids))
    return labels


class DetectionData(Dataset[Any]):
    """The frames of a folder in order, unchanged. An item is a sample and its calibration, or the error of reading it.

    Args:
        frames: from anywhere.
        ids: of those that are wanted.
        config: the detector.
    """

    def __init__(self, frames: Frames, ids: tuple[str, ...], config: Config) -> None:
        self._frames = frames
        self.ids = ids
        self._maker = _Maker(config)

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> tuple[Sample | PackedSample, Calibration] | CadetError | OSError:
        try:
            frame = self._frames.read_frame(self.ids[index], has_extras=False)
            return self._maker.make(frame, self.ids[index]), frame.calib
        except READING_ERRORS as error:
            return error


class _Maker:
    """Makes samples; in a worker they are packed for its parent, and their maps share their memory."""

    def __init__(self, config: Config, bank: ObjectBank | None = None) -> None:
        self._config = config
        self._bank = bank
        self._maps: NDArray[np.float32] | None = None

    def make(
        self,
        frame: Frame,
        frame_id: str,
        augmentation: Augmentation = UNCHANGED,
        grounds: dict[str, NDArray[np.float64]] | None = None,
    ) -> Sample | PackedSample:
        if get_worker_info() is None:
            return sample_from_frame(frame, frame_id, self._config, augmentation, grounds, bank=self._bank)
        if self._maps is None:
            self._maps = np.empty(self._config.bev.shape, np.float32)
        return packed(sample_from_frame(frame, frame_id, self._config, augmentation, grounds, self._maps, self._bank))


def _in(split: str | None) -> str:
    return "" if split is None else f" of the split {split!r}"
