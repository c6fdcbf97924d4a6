"""A folder that takes samples' files one by one, in any order, and holds them in shards."""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from cadet.errors import CadetError
from cadet.sink import LocalSink
from cadet.webdataset.index import SUFFIX, text_from_index
from cadet.webdataset.member import Member
from cadet.webdataset.member_names import member_order, parse_member_name
from cadet.webdataset.shard import Shard
from cadet.webdataset.tar_writing import archive_chunks

_STAGED: Final = ".staged"
_IN_SHARD: Final = ".tar/"


class ShardSink:
    """A sink whose names may lie in a shard: "train/000000.tar/000012.image_2.png".

    Such a file is put into a folder aside until `pack` makes the shard of all that lies there and of what the shard
    held before; it is read from either. So a run that is killed loses nothing, and a shard that is there is whole.

    Args:
        sink: the folder.
    """

    def __init__(self, sink: LocalSink) -> None:
        self._sink = sink
        self._read_last: tuple[str, tuple[int, ...], Shard] | None = None

    def put(self, name: str, data: bytes | Iterable[bytes]) -> None:
        """Store an object under its name, or aside if it belongs into a shard.

        Raises:
            OSError: as `LocalSink.put`.
        """
        self._sink.put(f"{_STAGED}/{name}" if _IN_SHARD in name else name, data)

    def read(self, name: str) -> bytes:
        """Return an object's bytes.

        Raises:
            FileNotFoundError: there is none of that name, or the shard that should hold it is damaged.
        """
        if _IN_SHARD not in name:
            return self._sink.read(name)
        try:
            return self._sink.read(f"{_STAGED}/{name}")
        except FileNotFoundError:
            shard, _, member = name.rpartition("/")
            return self._read_member(shard, member)

    def make_folder(self, name: str) -> None:
        """Make a folder that may stay empty.

        Raises:
            OSError: a file is in its place, or no rights.
        """
        self._sink.make_folder(name)

    def names(self, shard: str) -> set[str]:
        """Return the members of a shard, packed or still aside."""
        try:
            packed = set(Shard.open(self._sink.root / shard).members)
        except (CadetError, FileNotFoundError):
            packed = set()
        return packed | set(self._staged(shard))

    def shards(self) -> list[str]:
        """List the shards that are there or begun."""
        root = self._sink.root
        found = {str(path.relative_to(base)) for base in (root, root / _STAGED) for path in base.glob("*/*.tar")}
        return sorted(found)

    def pack(self, shard: str, *, only_at: int | None = None) -> None:
        """Write a shard and its index of all that belongs into it; nothing lies aside afterwards.

        Args:
            shard: its name.
            only_at: do nothing unless so many samples have a record.

        Raises:
            OSError: as `LocalSink.put`.
        """
        with self._locked(shard):
            staged = self._staged(shard)
            if not staged:
                return
            names = sorted(self.names(shard), key=member_order)
            if only_at is not None and sum(_is_record(name) for name in names) < only_at:
                return
            members: dict[str, Member] = {}
            files = ((name, self.read(f"{shard}/{name}")) for name in names)
            index = str(Path(shard).with_suffix(SUFFIX))
            # An index beside another archive than its own would be worse than none.
            (self._sink.root / index).unlink(missing_ok=True)
            self._sink.put(shard, archive_chunks(files, members))
            self._sink.put(index, text_from_index(members).encode("ascii"))
            for name in staged:
                (self._sink.root / _STAGED / shard / name).unlink()

    def remove_staging(self) -> None:
        """Remove the folders of what lay aside, once all is packed; what is not packed stays."""
        staging = self._sink.root / _STAGED
        for folder in (*staging.glob("*/*"), *staging.glob("*"), staging):
            with contextlib.suppress(OSError):
                folder.rmdir()

    def _staged(self, shard: str) -> list[str]:
        try:
            return sorted(path.name for path in (self._sink.root / _STAGED / shard).iterdir())
        except FileNotFoundError:
            return []

    def _read_member(self, shard: str, member: str) -> bytes:
        path = self._sink.root / shard
        try:
            found = path.stat()
            version = (found.st_ino, found.st_mtime_ns, found.st_size)
            if self._read_last is None or self._read_last[:2] != (shard, version):
                self._read_last = (shard, version, Shard.open(path))
            return self._read_last[2].read(member)
        except (CadetError, KeyError):
            # What can't be read is made again.
            raise FileNotFoundError(f"{path}: no member {member}") from None

    @contextlib.contextmanager
    def _locked(self, shard: str) -> Iterator[None]:
        """Let one process at a time pack a shard."""
        try:
            folder = os.open(self._sink.root / _STAGED / shard, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        except FileNotFoundError:
            # Nothing lies aside.
            yield
            return
        try:
            fcntl.flock(folder, fcntl.LOCK_EX)
            yield
        finally:
            os.close(folder)


def _is_record(name: str) -> bool:
    parsed = parse_member_name(name)
    return parsed is not None and parsed[1] == "meta"
