"""Datasets from one format to another, byte for byte: KITTI's folder and tar shards hold the same files. And scans."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Final

from cadet._util.checks import as_path, check_number, is_one_of, known_names, shown
from cadet._util.sink import LocalSink
from cadet.errors import CadetError, MissingFileError
from cadet.formats.coco import put_coco
from cadet.formats.kitti.files.folder import (
    REQUIRED,
    file_path,
    found_path,
    frame_ids,
    kinds_in,
    sample_folder,
    set_root,
    testing_folder,
)
from cadet.formats.kitti.files.other_layouts import no_frames
from cadet.formats.kitti.files.point_labels import point_times_from_bytes
from cadet.formats.kitti.frame_files import FolderFiles, FrameFiles
from cadet.formats.kitti.image_sets import LISTS, ImageSet, list_bytes, list_paths, read_image_set
from cadet.formats.point_files import POINT_FILES, columns_of_points
from cadet.formats.scan_files.read import scan_from_data
from cadet.formats.webdataset import ShardDataset
from cadet.formats.webdataset.dataset import expand_pattern, is_pattern, is_shard_folder
from cadet.formats.webdataset.dataset_card import CARD
from cadet.formats.webdataset.exporter import SHARD_SIZE
from cadet.formats.webdataset.index import SUFFIX, text_from_index
from cadet.formats.webdataset.member import Member
from cadet.formats.webdataset.member_names import member_name
from cadet.formats.webdataset.tar_writing import archive_chunks

FORMATS: Final = ("kitti", "webdataset", "coco", *POINT_FILES)
"""What can be converted to: sets byte for byte, images with COCO's annotations, and scans in other formats."""
UNLISTED: Final = "unlisted"
"""The split of frames that neither `train.txt` nor `val.txt` names, where there are such lists."""


@dataclass(frozen=True)
class Converted:
    """What a conversion did."""

    num_frames: int
    """Frames written."""
    left_out: tuple[str, ...]
    """Files that no frame of either format has, relative to the source."""


@dataclass(frozen=True)
class _Source:
    """A dataset that is read."""

    splits: Mapping[str, tuple[FrameFiles, Sequence[str]]]
    """Where the frames of each split lie, and their ids in order."""
    lists: Mapping[str, bytes] = field(default_factory=dict)
    """The files of `ImageSets`."""
    left_out: tuple[str, ...] = ()


def convert(source: str | Path, out: str | Path, to: str, *, shard_size: int = SHARD_SIZE) -> Converted:
    """Write a dataset in another format, its images with COCO's annotations, or its scans. Lists of splits are kept.

    Between sets no file of a frame is parsed or changed. `put_coco` tells what annotations hold. Scans have x, y, z,
    and intensity, the `ring` where their files have it, and the `time` where `point_times` has it.

    Args:
        source: a KITTI folder, a folder of shards as `cadet-gen --format webdataset` writes it, or a pattern that names
            shards, which then have no split.
        out: a new or empty folder.
        to: one of `FORMATS`.
        shard_size: frames of a shard.

    Raises:
        CadetError: an unknown format, a folder that is not empty, lists that contradict each other or the folder,
            archives as `read_members` refuses them, or, to write scans or annotations, a file that cannot be read.
        MissingFileError: no dataset, or a frame without the scan or image that is to be written.
        OSError: the folder can't be written.
    """
    if not is_one_of(to, FORMATS):
        raise CadetError(f"unknown format {shown(to)}; {known_names(to, FORMATS)}")
    check_number("convert", "shard_size", shard_size, 1, 10_000, whole=True)
    sink = LocalSink.new(as_path("out", out))
    found = _open(source)
    try:
        if to == "coco":
            put_coco(sink, found.splits)
        for split, (files, ids) in found.splits.items():
            if to == "kitti":
                _put_folder(sink, split, files, ids)
            elif to == "webdataset":
                _put_shards(sink, split, files, ids, int(shard_size))
            elif to in POINT_FILES:
                _put_points(sink, split, files, ids, to)
        if to == "kitti":
            for kind in REQUIRED:
                sink.make_folder(f"testing/{kind}")
        for name, data in (found.lists or _made_lists(found)).items():
            sink.put(f"{LISTS}/{name}", data)
    finally:
        sink.remove_partial()
    return Converted(sum(len(ids) for _, ids in found.splits.values()), found.left_out)


def _open(source: str | Path) -> _Source:
    if is_pattern(source):
        shards = ShardDataset(expand_pattern(str(source)))
        return _Source({UNLISTED: (shards, shards.ids)})
    root = as_path("source", source)
    return _open_shards(root) if is_shard_folder(root) else _open_folder(root)


def _open_shards(root: Path) -> _Source:
    by_split = {path.name: sorted(path.glob("*.tar")) for path in sorted(root.iterdir()) if path.is_dir()}
    datasets = {split: ShardDataset(paths) for split, paths in by_split.items() if paths}
    # All but the test's frames become files of one folder.
    ShardDataset([path for split, paths in by_split.items() if split != "test" for path in paths])
    taken = {path.relative_to(root) for paths in by_split.values() for path in paths}
    taken |= {path.with_suffix(SUFFIX) for path in taken}
    lists = list_paths(root)
    left_out = _left_out(root, taken | {path.relative_to(root) for path in lists.values()})
    return _Source({split: (dataset, dataset.ids) for split, dataset in datasets.items()}, _contents(lists), left_out)


def _open_folder(root: Path) -> _Source:
    folder, testing, root = sample_folder(root), testing_folder(root), set_root(root)
    splits: dict[str, tuple[FrameFiles, Sequence[str]]] = {}
    taken: set[Path] = set()
    parts = [(folder, _training_splits(root, frame_ids(folder)))]
    if testing is not None and testing != folder:
        ids = frame_ids(testing)
        listed = [frame_id for frame_id in _listed(root, "test") if frame_id in set(ids)]
        parts.append((testing, {"test": [*listed, *sorted(set(ids) - set(listed))]}))
    for part, of_splits in parts:
        files = FolderFiles(part)
        for split, split_ids in of_splits.items():
            if split_ids:
                splits[split] = (files, split_ids)
        ids_of_part = {frame_id for split_ids in of_splits.values() for frame_id in split_ids}
        kinds = kinds_in(part)
        taken |= {found_path(part, kind, frame_id).relative_to(root) for kind in kinds for frame_id in ids_of_part}
    if not splits:
        raise MissingFileError(no_frames(root, folder, REQUIRED))
    lists = list_paths(root)
    return _Source(
        splits, _contents(lists), _left_out(root, taken | {path.relative_to(root) for path in lists.values()})
    )


def _training_splits(root: Path, ids: Sequence[str]) -> dict[str, Sequence[str]]:
    train, val = _listed(root, "train"), _listed(root, "val")
    if not train and not val:
        return {"train": ids}
    for name, listed in (("train", train), ("val", val)):
        if missing := set(listed) - set(ids):
            raise MissingFileError(f"{list_paths(root)[name]}: there is no frame {min(missing)}")
    if both := set(train) & set(val):
        raise CadetError(f"{list_paths(root)['train'].parent}: train.txt and val.txt both list frame {min(both)}")
    return {"train": train, "val": val, UNLISTED: sorted(set(ids) - set(train) - set(val))}


def _listed(root: Path, name: str) -> tuple[str, ...]:
    return read_image_set(root, name).ids if name in list_paths(root) else ()


def _contents(lists: Mapping[str, Path]) -> dict[str, bytes]:
    return {path.name: list_bytes(path) for path in lists.values()}


def _made_lists(source: _Source) -> dict[str, bytes]:
    """Return the lists of splits whose source has none."""
    ids = {split: tuple(source.splits[split][1]) for split in ("train", "val", "test") if split in source.splits}
    if not ids:
        return {}
    lists = {split: ids.get(split, ()) for split in ("train", "val", "test")}
    lists["trainval"] = tuple(sorted((*lists["train"], *lists["val"])))
    return {f"{split}.txt": ImageSet(listed).to_text().encode("utf-8") for split, listed in lists.items()}


def _left_out(root: Path, taken: set[Path]) -> tuple[str, ...]:
    """Name the files that are not taken; those that tell of a run, which goes on in its own folder alone, aside."""
    of_run = {Path(name) for name in ("run.json", "manifest.json", "recipe.toml", "croissant.json", CARD)}
    files = (path.relative_to(root) for path in sorted(root.rglob("*")) if path.is_file())
    return tuple(str(path) for path in files if path not in taken and path not in of_run)


def _put_folder(sink: LocalSink, split: str, files: FrameFiles, ids: Sequence[str]) -> None:
    part = Path("testing" if split == "test" else "training")
    for frame_id in ids:
        for kind, suffix, data in _files_of(files, frame_id):
            sink.put(str(file_path(part, kind, frame_id, suffix)), data)


def _put_points(sink: LocalSink, split: str, files: FrameFiles, ids: Sequence[str], suffix: str) -> None:
    part = Path("testing" if split == "test" else "training")
    for frame_id in ids:
        data, name = files.read("velodyne", frame_id)
        scan = scan_from_data(data, name)
        time_s = None
        if files.has("point_times", frame_id):
            time_s = point_times_from_bytes(*files.read("point_times", frame_id))
            if len(time_s) != len(scan.points_velo):
                raise CadetError(f"{name}: {len(scan.points_velo)} points, its point_times has {len(time_s)}")
        columns = columns_of_points(scan.points_velo, scan.ring, time_s)
        sink.put(str(file_path(part, f"points_{suffix}", frame_id)), POINT_FILES[suffix](columns))


def _put_shards(sink: LocalSink, split: str, files: FrameFiles, ids: Sequence[str], shard_size: int) -> None:
    left = iter(ids)
    for number in range(-(-len(ids) // shard_size)):
        members: dict[str, Member] = {}
        named = (
            (member_name(frame_id, kind, suffix), data)
            for frame_id in islice(left, shard_size)
            for kind, suffix, data in _files_of(files, frame_id)
        )
        sink.put(f"{split}/{number:06d}.tar", archive_chunks(named, members))
        sink.put(f"{split}/{number:06d}{SUFFIX}", text_from_index(members).encode("ascii"))


def _files_of(files: FrameFiles, frame_id: str) -> Iterator[tuple[str, str, bytes]]:
    """Yield kind, suffix and bytes of each file of a frame."""
    for kind in files.kinds:
        if files.has(kind, frame_id):
            data, name = files.read(kind, frame_id)
            yield kind, Path(name).suffix, data
