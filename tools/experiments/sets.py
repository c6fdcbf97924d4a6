"""The sets of frames that the experiments learn from and are tested on."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from cadet import kitti
from cadet.errors import CadetError
from cadet.formats.kitti import text_from_labels
from cadet.formats.kitti.image_sets import check_not_empty
from cadet.formats.webdataset.dataset import is_shard_folder
from tools.experiments.cells import Cell

TRAIN: Final = "train"
VAL: Final = "val"


@dataclass(frozen=True)
class FrameSet:
    """A KITTI folder with the lists `train` and `val`.

    Attributes:
        folder: of the frames.
        num_train: frames in `train`.
        num_val: frames in `val`.
        crc32: of ids and labels of both lists: sets of equal ids differ in their labels.
        objects: how many of each type the frames of each list hold.
    """

    folder: Path
    num_train: int
    num_val: int
    crc32: int
    objects: Mapping[str, tuple[Counter[str], ...]] = field(repr=False)

    @classmethod
    def read(cls, folder: Path) -> FrameSet:
        """Read the lists and all labels.

        Raises:
            MissingFileError: no folder, list, frame, or label file.
            CadetError: a folder of shards.
        """
        if is_shard_folder(folder):
            raise CadetError(f"{folder}: shards: the experiments are tested on frames of a KITTI folder")
        objects: dict[str, tuple[Counter[str], ...]] = {}
        checksum = 0
        for split in (TRAIN, VAL):
            frames = kitti.Dataset(folder, split)
            check_not_empty(frames.ids, folder, split)
            labels = {frame_id: frames.read_labels(frame_id) for frame_id in frames.ids}
            objects[split] = tuple(Counter(label.type for label in found) for found in labels.values())
            for frame_id, found in labels.items():
                checksum = zlib.crc32(f"{split} {frame_id}\n{text_from_labels(found)}".encode(), checksum)
        return cls(folder, len(objects[TRAIN]), len(objects[VAL]), checksum, objects)

    @property
    def val_ids(self) -> tuple[str, ...]:
        """The frames to test on."""
        return kitti.Dataset(self.folder, VAL).ids

    def describe(self) -> dict[str, Any]:
        """Return what tells the set from others, as plain values: not where it lies."""
        return {"num_train": self.num_train, "num_val": self.num_val, "crc32": self.crc32}


Sets = Mapping[str, FrameSet]
"""By name: "real" and "sim"."""


def check_sets(cells: Iterable[Cell], sets: Sets) -> None:
    """Find out before the first cell is run that the sets lack what one of the last needs.

    Raises:
        CadetError: too few frames to learn from, or no object to find in a test; folder and cell are named.
    """
    for cell in cells:
        for tested in cell.tests:
            if not any(counts[cell.class_name] for counts in sets[tested].objects[VAL]):
                folder = sets[tested].folder
                raise CadetError(f"{folder}: its {VAL} frames hold no {cell.class_name} for {cell.name} to find")
        if cell.stops:
            frames, least = sets[cell.data[-1]], cell.config.training.min_objects
            count = sum(counts[cell.class_name] >= least for counts in frames.objects[TRAIN])
            if count < (cell.frames or 1):
                what = cell.class_name if least == 1 else f"{least} of {cell.class_name}"
                raise CadetError(
                    f"{frames.folder}: {count} of its {TRAIN} frames hold {what} or more, "
                    f"and {cell.name} learns from {cell.frames or 1}"
                )
