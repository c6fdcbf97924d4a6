"""The raw data's folder: a day and a drive for each episode, as the development kit and pykitti read it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import date, timedelta
from typing import Final

from cadet._util.sink import Sink
from cadet.formats.exporter import Ending, Place
from cadet.formats.kitti_sequences.oxts import DATA_FORMAT, oxts_lines
from cadet.formats.kitti_sequences.raw_calibration import calibration_files
from cadet.formats.kitti_sequences.record import SPAN_S, Record, calibration_of_record, drives, path_of_record
from cadet.formats.kitti_sequences.sequence_exporter import IMAGE, SCAN, SequenceExporter, lists_of_drives
from cadet.formats.kitti_sequences.tracklets import text_of_tracklets, tracklets_of
from cadet.sensors.rig import GRAY_CAMERAS, RIGHT_CAMERA

_FIRST_DAY: Final = date(2020, 1, 1)
_MONTHS: Final = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_IMAGES: Final = {
    IMAGE: "image_02",
    RIGHT_CAMERA: "image_03",
    **dict(zip(GRAY_CAMERAS, ("image_00", "image_01"), strict=True)),
}
_FILES: Final = {kind: (folder, "png") for kind, folder in _IMAGES.items()} | {SCAN: ("velodyne_points", "bin")}
_NS_PER_S: Final = 1_000_000_000
_SECONDS_OF_NOON: Final = 43_200


class KittiRawExporter(SequenceExporter):
    """KITTI's raw data, synchronized and rectified. Each episode is a day with a calibration and a drive of its own."""

    name = "kitti_raw"
    extras: tuple[str, ...] = (RIGHT_CAMERA, *GRAY_CAMERAS)

    def path(self, place: Place, kind: str) -> str:
        """Return a file's name, such as `DAY/DAY_drive_0003_sync/image_02/data/0000000012.png`, or the record's."""
        if kind == "record":
            return path_of_record(place)
        folder, suffix = _FILES[kind]
        return f"{_drive(place)}/{folder}/data/{place.sample:010d}.{suffix}"

    def finish(self, sink: Sink, places: Iterable[Place]) -> Ending:
        """Return calibration, times, oxts, and tracklets of each drive, and the lists of drives."""
        files: dict[str, bytes] = {}
        types: Counter[str] = Counter()
        splits: dict[str, list[str]] = {"train": [], "val": [], "test": []}
        for found, records in drives(sink, places):
            first = found[0]
            splits[first.split].append(_drive(first))
            day, width_height = _day(first), records[0]["image_size"]
            written = f"{day.day:02d}-{_MONTHS[day.month - 1]}-{day.year}"
            calib = calibration_files(calibration_of_record(records[0]), (width_height[0], width_height[1]), written)
            texts = {f"{_folder(day)}/{name}": text for name, text in calib.items()}
            texts_of_drive = _drive_texts(records, day)
            for kind, folder in _IMAGES.items():
                # kitti2bag looks for it beside the images of each camera.
                if kind in records[0]["sha256"]:
                    texts_of_drive[f"{folder}/timestamps.txt"] = texts_of_drive["image_02/timestamps.txt"]
            texts |= {f"{_drive(first)}/{name}": text for name, text in texts_of_drive.items()}
            files |= {name: text.encode("ascii") for name, text in texts.items()}
            types.update(seen["type"] for record in records for seen in record["objects"] if seen["is_labeled"])
        return Ending(files | lists_of_drives(splits), types)


def _drive_texts(records: Sequence[Record], day: date) -> dict[str, str]:
    def times(late_s: Iterable[float]) -> str:
        return "".join(f"{_time(record['time_s'] + s, day)}\n" for record, s in zip(records, late_s, strict=True))

    texts = {f"oxts/data/{index:010d}.txt": f"{line}\n" for index, line in enumerate(oxts_lines(records))}
    texts["oxts/dataformat.txt"] = DATA_FORMAT
    # All sensors see the same instant; a turning scan looks forward then.
    for name in ("image_02", "oxts", "velodyne_points"):
        texts[f"{name}/timestamps.txt"] = times([0.0] * len(records))
    begin_s, end_s = zip(*(record.get(SPAN_S, (0.0, 0.0)) for record in records), strict=True)
    texts["velodyne_points/timestamps_start.txt"] = times(begin_s)
    texts["velodyne_points/timestamps_end.txt"] = times(end_s)
    texts["tracklet_labels.xml"] = text_of_tracklets(tracklets_of(records))
    return texts


def _time(time_s: float, day: date) -> str:
    nanoseconds = round(time_s * _NS_PER_S)
    seconds, fraction = divmod(nanoseconds, _NS_PER_S)
    days, seconds = divmod(seconds + _SECONDS_OF_NOON, 86_400)
    now = day + timedelta(days=days)
    return f"{now.isoformat()} {seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}.{fraction:09d}"


def _day(place: Place) -> date:
    return _FIRST_DAY + timedelta(days=place.episode)


def _folder(day: date) -> str:
    return f"{day.year:04d}_{day.month:02d}_{day.day:02d}"


def _drive(place: Place) -> str:
    folder = _folder(_day(place))
    return f"{folder}/{folder}_drive_{place.episode:04d}_sync"
