"""The tracking benchmark's folder: a sequence for each episode, with one label file and one oxts file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, Final

from cadet._util.sink import Sink
from cadet.formats.exporter import Ending, Place
from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.files.numbers import scientific_text
from cadet.formats.kitti_sequences.oxts import oxts_lines
from cadet.formats.kitti_sequences.record import Record, calibration_of_record, drives, path_of_record
from cadet.formats.kitti_sequences.sequence_exporter import IMAGE, SCAN, SequenceExporter, lists_of_drives
from cadet.sensors.rig import RIGHT_CAMERA

_FILES: Final = {IMAGE: ("image_02", "png"), RIGHT_CAMERA: ("image_03", "png"), SCAN: ("velodyne", "bin")}
_KEYS: Final = {"R0_rect": "R_rect", "Tr_velo_to_cam": "Tr_velo_cam", "Tr_imu_to_velo": "Tr_imu_velo"}
"""Names that differ from the object benchmark's. They have no colon in KITTI's files."""
_TYPES: Final = {"Person_sitting": "Person"}
"""Names of types that differ from the object benchmark's in KITTI's files, if not in its description."""
_SLIGHT_TRUNCATION: Final = 0.15
_TRUNCATION: Final = 0.5
"""The object benchmark's limits for "easy" and "hard": whole up to one, largely truncated beyond the other."""


class KittiTrackingExporter(SequenceExporter):
    """KITTI's tracking benchmark."""

    name = "kitti_tracking"

    def path(self, place: Place, kind: str) -> str:
        """Return a file's name, such as `training/image_02/0003/000012.png`, or that of the record."""
        if kind == "record":
            return path_of_record(place)
        folder, suffix = _FILES[kind]
        return f"{_part(place)}/{folder}/{_sequence(place)}/{place.sample:06d}.{suffix}"

    def finish(self, sink: Sink, places: Iterable[Place]) -> Ending:
        """Return labels, calibration, and oxts of each sequence, and the lists of sequences."""
        files: dict[str, bytes] = {}
        types: Counter[str] = Counter()
        splits: dict[str, list[str]] = {"train": [], "val": [], "test": []}
        lengths: dict[str, list[str]] = {"training": [], "testing": []}
        for found, records in drives(sink, places):
            part, sequence = _part(found[0]), _sequence(found[0])
            splits[found[0].split].append(sequence)
            # As the benchmark's own evaluation reads it: the last number is one past the last frame.
            lengths[part].append(f"{sequence} empty 000000 {len(records):06d}")
            files[f"{part}/calib/{sequence}.txt"] = _calibration(calibration_of_record(records[0]))
            files[f"{part}/oxts/{sequence}.txt"] = _text(oxts_lines(records))
            files[f"{part}/label_02/{sequence}.txt"] = _text(
                label_line(frame, seen) for frame, record in enumerate(records) for seen in record["objects"]
            )
            types.update(_type(seen) for record in records for seen in record["objects"])
        for part, lines in lengths.items():
            files[f"{part}/evaluate_tracking.seqmap.{part}"] = _text(lines)
        return Ending(files | lists_of_drives(splits), types)


def label_line(frame: int, seen: Record) -> str:
    """Return a line of a tracking label: frame, track, and the object's 15 fields with six decimals.

    The track is the agent's id, -1 for a DontCare region. Truncation is 0, 1, or 2.
    """
    left, top, right, bottom = seen["bbox"]
    if not seen["is_labeled"]:
        box: Sequence[float] = (-10.0, left, top, right, bottom, -1.0, -1.0, -1.0, -1000.0, -1000.0, -1000.0, -10.0)
        return f"{frame} -1 DontCare -1 -1 {_decimals(box)}"
    length, width, height = seen["size_lwh"]
    alpha, place, heading = seen["observation_angle"], seen["location_cam"], seen["rotation_y"]
    box = (alpha, left, top, right, bottom, height, width, length, *place, heading)
    kind, level = _type(seen), _truncation_level(seen["truncation"])
    return f"{frame} {seen['id']} {kind} {level} {seen['occlusion_level']} {_decimals(box)}"


def _truncation_level(truncation: float) -> int:
    return (truncation > _SLIGHT_TRUNCATION) + (truncation > _TRUNCATION)


def _type(seen: Record) -> str:
    kind: str = seen["type"]
    return _TYPES.get(kind, kind) if seen["is_labeled"] else "DontCare"


def _calibration(calib: Calibration) -> bytes:
    matrices: dict[str, Any] = {f"P{index}:": getattr(calib, f"P{index}") for index in range(4)}
    matrices |= {short: getattr(calib, key) for key, short in _KEYS.items()}
    return _text(f"{key} {' '.join(scientific_text(x) for x in matrix.flat)}" for key, matrix in matrices.items())


def _part(place: Place) -> str:
    return "testing" if place.split == "test" else "training"


def _sequence(place: Place) -> str:
    return f"{place.episode:04d}"


def _decimals(values: Iterable[float]) -> str:
    return " ".join(f"{value:.6f}" for value in values)


def _text(lines: Iterable[str]) -> bytes:
    return "".join(f"{line}\n" for line in lines).encode("ascii")
