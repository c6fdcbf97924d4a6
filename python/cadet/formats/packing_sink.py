"""A folder that takes samples' files one by one, in any order, and holds them in archives."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Final, Protocol

from cadet._util.operating_system import locked_folder
from cadet._util.sink import LocalSink
from cadet.errors import CadetError

_STAGED: Final = ".staged"


class Archive(Protocol):
    """An archive that was looked into."""

    @property
    def members(self) -> Collection[str]:
        """The names of its members."""

    def read(self, name: str) -> bytes:
        """Return a member's bytes.

        Raises:
            KeyError: no member of that name.
            CadetError: the archive is damaged.
        """


class ArchiveFormat(Protocol):
    """What archives are written and read by."""

    suffix: str
    """Of their names, with its dot."""

    def views(self, path: Path) -> Iterable[Archive]:
        """Return an archive as each way to look into it shows it, the best one first; none of one that is damaged."""

    def order(self, name: str) -> Any:
        """Return what members are sorted by."""

    def write(self, sink: LocalSink, archive: str, files: Iterable[tuple[str, bytes]]) -> None:
        """Write an archive, a function of its members alone, and what belongs to it.

        Raises:
            OSError: as `LocalSink.put`.
        """

    def is_sound(self, sink: LocalSink, archive: str) -> bool:
        """Tell whether a packed archive, and what belongs to it, can be read by others."""


class PackingSink:
    """A sink whose names may lie in an archive: "train/000000.tar/000012.image_2.png".

    Such a file is put into a folder aside until `pack` makes the archive of all that lies there and of what the archive
    held before; it is read from either. So a run that is killed loses nothing, and an archive that is there is whole.

    Args:
        sink: the folder.
        archive_format: of the archives.
        archive_of: returns the archive that a member belongs into, by its name; None for a strange one.
    """

    def __init__(self, sink: LocalSink, archive_format: ArchiveFormat, archive_of: Callable[[str], str | None]) -> None:
        self._sink, self._format, self._archive_of = sink, archive_format, archive_of
        self._seen: tuple[tuple[str, int, int, int], tuple[Archive, ...]] | None = None

    @property
    def location(self) -> str:
        """The folder."""
        return self._sink.location

    def held(self) -> AbstractContextManager[None]:
        """Lock the folder meanwhile; see `LocalSink.held`."""
        return self._sink.held()

    def remove_partial(self) -> None:
        """Remove what killed writers have left behind; what lies aside for an archive stays."""
        self._sink.remove_partial()

    def names(self, folder: str) -> list[str]:
        """Return the names of what lies in a folder."""
        return self._sink.names(folder)

    def put(self, name: str, data: bytes | Iterable[bytes]) -> None:
        """Store an object under its name, or aside if it belongs into an archive.

        Raises:
            OSError: as `LocalSink.put`.
        """
        self._sink.put(f"{_STAGED}/{name}" if self._is_member(name) else name, data)

    def put_new(self, name: str, data: bytes) -> None:
        """Store an object that is not there yet and belongs into no archive.

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
            FileNotFoundError: there is none of that name, or the archive that should hold it is damaged.
        """
        if not self._is_member(name):
            return self._sink.read(name)
        try:
            return self._sink.read(f"{_STAGED}/{name}")
        except FileNotFoundError:
            archive, _, member = name.rpartition("/")
            return self._read_packed(archive, member)

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
        """Yield the names of all that the archives hold or that lies aside for them; damaged ones hold nothing."""
        for archive in self.archives():
            yield from next((view.members for view in self._packed(archive)), ())
            yield from self._staged(archive)

    def archives(self) -> list[str]:
        """List the archives that are there or begun."""
        root = self._sink.root
        bases, pattern = (root, root / _STAGED), f"*/*{self._format.suffix}"
        return sorted({str(path.relative_to(base)) for base in bases for path in base.glob(pattern)})

    def pack(self, archive: str, is_due: Callable[[Sequence[str]], bool] = lambda names: True) -> bool:
        """Write an archive of all that belongs into it; nothing lies aside afterwards.

        Args:
            archive: its name.
            is_due: do nothing unless this holds of the members' names.

        Returns:
            Whether it was written: something lay aside for it, and it was due.

        Raises:
            OSError: as `LocalSink.put`.
        """
        with self._locked(archive):
            staged = self._staged(archive)
            names = self._names(archive, staged)
            if not staged or not is_due(names):
                return False
            self._write(archive, names)
            for name in staged:
                (self._sink.root / _STAGED / archive / name).unlink()
            return True

    def mend(self, archive: str) -> None:
        """Write a packed archive anew if others could not read it.

        Raises:
            OSError: as `LocalSink.put`.
        """
        if not self._format.is_sound(self._sink, archive):
            self._write(archive, self._names(archive, ()))

    def remove_staging(self) -> None:
        """Remove the folders of what lay aside, once all is packed; what is not packed stays."""
        staging = self._sink.root / _STAGED
        for folder in (*staging.glob("*/*"), *staging.glob("*"), staging):
            with contextlib.suppress(OSError):
                folder.rmdir()

    def _is_member(self, name: str) -> bool:
        return f"{self._format.suffix}/" in name

    def _packed(self, archive: str) -> tuple[Archive, ...]:
        """Return a packed archive in each way that it can be looked into."""
        path = self._sink.root / archive
        try:
            found = path.stat()
        except FileNotFoundError:
            return ()
        version = (archive, found.st_ino, found.st_mtime_ns, found.st_size)
        if self._seen is None or self._seen[0] != version:
            self._seen = (version, tuple(self._format.views(path)))
        return self._seen[1]

    def _read_packed(self, archive: str, name: str) -> bytes:
        for packed in self._packed(archive):
            with contextlib.suppress(CadetError, KeyError):
                return packed.read(name)
        # What can't be read is made again.
        raise FileNotFoundError(f"{self._sink.root / archive}: no member {name}")

    def _names(self, archive: str, staged: Iterable[str]) -> list[str]:
        packed = {name for view in self._packed(archive) for name in view.members if self._archive_of(name) == archive}
        return sorted({*packed, *staged}, key=self._format.order)

    def _write(self, archive: str, names: Iterable[str]) -> None:
        self._format.write(self._sink, archive, self._files(archive, names))

    def _files(self, archive: str, names: Iterable[str]) -> Iterator[tuple[str, bytes]]:
        for name in names:
            # An index that is another's may name what is not there.
            with contextlib.suppress(FileNotFoundError):
                yield name, self.read(f"{archive}/{name}")

    def _staged(self, archive: str) -> list[str]:
        try:
            return sorted(path.name for path in (self._sink.root / _STAGED / archive).iterdir())
        except FileNotFoundError:
            return []

    @contextlib.contextmanager
    def _locked(self, archive: str) -> Iterator[None]:
        """Let one process at a time pack an archive."""
        folder = self._sink.root / _STAGED / archive
        if not folder.is_dir():
            # Nothing lies aside.
            yield
            return
        with locked_folder(folder, folder.with_suffix(".lock"), waits=True):
            yield
