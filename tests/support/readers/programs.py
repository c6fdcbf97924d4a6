"""Programs that read our datasets: how each, by its own functions, counts a set's frames and boxes."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from readers.sequence_converters import scenes_of_123d, sequence_of_ncore
from readers.toolbox_rules import ids_of, read_info

Counts = tuple[int, int | None]
"""Frames and boxes; None where it reads no boxes, or others than those of the labels."""


@dataclass(frozen=True)
class Reader:
    """A program that reads sets of one format."""

    name: str
    distribution: str | None
    """What pip calls it; None if its rules are followed in its place."""
    format: str
    read: Callable[[Path, Path], Counts]
    """Counts in a set's folder, with another one to write into."""


def _num_objects(types: Iterable[str]) -> int:
    return sum(kind != "DontCare" for kind in types)


def _types_of(label_text: str) -> list[str]:
    return [line.split()[0] for line in label_text.splitlines()]


def _pykitti(root: Path, _: Path) -> Counts:
    utils = import_module("pykitti").utils
    scans = sorted((root / "training" / "velodyne").glob("*.bin"))
    for scan in scans:
        utils.load_velo_scan(str(scan))
        utils.read_calib_file(str(root / "training" / "calib" / f"{scan.stem}.txt"))
    return len(scans), None


def _pykitti_raw(root: Path, _: Path) -> Counts:
    num_frames = 0
    for folder in root.glob("2020_*/*_sync"):
        drive = import_module("pykitti").raw(str(root), folder.parent.name, folder.name[-9:-5])
        num_frames += len(list(zip(drive.oxts, drive.cam2, drive.velo, strict=True)))
    return num_frames, None


def _torchvision(root: Path, scratch: Path) -> Counts:
    (scratch / "Kitti").mkdir()
    (scratch / "Kitti" / "raw").symlink_to(root)
    targets = [target for _, target in import_module("torchvision.datasets").Kitti(str(scratch))]
    return len(targets), _num_objects(label["type"] for target in targets for label in target)


def _datumaro(kind: str, root: Path, _: Path) -> Counts:
    dataset = import_module("datumaro").Dataset.import_from(str(root / "training"), kind)
    names = [label.name for label in dataset.categories()[import_module("datumaro").AnnotationType.label]]
    return len(dataset), _num_objects(names[box.label] for item in dataset for box in item.annotations)


def _fiftyone(root: Path, _: Path) -> Counts:
    importer = import_module("fiftyone.utils.kitti").KITTIDetectionDatasetImporter(
        data_path=str(root / "training" / "image_2"), labels_path=str(root / "training" / "label_2")
    )
    with importer:
        samples = [found for *_, found in importer]
    return len(samples), _num_objects(box.label for found in samples for box in found.detections)


def _toolbox_rules(root: Path, _: Path) -> Counts:
    infos = [read_info(root, "training", frame_id) for frame_id in ids_of(root, "trainval")]
    return len(infos), sum(len(info.names) for info in infos)


def _croissant(root: Path, _: Path) -> Counts:
    dataset = import_module("mlcroissant").Dataset(jsonld=str(root / "croissant.json"))
    types = [row["labels/type"].decode() for row in dataset.records("labels")]
    return len(list(dataset.records("frames"))), _num_objects(types)


def _pycocotools(root: Path, _: Path) -> Counts:
    sets = [import_module("pycocotools.coco").COCO(str(path)) for path in root.glob("annotations/*.json")]
    return sum(len(one.getImgIds()) for one in sets), sum(len(one.getAnnIds(iscrowd=False)) for one in sets)


def _trackeval(root: Path, scratch: Path) -> Counts:
    """The truth is a tracker's results too, as it wants some."""
    shutil.copytree(root / "training" / "label_02", scratch / "truth" / "data")
    places = {"GT_FOLDER": str(root / "training"), "TRACKERS_FOLDER": str(scratch), "PRINT_CONFIG": False}
    dataset = import_module("trackeval").datasets.Kitti2DBox(places)
    sequences = [dataset.get_raw_seq_data("truth", name) for name in dataset.seq_list]
    boxes = [len(boxes) for sequence in sequences for boxes in sequence["gt_dets"]]
    return len(boxes), sum(boxes)


def _nuscenes(root: Path, _: Path) -> Counts:
    tables = import_module("nuscenes.nuscenes").NuScenes("v1.0-trainval", str(root), verbose=False)
    read = import_module("nuscenes.utils.data_classes").LidarPointCloud.from_file
    num_boxes = 0
    for sample in tables.sample:
        path, boxes, _camera = tables.get_sample_data(sample["data"]["LIDAR_TOP"])
        read(path)
        num_boxes += len(boxes)
    return len(tables.sample), num_boxes


def _123d(root: Path, scratch: Path) -> Counts:
    scenes = scenes_of_123d(root, scratch, "nuscenes_train", "nuscenes_val")
    frames = [(scene, index) for scene in scenes for index in range(scene.number_of_iterations)]
    return len(frames), sum(len(scene.get_box_detections_se3_at_iteration(index)) for scene, index in frames)


def _ncore(root: Path, scratch: Path) -> Counts:
    """Its boxes are the tracklets', which go on where an object has no label."""
    drives = [sequence_of_ncore(drive, scratch, os.environ["NCORE_CLONE"]) for drive in root.glob("2020_*/*_sync")]
    return sum(drive.get_lidar_sensor("lidar_top").frames_count for drive in drives), None


def _webdataset(root: Path, _: Path) -> Counts:
    shards = [str(path) for path in sorted(root.glob("*/*.tar"))]
    samples = list(import_module("webdataset").WebDataset(shards, shardshuffle=False))
    return len(samples), _num_objects(kind for one in samples for kind in _types_of(one["label_2.txt"].decode()))


def _datasets(types_of: Callable[[Any], list[str]], root: Path, scratch: Path) -> Counts:
    splits = import_module("datasets").load_dataset(str(root), cache_dir=str(scratch))
    rows = [row for split in splits.values() for row in split]
    return len(rows), _num_objects(kind for row in rows for kind in types_of(row))


def _mcap(root: Path, _: Path) -> Counts:
    num_frames = 0
    for bag in root.glob("*/*.mcap"):
        with bag.open("rb") as file:
            reader = import_module("mcap.reader").make_reader(file, validate_crcs=True)
            num_frames += sum(channel.topic == "/objects" for _, channel, _ in reader.iter_messages())
    return num_frames, None


def _rosbags(root: Path, _: Path) -> Counts:
    counts = []
    for bag in root.glob("*/*.mcap"):
        with import_module("rosbags.highlevel").AnyReader([bag]) as reader:
            for connection, _time_ns, data in reader.messages():
                message = reader.deserialize(data, connection.msgtype)
                counts += [len(message.detections)] if connection.topic == "/objects" else []
    return len(counts), sum(counts)


READERS: Final = (
    Reader("OpenPCDet, MMDetection3D", None, "kitti", _toolbox_rules),
    Reader("torchvision", "torchvision", "kitti", _torchvision),
    Reader("pykitti", "pykitti", "kitti", _pykitti),
    Reader("datumaro, kitti3d", "datumaro", "kitti", partial(_datumaro, "kitti3d")),
    Reader("datumaro, kitti_detection", "datumaro", "kitti", partial(_datumaro, "kitti_detection")),
    Reader("FiftyOne's importer", "fiftyone", "kitti", _fiftyone),
    Reader("mlcroissant", "mlcroissant", "kitti", _croissant),
    Reader("pycocotools", "pycocotools", "coco", _pycocotools),
    Reader("webdataset", "webdataset", "webdataset", _webdataset),
    Reader("datasets", "datasets", "webdataset", partial(_datasets, lambda row: _types_of(row["label_2.txt"]))),
    Reader(
        "datasets, Parquet", "datasets", "parquet", partial(_datasets, lambda row: [o["type"] for o in row["labels"]])
    ),
    Reader("TrackEval", "trackeval", "kitti_tracking", _trackeval),
    Reader("pykitti, raw", "pykitti", "kitti_raw", _pykitti_raw),
    Reader("nuscenes-devkit", "nuscenes-devkit", "nuscenes", _nuscenes),
    Reader("123D", "py123d", "nuscenes", _123d),
    Reader("mcap", "mcap", "mcap", _mcap),
    Reader("rosbags", "rosbags", "mcap", _rosbags),
    *([Reader("NCore", "nvidia-ncore", "kitti_raw", _ncore)] if os.environ.get("NCORE_CLONE") else []),
)
