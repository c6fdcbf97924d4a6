"""KITTI folders, real or ours, as samples."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray
from torch.utils.data import Dataset

from avod.config import Config
from avod.data.build import UNCHANGED, Augmentation, BevMaps, build_sample
from avod.data.order import Order
from avod.data.sample import Sample
from cadet import kitti
from cadet.errors import CadetError
from cadet.frame import Frame
from cadet.kitti import Calibration


class PlaneEstimate(Protocol):
    """Finds the ground of a scan: `cadet.kitti.estimate_plane`."""

    def __call__(self, points_velo: NDArray[np.float32], calib: Calibration) -> NDArray[np.float64]:
        """Return the plane (4,) in the cam frame."""


def ground_plane(
    points_velo: NDArray[np.float32], calib: Calibration, plane: NDArray[np.float64] | None, name: str
) -> NDArray[np.float64]:
    """Return a frame's ground plane, estimated from its scan where there is none.

    Raises:
        CadetError: there is none, and this build of cadet cannot estimate one.
    """
    if plane is not None:
        return plane
    estimate = cast("PlaneEstimate | None", getattr(kitti, "estimate_plane", None))
    if estimate is None:
        raise CadetError(f"{name}: no ground plane, and this build of cadet has no kitti.estimate_plane to find one")
    return estimate(points_velo, calib)


def sample_from_frame(
    frame: Frame, frame_id: str, config: Config, maps: BevMaps, augmentation: Augmentation = UNCHANGED
) -> Sample:
    """Make a sample of a frame.

    Raises:
        CadetError: the frame has no plane and none can be estimated.
    """
    return build_sample(
        frame.points_velo,
        frame.image,
        frame.calib,
        ground_plane(frame.points_velo, frame.calib, frame.plane, f"frame {frame_id}"),
        config,
        maps=maps,
        labels=frame.labels,
        augmentation=augmentation,
        frame_id=frame_id,
    )


class TrainingData(Dataset[Any]):
    """The frames of a folder that hold an object of the classes, shuffled and changed, without end.

    An item is a sample, or the error that reading it raised, so that the error comes whole out of a worker.

    Args:
        root: a KITTI folder.
        split: a list of its `ImageSets`; None for every frame.
        config: the detector and its training.
        seed: of the order and the augmentations.
        maps: makes the bird's-eye view.

    Raises:
        MissingFileError: no folder, split or label file.
        CadetError: no frame holds an object of the classes.
    """

    def __init__(self, root: str | Path, split: str | None, config: Config, seed: int, maps: BevMaps) -> None:
        self.root = Path(root)
        self.config = config
        self._maps = maps
        ids = kitti.Dataset(root, split).ids
        names = set(config.class_names)
        self.ids = tuple(i for i in ids if any(label.type in names for label in kitti.read_labels(root, i)))
        if not self.ids:
            wanted = " or ".join(config.class_names)
            raise CadetError(f"{root}: none of the {len(ids)} frames{_in(split)} holds a {wanted} to learn from")
        self._order = Order(len(self.ids), config.training, seed)

    def __getitem__(self, index: int) -> Sample | CadetError:
        entry = self._order.entry(index)
        frame_id = self.ids[entry.frame]
        try:
            frame = kitti.read_frame(self.root, frame_id)
            return sample_from_frame(frame, frame_id, self.config, self._maps, entry.augmentation)
        except CadetError as error:
            return error


class DetectionData(Dataset[Any]):
    """The frames of a folder in order, unchanged; items as in `TrainingData`.

    Args:
        root: a KITTI folder.
        ids: of the frames.
        config: the detector.
        maps: makes the bird's-eye view.
    """

    def __init__(self, root: str | Path, ids: tuple[str, ...], config: Config, maps: BevMaps) -> None:
        self.root = Path(root)
        self.ids = ids
        self.config = config
        self._maps = maps

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> tuple[Sample, Frame] | CadetError:
        try:
            frame = kitti.read_frame(self.root, self.ids[index])
            return sample_from_frame(frame, self.ids[index], self.config, self._maps), frame
        except CadetError as error:
            return error


def _in(split: str | None) -> str:
    return "" if split is None else f" of the split {split!r}"
