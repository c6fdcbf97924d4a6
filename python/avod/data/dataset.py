"""KITTI folders, real or generated, as samples."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from torch.utils.data import Dataset

from avod.config import Config
from avod.data.build import UNCHANGED, Augmentation, build_sample
from avod.data.order import Order
from avod.data.sample import Sample
from cadet import kitti
from cadet.errors import CadetError
from cadet.kitti.frame import Frame


def sample_from_frame(frame: Frame, frame_id: str, config: Config, augmentation: Augmentation = UNCHANGED) -> Sample:
    """Make a sample of a frame; the ground is estimated from the scan where it has no plane, or where `config` says so.

    Raises:
        CadetError: what `build_sample` raises, the frame named.
    """
    try:
        return build_sample(
            frame.points_velo,
            frame.image,
            frame.calib,
            frame.plane,
            config,
            labels=frame.labels,
            augmentation=augmentation,
            frame_id=frame_id,
        )
    except CadetError as error:
        raise CadetError(f"frame {frame_id}: {error}") from None


class TrainingData(Dataset[Any]):
    """The frames of a folder that hold enough objects of the classes, shuffled and changed, without end.

    An item is a sample, or the error that reading it raised, so that the error comes whole out of a worker.

    Args:
        root: a KITTI folder.
        split: a list of its `ImageSets`; None for every frame.
        config: the detector and its training.
        seed: of the order and the augmentations.

    Raises:
        MissingFileError: no folder, split or label file.
        CadetError: no frame holds enough objects of the classes.
    """

    def __init__(self, root: str | Path, split: str | None, config: Config, seed: int) -> None:
        dataset = kitti.Dataset(root, split)
        self.folder = dataset.folder
        self.config = config
        ids = dataset.ids
        names = set(config.class_names)
        least = config.training.min_objects
        self.ids = tuple(
            i for i in ids if sum(label.type in names for label in kitti.read_labels(self.folder, i)) >= least
        )
        if not self.ids:
            wanted = ("a " if least == 1 else f"{least} of ") + " or ".join(config.class_names)
            raise CadetError(f"{root}: none of the {len(ids)} frames{_in(split)} holds {wanted} to learn from")
        self._order = Order(len(self.ids), config.training, seed)

    def __getitem__(self, index: int) -> Sample | CadetError:
        entry = self._order.entry(index)
        frame_id = self.ids[entry.frame]
        try:
            frame = kitti.read_frame(self.folder, frame_id)
            return sample_from_frame(frame, frame_id, self.config, entry.augmentation)
        except CadetError as error:
            return error


class DetectionData(Dataset[Any]):
    """The frames of a folder in order, unchanged; items as in `TrainingData`.

    Args:
        root: a KITTI folder.
        ids: of the frames.
        config: the detector.
    """

    def __init__(self, root: str | Path, ids: tuple[str, ...], config: Config) -> None:
        self.root = Path(root)
        self.ids = ids
        self.config = config

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> tuple[Sample, Frame] | CadetError:
        try:
            frame = kitti.read_frame(self.root, self.ids[index])
            return sample_from_frame(frame, self.ids[index], self.config), frame
        except CadetError as error:
            return error


def _in(split: str | None) -> str:
    return "" if split is None else f" of the split {split!r}"
