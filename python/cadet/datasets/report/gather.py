"""What a report says of a dataset, gathered from its label files, scans, records, and manifest."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from cadet._util.plain_text import json_from_text
from cadet._util.process_map import process_map
from cadet.datasets.report.statistics import Statistics
from cadet.errors import CadetError, FileFormatError, MissingFileError
from cadet.formats.kitti import boxes_cam_from_labels, read_calib, read_image_set, read_labels, read_meta
from cadet.formats.kitti.boxes import points_in_boxes
from cadet.formats.kitti.files.folder import display_name, file_path, frame_ids, sample_folder, set_root, testing_folder
from cadet.formats.kitti.files.unreadable import READING_ERRORS, Unreadable
from cadet.formats.kitti.files.velodyne import points_from_bytes
from cadet.formats.kitti.image_sets import list_paths

RECORDED: Final = ("weather", "district", "map", "rig")
"""What the records of generated frames say in one word."""
_MANIFEST: Final = "manifest.json"
_SPLITS: Final = ("train", "val", "test")


@dataclass
class Facts:
    """Everything that the figures and tables are made from.

    Attributes:
        name: the folder's.
        statistics: of the labels.
        recorded: number of frames by value, by name of `RECORDED`; empty for what no record says.
        expected: share of the frames that the manifest's policy draws, by value, for "weather" and "district".
        num_episodes: episodes that the records name.
        splits: number of frames by list of `ImageSets`.
        num_unlabeled: frames without a label file, as KITTI's test frames are.
        num_unreadable: labeled frames that cannot be read, which count nothing.
        num_points: returns of all scans of labeled frames.
        made_with: seed, policy, and version out of the manifest, as text by name.
    """

    name: str
    statistics: Statistics = field(default_factory=Statistics)
    recorded: dict[str, Counter[str]] = field(default_factory=dict)
    expected: dict[str, dict[str, float]] = field(default_factory=dict)
    num_episodes: int = 0
    splits: dict[str, int] = field(default_factory=dict)
    num_unlabeled: int = 0
    num_unreadable: int = 0
    num_points: int = 0
    made_with: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class _FrameFacts:
    statistics: Statistics
    recorded: dict[str, str]
    episode: object
    num_points: int


def gather(root: str | Path, *, workers: int = 1) -> Facts:
    """Read a dataset's numbers.

    Args:
        root: the folder that holds `training`; frames of `testing` count where they have labels.
        workers: processes that read frames; they change nothing in the result.

    Raises:
        MissingFileError: no KITTI folder, or one without a label file.
        CadetError: more than half of the frames cannot be read.
    """
    folder, root = sample_folder(root), set_root(root)
    facts = Facts(root.resolve().name)
    tasks: list[tuple[Path, str]] = []
    for part in (folder, testing_folder(root)):
        if part is not None:
            ids = frame_ids(part)
            labeled = [one for one in ids if file_path(part, "label_2", one).is_file()]
            facts.num_unlabeled += len(ids) - len(labeled)
            tasks += [(part, one) for one in labeled]
    if not tasks:
        raise MissingFileError(f"{root}: no label files, and so nothing to report")
    episodes: set[object] = set()
    unreadable = Unreadable(root)
    for (_, frame_id), found in zip(tasks, process_map(_read_frame, tasks, workers=workers), strict=True):
        if not isinstance(found, _FrameFacts):
            unreadable.add(frame_id, found)
            continue
        facts.statistics.merge(found.statistics)
        facts.num_points += found.num_points
        episodes |= {found.episode} - {None}
        for name, value in found.recorded.items():
            facts.recorded.setdefault(name, Counter())[value] += 1
    unreadable.say(len(tasks))
    facts.num_unreadable = len(unreadable)
    facts.num_episodes = len(episodes)
    facts.splits = {split: len(read_image_set(root, split)) for split in _SPLITS if split in list_paths(root)}
    _read_manifest(root, facts)
    return facts


def _read_frame(task: tuple[Path, str]) -> _FrameFacts | CadetError | OSError:
    try:
        return _facts_of(*task)
    except READING_ERRORS as error:
        return error


def _facts_of(folder: Path, frame_id: str) -> _FrameFacts:
    labels = read_labels(folder, frame_id)
    objects = [label for label in labels if not label.is_dont_care]
    path = file_path(folder, "velodyne", frame_id)
    points_velo = points_from_bytes(path.read_bytes(), display_name(path)) if path.is_file() else None
    num_in_boxes = None
    if points_velo is not None:
        num_in_boxes = [0] * len(objects)
        if objects:
            points_cam = read_calib(folder, frame_id).points_cam_from_velo(points_velo)
            num_in_boxes = points_in_boxes(points_cam, boxes_cam_from_labels(objects)).sum(axis=0).tolist()
    statistics = Statistics()
    statistics.add(labels, num_in_boxes)
    meta = read_meta(folder, frame_id) or {}
    recorded = {name: value for name in RECORDED if isinstance(value := meta.get(name), str)}
    episode = meta.get("episode")
    return _FrameFacts(
        statistics,
        recorded,
        episode if isinstance(episode, int) else None,
        0 if points_velo is None else len(points_velo),
    )


def _read_manifest(root: Path, facts: Facts) -> None:
    path = root / _MANIFEST
    if not path.is_file():
        return
    manifest = json_from_text(path.read_bytes(), _MANIFEST)
    if not isinstance(manifest, dict):
        raise FileFormatError("expected a JSON object", _MANIFEST)
    policy = manifest.get("policy")
    policy = policy if isinstance(policy, dict) else {}
    rig = manifest.get("rig")
    made_with = {
        "seed": manifest.get("seed"),
        "policy": policy.get("name"),
        "LIDAR": rig.get("lidar") if isinstance(rig, dict) else None,
        "cadet": manifest.get("cadet"),
    }
    facts.made_with = {name: str(value) for name, value in made_with.items() if isinstance(value, str | int)}
    weathers, districts = policy.get("weathers"), policy.get("districts")
    if isinstance(weathers, dict):
        _expect(facts, "weather", weathers)
    if isinstance(districts, list) and all(isinstance(one, dict) for one in districts):
        _expect(facts, "district", {str(one.get("name")): one.get("weight") for one in districts})


def _expect(facts: Facts, name: str, weights: dict[str, Any]) -> None:
    numbers = {key: float(weight) for key, weight in weights.items() if isinstance(weight, int | float)}
    total = float(np.sum(list(numbers.values())))
    if total > 0.0:
        facts.expected[name] = {key: weight / total for key, weight in numbers.items()}
