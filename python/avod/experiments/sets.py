"""The sets of frames that the experiments learn from and are tested on."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from cadet import kitti
from cadet.errors import CadetError
from cadet.kitti import text_from_labels
from cadet.kitti.image_sets import check_not_empty
from cadet.webdataset.dataset import is_shard_folder

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
    """

    folder: Path
    num_train: int
    num_val: int
    crc32: int

    @classmethod
    def read(cls, folder: Path) -> FrameSet:
        """Read the lists and all labels.

        Raises:
            MissingFileError: no folder, list, frame, or label file.
            CadetError: a folder of shards.
        """
        if is_shard_folder(folder):
            raise CadetError(f"{folder}: shards: the experiments are tested on frames of a KITTI folder")
        counts: dict[str, int] = {}
        checksum = 0
        for split in (TRAIN, VAL):
            frames = kitti.Dataset(folder, split)
            check_not_empty(frames.ids, folder, split)
            counts[split] = len(frames.ids)
            for frame_id in frames.ids:
                text = f"{split} {frame_id}\n{text_from_labels(frames.read_labels(frame_id))}"
                checksum = zlib.crc32(text.encode(), checksum)
        return cls(folder, counts[TRAIN], counts[VAL], checksum)

    @property
    def val_ids(self) -> tuple[str, ...]:
        """The frames to test on."""
        return kitti.Dataset(self.folder, VAL).ids

    def describe(self) -> dict[str, Any]:
        """Return what tells the set from others, as plain values: not where it lies."""
        return {name: value for name, value in asdict(self).items() if name != "folder"}


Sets = Mapping[str, FrameSet]
"""By name: "real" and "sim"."""
