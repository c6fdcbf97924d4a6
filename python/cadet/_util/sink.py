"""Where a dataset's files go: whole objects by name, or nothing."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from itertools import islice
from pathlib import Path
from typing import Final, Protocol

from cadet._util.operating_system import FolderInUseError, locked_folder
from cadet.errors import CadetError

_PARTIAL: Final = ".partial"
_READ_AT_A_TIME: Final = 256


class Sink(Protocol):
    """A store of named objects. Names are relative, with forward slashes: "training/image_2/000012.png"."""

    @property
    def location(self) -> str:
        """The folder or URL that the names are relative to."""

    def held(self) -> AbstractContextManager[None]:
        """Keep other writers out meanwhile, where the store has a way to.

        Raises:
            CadetError: another writer has it.
            OSError: the store can't be reached or made.
        """

    def put(self, name: str, data: bytes | Iterable[bytes]) -> None:
        """Store an object under its name, replacing an older one: readers see all of it or none of it.

        Raises:
            OSError: it names the object, and nothing of it is left.
        """

    def put_new(self, name: str, data: bytes) -> None:
        """Store an object that is not there yet.

        Raises:
            FileExistsError: it is there.
            OSError: as for `put`.
        """

    def put_all(self, objects: Mapping[str, bytes]) -> None:
        """Store several objects, each as `put` does, in any order.

        Raises:
            OSError: one could not be stored; the others may be there or not.
        """

    def read(self, name: str) -> bytes:
        """Return an object's bytes.

        Raises:
            FileNotFoundError: there is none of that name.
        """

    def read_all(self, names: Sequence[str]) -> list[bytes]:
        """Return the bytes of several objects.

        Raises:
            FileNotFoundError: one is not there.
        """

    def names(self, folder: str) -> list[str]:
        """Return the names of what lies in a folder, without it; "" is the topmost. None if there is no such folder."""

    def make_folder(self, name: str) -> None:
        """Make a folder that may stay empty; a store that has no folders does nothing."""

    def remove_partial(self) -> None:
        """Remove what killed writers have left behind; only for who holds the store."""


def read_each(sink: Sink, names: Iterable[str]) -> Iterator[bytes]:
    """Yield the bytes of many objects in their order, some hundred read at a time.

    Raises:
        FileNotFoundError: one is not there.
    """
    rest = iter(names)
    while some := list(islice(rest, _READ_AT_A_TIME)):
        yield from sink.read_all(some)


class LocalSink:
    """A folder. Objects are written aside, into `.partial`, and renamed into place.

    Args:
        root: the folder; it and its subfolders are made when first needed.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        self._partial = self.root / _PARTIAL
        self._folders: set[Path] = set()

    @classmethod
    def new(cls, root: Path) -> LocalSink:
        """Return a sink whose folder is not there yet, or empty.

        Raises:
            CadetError: something is there.
        """
        if root.exists() and (not root.is_dir() or any(root.iterdir())):
            raise CadetError(f"{root} is not an empty folder: name a new one")
        return cls(root)

    @property
    def location(self) -> str:
        """The folder."""
        return str(self.root)

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Make the folder and lock it meanwhile.

        The lock is on the folder itself, which no file's replacing changes, and goes with the process.

        Raises:
            CadetError: another writer has it.
            OSError: the folder can't be made or locked.
        """
        self.root.mkdir(parents=True, exist_ok=True)
        with contextlib.ExitStack() as held:
            try:
                held.enter_context(locked_folder(self.root, self._partial / "lock"))
            except FolderInUseError:
                raise CadetError(f"another cadet-gen is writing to {self.root}: let it end first") from None
            yield

    def put(self, name: str, data: bytes | Iterable[bytes]) -> None:
        """Store an object under its name, replacing an older one: readers see all of it or none of it.

        Raises:
            OSError: no room, no rights, no folder; it names the file, and nothing of it is left.
        """
        path = self.root / name
        aside = self._partial / f"{os.getpid()}-{path.name}"
        try:
            for folder in (self._partial, path.parent):
                if folder not in self._folders:
                    folder.mkdir(parents=True, exist_ok=True)
                    self._folders.add(folder)
            with aside.open("wb") as file:
                for chunk in [data] if isinstance(data, bytes) else data:
                    file.write(chunk)
            aside.replace(path)
        except OSError as error:
            with contextlib.suppress(OSError):
                aside.unlink(missing_ok=True)
            # The user wants to know which object, not which file aside.
            raise OSError(error.errno, error.strerror, str(path)) from None

    def put_new(self, name: str, data: bytes) -> None:
        """Store an object that is not there yet; only for who holds the folder.

        Raises:
            FileExistsError: it is there.
            OSError: as for `put`.
        """
        if (self.root / name).exists():
            raise FileExistsError(f"{self.root / name} is there already")
        self.put(name, data)

    def put_all(self, objects: Mapping[str, bytes]) -> None:
        """Store several objects, in their order.

        Raises:
            OSError: as for `put`.
        """
        for name, data in objects.items():
            self.put(name, data)

    def read(self, name: str) -> bytes:
        """Return an object's bytes.

        Raises:
            FileNotFoundError: there is none of that name.
        """
        return (self.root / name).read_bytes()

    def read_all(self, names: Sequence[str]) -> list[bytes]:
        """Return the bytes of several objects.

        Raises:
            FileNotFoundError: one is not there.
        """
        return [self.read(name) for name in names]

    def names(self, folder: str) -> list[str]:
        """Return the names of what lies in a folder, sorted; none if there is no such folder."""
        try:
            return sorted(path.name for path in (self.root / folder).iterdir() if path.name != _PARTIAL)
        except FileNotFoundError:
            return []

    def make_folder(self, name: str) -> None:
        """Make a folder that may stay empty.

        Raises:
            OSError: a file is in its place, or no rights.
        """
        (self.root / name).mkdir(parents=True, exist_ok=True)

    def remove_partial(self) -> None:
        """Remove what killed writers have left behind."""
        shutil.rmtree(self._partial, ignore_errors=True)
        self._folders.discard(self._partial)
