"""A folder that takes samples' files one by one, in any order, and holds them in shards."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Final

from cadet._util.operating_system import locked_folder
from cadet._util.sink import LocalSink
from cadet.errors import CadetError
from cadet.formats.webdataset.index import SUFFIX, text_from_index
from cadet.formats.webdataset.member import Member
from cadet.formats.webdataset.member_names import member_order, parse_member_name
from cadet.formats.webdataset.shard import Shard
from cadet.formats.webdataset.tar_writing import archive_chunks

_STAGED: Final = ".staged"
_IN_SHARD: Final = ".tar/"


class ShardSink:
    """A sink whose names may lie in a shard: "train/000000.tar/000012.image_2.png".

    Such a file is put into a folder aside until `pack` makes the shard of all that lies there and of what the shard
    held before; it is read from either. So a run that is killed loses nothing, and a shard that is there is whole.

    Args:
        sink: the folder.
        shard_of: returns the shard that a frame belongs into, by its number.
    """

    def __init__(self, sink: LocalSink, shard_of: Callable[[int], str]) -> None:
        self._sink, self._shard_of = sink, shard_of
        self._seen: tuple[tuple[str, int, int, int], tuple[Shard, ...]] | None = None

    @property
    def location(self) -> str:
        """The folder."""
        return self._sink.location

    def held(self) -> AbstractContextManager[None]:
        """Lock the folder meanwhile; see `LocalSink.held`."""
        return self._sink.held()

    def remove_partial(self) -> None:
        """Remove what killed writers have left behind; what lies aside for a shard stays."""
        self._sink.remove_partial()

    def names(self, folder: str) -> list[str]:
        """Return the names of what lies in a folder."""
        return self._sink.names(folder)

    def put(self, name: str, data: bytes | Iterable[bytes]) -> None:
        """Store an object under its name, or aside if it belongs into a shard.

        Raises:
            OSError: as `LocalSink.put`.
        """
        self._sink.put(f"{_STAGED}/{name}" if _IN_SHARD in name else name, data)

    def put_new(self, name: str, data: bytes) -> None:
        """Store an object that is not there yet and belongs into no shard.

        Raises:
            FileExistsError: it is there.
            OSError: as `LocalSink.put`.
        """
        self._sink.put_new(name, data)

    def put_all(self, objects: Mapping[str, bytes]) -> None:
        """Store several objects, in their order.

        Raises:
            OSError: as `LocalSink.put`.
        """
        for name, data in objects.items():
            self.put(name, data)

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
            return self._read_packed(shard, member)

    def read_all(self, names: Sequence[str]) -> list[bytes]:
        """Return the bytes of several objects.

        Raises:
            FileNotFoundError: as `read`.
        """
        return [self.read(name) for name in names]

    def make_folder(self, name: str) -> None:
        """Make a folder that may stay empty.

        Raises:
            OSError: a file is in its place, or no rights.
        """
        self._sink.make_folder(name)

    def member_names(self) -> Iterator[str]:
        """Yield the names of all that the shards hold or that lies aside for them; damaged shards hold nothing."""
        return names_in_shards(self._sink.root)

    def shards(self) -> list[str]:
        """List the shards that are there or begun."""
        return _shards(self._sink.root)

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
            names = self._names(shard, staged)
            if only_at is not None and sum(_is_record(name) for name in names) < only_at:
                return
            self._write(shard, names)
            for name in staged:
                (self._sink.root / _STAGED / shard / name).unlink()

    def mend(self, shard: str) -> None:
        """Write a packed shard anew if its headers or its end are damaged, and its index if it is not the shard's.

        Raises:
            OSError: as `LocalSink.put`.
        """
        try:
            members = Shard.by_headers(self._sink.root / shard).members
            is_indexed = self._sink.read(_index_of(shard)) == text_from_index(members).encode("ascii")
        except (CadetError, FileNotFoundError):
            is_indexed = False
        if not is_indexed:
            self._write(shard, self._names(shard, ()))

    def remove_staging(self) -> None:
        """Remove the folders of what lay aside, once all is packed; what is not packed stays."""
        staging = self._sink.root / _STAGED
        for folder in (*staging.glob("*/*"), *staging.glob("*"), staging):
            with contextlib.suppress(OSError):
                folder.rmdir()

    def _packed(self, shard: str) -> tuple[Shard, ...]:
        """Return a packed shard as its index shows it and as its headers do, if they can be read."""
        path = self._sink.root / shard
        try:
            found = path.stat()
        except FileNotFoundError:
            return ()
        version = (shard, found.st_ino, found.st_mtime_ns, found.st_size)
        if self._seen is None or self._seen[0] != version:
            views = []
            for look in (Shard.open, Shard.by_headers):
                with contextlib.suppress(CadetError):
                    views.append(look(path))
            self._seen = (version, tuple(views))
        return self._seen[1]

    def _read_packed(self, shard: str, name: str) -> bytes:
        for packed in self._packed(shard):
            with contextlib.suppress(CadetError, KeyError):
                return packed.read(name)
        # What can't be read is made again.
        raise FileNotFoundError(f"{self._sink.root / shard}: no member {name}")

    def _names(self, shard: str, staged: Iterable[str]) -> list[str]:
        packed = {name for view in self._packed(shard) for name in view.members if self._is_of(shard, name)}
        return sorted({*packed, *staged}, key=member_order)

    def _write(self, shard: str, names: Iterable[str]) -> None:
        members: dict[str, Member] = {}
        index = _index_of(shard)
        # An index beside another archive than its own would be worse than none.
        (self._sink.root / index).unlink(missing_ok=True)
        self._sink.put(shard, archive_chunks(self._files(shard, names), members))
        self._sink.put(index, text_from_index(members).encode("ascii"))

    def _files(self, shard: str, names: Iterable[str]) -> Iterator[tuple[str, bytes]]:
        for name in names:
            # An index that is another's may name what is not there.
            with contextlib.suppress(FileNotFoundError):
                yield name, self.read(f"{shard}/{name}")

    def _is_of(self, shard: str, name: str) -> bool:
        parsed = parse_member_name(name)
        return parsed is not None and self._shard_of(int(parsed[0])) == shard

    def _staged(self, shard: str) -> list[str]:
        try:
            return sorted(path.name for path in (self._sink.root / _STAGED / shard).iterdir())
        except FileNotFoundError:
            return []

    @contextlib.contextmanager
    def _locked(self, shard: str) -> Iterator[None]:
        """Let one process at a time pack a shard."""
        folder = self._sink.root / _STAGED / shard
        if not folder.is_dir():
            # Nothing lies aside.
            yield
            return
        with locked_folder(folder, folder.with_suffix(".lock"), waits=True):
            yield


def names_in_shards(root: Path) -> Iterator[str]:
    """Yield the names of all that a folder's shards hold or that lies aside for them; damaged shards hold nothing."""
    for name in _shards(root):
        with contextlib.suppress(CadetError):
            yield from Shard.open(root / name).members
        yield from (path.name for path in (root / _STAGED / name).glob("*"))


def _shards(root: Path) -> list[str]:
    found = {str(path.relative_to(base)) for base in (root, root / _STAGED) for path in base.glob("*/*.tar")}
    return sorted(found)


def _index_of(shard: str) -> str:
    return shard.removesuffix(".tar") + SUFFIX


def _is_record(name: str) -> bool:
    parsed = parse_member_name(name)
    return parsed is not None and parsed[1] == "meta"
