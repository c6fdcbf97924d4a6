"""The lint of what is no frame: lists, folders, files without a frame."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Final

from cadet.errors import KittiFormatError
from cadet.formats.kitti.files.dialects import Dialect, collected
from cadet.formats.kitti.files.folder import REQUIRED, found_path, ids_among, kinds_in
from cadet.formats.kitti.image_sets import LISTS, ImageSet, list_name, list_paths, read_list
from cadet.formats.kitti.lint.finding import Finding, Severity

_NEEDED_LISTS: Final = ("train", "val", "test")


def lint_folders(folder: Path, ids: Collection[str], display: Callable[[Path], str]) -> Iterator[Finding]:
    """Find folders that cannot be listed, and files that belong to no frame.

    Args:
        folder: the folder that holds `calib` and its fellows.
        ids: the frames that are there.
        display: names a file in messages.
    """
    for kind in kinds_in(folder):
        try:
            names = sorted(os.listdir(folder / kind))  # noqa: PTH208 - listing alone, no entry is opened
        except FileNotFoundError:
            continue
        except OSError as error:
            yield unreadable(display(folder / kind), error)
            continue
        for name in names:
            path = folder / kind / name
            frame_id = next(iter(ids_among([name], kind)), None)
            # Tools leave notes of their own among images and scans; what looks like a frame's file is one too few.
            if frame_id in ids and (read := found_path(folder, kind, path.stem)) != path:
                yield Finding(display(path), None, "stray-file", f"not read, since {read.name} is there", "warning")
            elif frame_id not in ids and not (frame_id is None and kind in REQUIRED):
                yield Finding(display(path), None, "stray-file", "belongs to no frame", "warning")


def lint_lists(
    sets: Mapping[str, ImageSet],
    root: Path,
    training: Collection[str],
    testing: Collection[str],
    *,
    strict: bool,
    generated: bool,
) -> list[Finding]:
    """Check that the lists that others read are there, name frames that are there, and name none twice.

    Args:
        sets: the lists, by split.
        root: the folder that holds `ImageSets`.
        training: ids of the frames under `training`.
        testing: ids of the frames under `testing`.
        strict: errors instead of warnings.
        generated: the lists that other programs read must be there, and no frame may be in `test` and another list;
            KITTI itself brings no lists, and numbers its test frames anew.
    """
    soft: Severity = "error" if strict else "warning"
    findings = []
    for split in _NEEDED_LISTS:
        if generated and not os.path.lexists(root / "ImageSets" / f"{split}.txt"):
            message = "missing: OpenPCDet and MMDetection3D stop without it; an empty list will do"
            findings.append(Finding(f"ImageSets/{split}.txt", None, "image-set", message))
    for split, image_set in sets.items():
        present, where = (testing, "testing") if split == "test" else (training, "training")
        absent = [frame_id for frame_id in image_set if frame_id not in present]
        if absent:
            message = f"{len(absent)} of {len(image_set)} ids have no frame in {where}, the first is {absent[0]}"
            line = image_set.ids.index(absent[0]) + 1
            findings.append(Finding(f"ImageSets/{split}.txt", line, "image-set", message, soft))
    return findings + _lint_overlaps(sets, soft, generated=generated)


def lint_episodes(sets: Mapping[str, ImageSet], episodes: Mapping[str, tuple[object, object]]) -> list[Finding]:
    """Find episodes that have frames in two splits: what the one trains on, the other has seen from 10 m farther.

    Args:
        sets: the lists, by split.
        episodes: of the frames whose `meta` names one, by id: its seed and number.
    """
    findings = []
    pairs = (("train", "val"), ("train", "test"), ("val", "test"))
    for one, other in pairs:
        members = set(sets.get(one, ()))
        firsts = {
            episodes[frame_id]: frame_id
            for frame_id in reversed(sets.get(one, ImageSet(())).ids)
            if frame_id in episodes
        }
        said = set()
        for line, frame_id in enumerate(sets.get(other, ()), start=1):
            episode = episodes.get(frame_id)
            # A frame in both lists has been found already.
            if episode in firsts and episode not in said and frame_id not in members:
                said.add(episode)
                message = f"{frame_id} is of episode {episode[1]}, of which {firsts[episode]} is in {one}"
                findings.append(Finding(f"ImageSets/{other}.txt", line, "episode-overlap", message))
    return findings


def read_lists(root: Path, soft: Severity) -> tuple[dict[str, ImageSet], list[Finding]]:
    """Read every list of a dataset by its split, and say which cannot be read and which are written otherwise."""
    sets: dict[str, ImageSet] = {}
    findings: list[Finding] = []
    try:
        paths = list_paths(root)
    except OSError as error:
        return sets, [unreadable(LISTS, error)]
    with collected() as dialects:
        for split, path in paths.items():
            shown = printable(list_name(path))
            try:
                sets[split] = read_list(path)
            except KittiFormatError as error:
                findings.append(Finding(shown, error.line, "image-set", error.reason))
            except OSError as error:
                findings.append(unreadable(shown, error))
    return sets, findings + findings_of(dialects, soft)


def findings_of(dialects: Iterable[Dialect], soft: Severity) -> list[Finding]:
    """Return what was read though KITTI writes it otherwise, each once: files are read more than once."""
    return [Finding(one.file, one.line, "dialect", one.message, soft) for one in dict.fromkeys(dialects)]


def _lint_overlaps(sets: Mapping[str, ImageSet], soft: Severity, *, generated: bool) -> list[Finding]:
    findings = []
    pairs = [("train", "val"), *([("train", "test"), ("val", "test")] if generated else [])]
    for one, other in pairs:
        members = set(sets.get(one, ()))
        for line, frame_id in enumerate(sets.get(other, ()), start=1):
            if frame_id in members:
                findings.append(
                    Finding(f"ImageSets/{other}.txt", line, "split-overlap", f"{frame_id} is in {one}, too")
                )
    if {"train", "val", "trainval"} <= set(sets) and set(sets["trainval"]) != {*sets["train"], *sets["val"]}:
        findings.append(Finding("ImageSets/trainval.txt", None, "image-set", "is not train and val together", soft))
    return findings


def printable(name: str) -> str:
    """Return a file's name as it can be printed: what is no character is escaped."""
    return name if name.isprintable() else ascii(name)[1:-1]


def unreadable(file: str, error: OSError) -> Finding:
    """Say that the system does not let read a file."""
    return Finding(file, None, "unreadable-file", f"cannot be read: {error.strerror or error}")


def is_number(value: object) -> bool:
    """Tell whether a value out of a JSON file is a number that arithmetic can take."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max
