"""What KITTI's formats of sequences have in common: images, scans, and a record for each sample."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet._util.sink import Sink
from cadet.errors import CadetError
from cadet.formats.exporter import Ending, FilesInPlace, Place
from cadet.formats.kitti.files.images import encode_png
from cadet.formats.kitti.files.velodyne import bytes_from_points
from cadet.formats.kitti.from_sample import calibration_of, move_off_zero_depth
from cadet.formats.kitti_sequences.record import RECORDS, record_bytes, record_of
from cadet.sensors.rig import GRAY_CAMERAS, RIGHT_CAMERA, Rig
from cadet.sensors.sample import Sample, Wanted

IMAGE = "image_2"
SCAN = "velodyne"
_RECORD_NAME = re.compile(r"[0-9]{6}\.json")


class SequenceExporter(FilesInPlace):
    """All but the names of files and the files that a drive ends with; see `cadet.formats.exporter.Exporter`."""

    name: str
    extras: tuple[str, ...] = (RIGHT_CAMERA,)
    base: tuple[str, ...] = (IMAGE, SCAN)
    needs_sequence = True

    def check(self, rig: Rig, extras: tuple[str, ...]) -> None:
        """Refuse lenses for which rectified images have no room, and images of cameras that a rig does not have."""
        if any(rig.camera.distortion):
            raise CadetError(f"cannot write images of the rig {rig.name}: {self.name} has no distortion")
        for extra in extras:
            if extra not in rig.camera_names:
                kind = "right color" if extra == RIGHT_CAMERA else "gray"
                raise CadetError(f"cannot write {extra}: the rig {rig.name} has no {kind} camera")

    def wanted(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> Wanted:
        """Return the cameras whose images are to be written besides the left color camera's."""
        sensors = tuple(extra for extra in self.extras if extra in extras)
        return Wanted(sensors=sensors, maps=False, labels=False)

    def kinds(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> tuple[str, ...]:
        """Return the kinds of files."""
        return self.base + tuple(extra for extra in self.extras if extra in extras)

    def path(self, place: Place, kind: str) -> str:
        """Return a file's name."""
        raise NotImplementedError

    def encode(self, sample: Sample, extras: tuple[str, ...]) -> dict[str, bytes]:
        """Return the images and the scan."""
        points_velo = move_off_zero_depth(sample.scan().points_velo, calibration_of(sample.rig))
        files = {IMAGE: sample.png(), SCAN: bytes_from_points(points_velo)}
        for extra in self.kinds((), extras)[len(self.base) :]:
            files[extra] = _gray_png(sample.image(extra)) if extra in GRAY_CAMERAS else sample.png(extra)
        return files

    def record(self, sample: Sample) -> dict[str, Any]:
        """Return what the text files of the drive are made of."""
        return record_of(sample)

    def record_bytes(self, record: Mapping[str, Any]) -> bytes:
        """Return the record as JSON."""
        return record_bytes(record)

    def written(self, sink: Sink) -> list[int]:
        """Return the numbers of the samples that have a record."""
        return [int(name[:6]) for name in sink.names(RECORDS) if _RECORD_NAME.fullmatch(name)]

    def finish(self, sink: Sink, places: Iterable[Place]) -> Ending:
        """Return the text files of all drives."""
        raise NotImplementedError


def _gray_png(image: NDArray[np.uint8]) -> bytes:
    """Encode the luma of an (H, W, 3) RGB image."""
    red, green, blue = (image[..., channel].astype(np.uint32) for channel in range(3))
    # BT.601 in whole numbers: the same on every processor.
    return encode_png(((299 * red + 587 * green + 114 * blue + 500) // 1000).astype(np.uint8))


def lists_of_drives(drives: Mapping[str, list[str]]) -> dict[str, bytes]:
    """Return `ImageSets` with the drives of each split.

    Args:
        drives: names by split, "train", "val", and "test".
    """
    sets = {**drives, "trainval": sorted([*drives["train"], *drives["val"]])}
    return {
        f"ImageSets/{split}.txt": "".join(f"{name}\n" for name in names).encode("ascii")
        for split, names in sets.items()
    }
