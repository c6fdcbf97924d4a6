"""KITTI folders, real or generated, and shards of them, as samples."""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from torch.utils.data import Dataset, get_worker_info

from avod.config import Config
from avod.data.build import UNCHANGED, Augmentation, build_sample, ground_plane
from avod.data.order import Order
from avod.data.packing import PackedSample, packed
from avod.data.sample import Sample
from cadet import kitti
from cadet.errors import CadetError
from cadet.kitti import Calibration
from cadet.kitti.frame import Frame
from cadet.webdataset import ShardDataset, open_dataset


def sample_from_frame(
    frame: Frame,
    frame_id: str,
    config: Config,
    augmentation: Augmentation = UNCHANGED,
    grounds: dict[str, NDArray[np.float64]] | None = None,
    maps: NDArray[np.float32] | None = None,
) -> Sample:
    """Make a sample of a frame; the ground is estimated from the scan where it has no plane, or where `config` says so.

    `grounds` holds the ground of frames that were seen before, by id, and gets this one's; `maps` is memory for maps.

    Raises:
        CadetError: what `build_sample` raises, the frame named.
    """
    try:
        ground = (grounds or {}).get(frame_id)
        if ground is None:
            ground = ground_plane(frame.points_velo, frame.calib, frame.plane, config)
        if grounds is not None:
            grounds[frame_id] = ground
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
    except CadetError as error:
        raise CadetError(f"frame {frame_id}: {error}") from None


class TrainingData(Dataset[Any]):
    """The frames of a folder that hold enough objects of the classes, shuffled and changed, without end.

    An item is a sample, or the error that reading it raised, so that the error comes whole out of a worker.

    Args:
        root: a KITTI folder, a folder of shards, or a pattern that names shards: what `open_dataset` takes.
        split: a list of its `ImageSets`; None for every frame.
        config: the detector and its training.
        seed: of the order and the augmentations.

    Raises:
        MissingFileError: no folder, split or label file.
        CadetError: no frame holds enough objects of the classes.
    """

    def __init__(self, root: str | Path, split: str | None, config: Config, seed: int) -> None:
        self._frames = open_dataset(root, split)
        self.config = config
        ids = self._frames.ids
        names = set(config.class_names)
        least = config.training.min_objects
        self.ids = tuple(i for i in ids if sum(label.type in names for label in self._frames.read_labels(i)) >= least)
        if not self.ids:
            wanted = ("a " if least == 1 else f"{least} of ") + " or ".join(config.class_names)
            raise CadetError(f"{root}: none of the {len(ids)} frames{_in(split)} holds {wanted} to learn from")
        self._order = Order(len(self.ids), config.training, seed)
        self._grounds: dict[str, NDArray[np.float64]] = {}
        self._maker = _Maker(config)

    @property
    def num_frames(self) -> int:
        """How many frames there are to learn from."""
        return len(self.ids)

    @property
    def checksum(self) -> int:
        """Tell lists of frames apart: their ids in their order."""
        return zlib.crc32("\n".join(self.ids).encode())

    def __getitem__(self, index: int) -> Sample | PackedSample | CadetError:
        entry = self._order.entry(index)
        frame_id = self.ids[entry.frame]
        try:
            frame = self._frames.read_frame(frame_id, has_extras=False)
            return self._maker.make(frame, frame_id, entry.augmentation, self._grounds)
        except CadetError as error:
            return error


class DetectionData(Dataset[Any]):
    """The frames of a folder in order, unchanged. An item is a sample and its calibration, or the error of reading it.

    Args:
        frames: of a KITTI folder or of shards.
        ids: of those that are wanted.
        config: the detector.
    """

    def __init__(self, frames: kitti.Dataset | ShardDataset, ids: tuple[str, ...], config: Config) -> None:
        self._frames = frames
        self.ids = ids
        self._maker = _Maker(config)

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> tuple[Sample | PackedSample, Calibration] | CadetError:
        try:
            frame = self._frames.read_frame(self.ids[index], has_extras=False)
            return self._maker.make(frame, self.ids[index]), frame.calib
        except CadetError as error:
            return error


class _Maker:
    """Makes samples; in a worker they are packed for its parent, and their maps share their memory."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._maps: NDArray[np.float32] | None = None

    def make(
        self,
        frame: Frame,
        frame_id: str,
        augmentation: Augmentation = UNCHANGED,
        grounds: dict[str, NDArray[np.float64]] | None = None,
    ) -> Sample | PackedSample:
        if get_worker_info() is None:
            return sample_from_frame(frame, frame_id, self._config, augmentation, grounds)
        if self._maps is None:
            self._maps = np.empty(self._config.bev.shape, np.float32)
        return packed(sample_from_frame(frame, frame_id, self._config, augmentation, grounds, self._maps))


def _in(split: str | None) -> str:
    return "" if split is None else f" of the split {split!r}"
