"""The frames of many shards, read at any place like those of a KITTI folder."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Final

from cadet._util.checks import as_path, shown
from cadet.errors import CadetError, MissingFileError
from cadet.formats import kitti
from cadet.formats.kitti import Frame, Label
from cadet.formats.kitti.files.folder import REQUIRED
from cadet.formats.kitti.frame_files import frame_from_files, labels_from_files
from cadet.formats.webdataset.member import ArchiveError
from cadet.formats.webdataset.member_names import found_member, kind_order, member_name, parse_member_name
from cadet.formats.webdataset.shard import Shard

_RANGE: Final = re.compile(r"\{([0-9]{1,9})\.\.([0-9]{1,9})\}")
_MOST_SHARDS: Final = 1_000_000


class ShardDataset:
    """The frames of shards, each by its id and in no set order of reading: an index makes an archive seekable.

    Args:
        paths: of the archives. Their order is that of the frames.

    Raises:
        MissingFileError: no such archive, or no frame in any.
        ArchiveError: an archive or index that is damaged or hostile, a member that is not a frame's file, or a frame
            that two shards hold.
    """

    def __init__(self, paths: Sequence[str | Path]) -> None:
        self.paths = tuple(as_path("paths", path) for path in paths)
        self._shards: dict[str, Shard] = {}
        self._kinds: set[str] = set()
        for path in self.paths:
            self._add(Shard.open(path))
        if not self._shards:
            raise MissingFileError(f"{', '.join(map(str, self.paths[:3])) or 'no shards'}: no frames")
        self.ids: tuple[str, ...] = tuple(self._shards)

    def _add(self, shard: Shard) -> None:
        for name in shard.members:
            parsed = parse_member_name(name)
            if parsed is None:
                raise ArchiveError(
                    f"the member {shown(name)} is not a frame's file, such as 000012.image_2.png", str(shard.path)
                )
            frame_id, kind = parsed
            first = self._shards.setdefault(frame_id, shard)
            if first is not shard:
                raise ArchiveError(
                    f"the member {shown(name)}: {first.path} holds the frame {frame_id}", str(shard.path)
                )
            self._kinds.add(kind)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of files that frames have, in the order in which shards list them."""
        return tuple(sorted(self._kinds, key=kind_order))

    def has(self, kind: str, frame_id: str) -> bool:
        """Tell whether a frame has such a file."""
        shard = self._shards.get(frame_id)
        return shard is not None and found_member(shard.members, frame_id, kind) is not None

    def has_kind(self, kind: str) -> bool:
        """Tell whether any frame has such a file."""
        return kind in self._kinds

    def read(self, kind: str, frame_id: str) -> tuple[bytes, str]:
        """Return a file's bytes, and its name for messages.

        Raises:
            MissingFileError: no such frame, or it has no such file.
            ArchiveError: the archive is cut, or its index belongs to another.
        """
        shard = self._shards.get(frame_id)
        name = None if shard is None else found_member(shard.members, frame_id, kind)
        if shard is None or name is None:
            where = self.paths[0].parent if shard is None else shard.path
            raise MissingFileError(f"{where}: no member {member_name(frame_id, kind)}")
        return shard.read(name), f"{shard.path.name}/{name}"

    def read_frame(self, frame_id: str, *, has_extras: bool = True) -> Frame:
        """Read a frame: see `cadet.kitti.read_frame`."""
        return frame_from_files(self, frame_id, has_extras=has_extras)

    def read_labels(self, frame_id: str) -> tuple[Label, ...]:
        """Read only the labels of a frame: see `cadet.kitti.read_labels`."""
        return labels_from_files(self, frame_id)

    def __len__(self) -> int:
        return len(self.ids)

    def __iter__(self) -> Iterator[Frame]:
        return (self.read_frame(frame_id) for frame_id in self.ids)

    def __getitem__(self, key: int | str) -> Frame:
        """Read the frame at an index (int) or with an id (str).

        Raises:
            IndexError: no such index.
            KeyError: no such id.
        """
        if isinstance(key, str):
            if key not in self._shards:
                raise KeyError(key)
            return self.read_frame(key)
        return self.read_frame(self.ids[key])

    def __repr__(self) -> str:
        return f"ShardDataset({self.num_shards} shards): {len(self)} frames"

    @property
    def folder(self) -> Path:
        """The folder of the first archive."""
        return self.paths[0].parent

    @cached_property
    def num_shards(self) -> int:
        """How many archives there are."""
        return len(self.paths)


def open_dataset(data: str | Path, split: str | None = None) -> kitti.Dataset | ShardDataset:
    """Open the frames of a KITTI folder, of a folder of shards, or of shards that a pattern names.

    Args:
        data: a KITTI folder; a folder whose shards lie in a folder for each split; or a pattern of `expand_pattern`,
            such as `set/train/{000000..000009}.tar`.
        split: of a folder: a list of KITTI's `ImageSets`, or a folder of shards; None for every frame that is not a
            test's. Shards that a pattern names are a split of their own.

    Raises:
        MissingFileError: no such folder, split or shards, or no frame in them.
        CadetError: files that are damaged, as `kitti.Dataset` and `ShardDataset` raise it.
    """
    if is_pattern(data):
        return ShardDataset(expand_pattern(str(data)))
    root = as_path("data", data)
    if not is_shard_folder(root):
        return kitti.Dataset(root, split)
    names = [split] if split is not None else [path.name for path in sorted(root.iterdir()) if path.name != "test"]
    paths = [path for name in names for path in sorted((root / as_path("split", name)).glob("*.tar"))]
    if not paths:
        raise MissingFileError(f"{root / (split or '*')}: no shards of this split")
    return ShardDataset(paths)


def is_pattern(data: str | Path) -> bool:
    """Tell whether a text names shards rather than a folder."""
    return str(data).endswith(".tar")


def is_shard_folder(root: Path) -> bool:
    """Tell whether shards lie in folders of splits there, and no KITTI folder."""
    is_kitti = any((folder / kind).is_dir() for folder in (root / "training", root) for kind in REQUIRED)
    return not is_kitti and next(root.glob("*/*.tar"), None) is not None


def expand_pattern(pattern: str) -> tuple[Path, ...]:
    """Return the paths that a pattern names: `{000..099}` stands for all numbers of that range, `*` for any letters.

    Raises:
        MissingFileError: a `*` that stands for nothing, or a shard of a range that is not there.
        CadetError: a range that falls, or one of more than a million.
    """
    texts = [pattern]
    while (found := _RANGE.search(texts[0])) is not None:
        first, last = int(found[1]), int(found[2])
        if last < first or (last - first + 1) * len(texts) > _MOST_SHARDS:
            raise CadetError(f"{pattern}: expected a range that rises to at most {_MOST_SHARDS} shards, got {found[0]}")
        width = len(found[1])
        texts = [_RANGE.sub(f"{n:0{width}d}", text, count=1) for text in texts for n in range(first, last + 1)]
    paths: list[Path] = []
    for text in texts:
        path = as_path("shards", text)
        if "*" not in text:
            if not path.is_file():
                raise MissingFileError(f"{path}: no such shard" + (f", of {pattern}" if text != pattern else ""))
            paths.append(path)
            continue
        anchor = Path(path.anchor)
        found_paths = sorted(anchor.glob(str(path.relative_to(anchor))))
        if not found_paths:
            raise MissingFileError(f"{path}: no shard has such a name")
        paths += found_paths
    return tuple(paths)
