"""Where a dataset's files go: whole objects by name, or nothing."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Protocol


class Sink(Protocol):
    """A store of named objects. Names are relative, with forward slashes: "training/image_2/000012.png"."""

    def put(self, name: str, data: bytes | Iterable[bytes]) -> None:
        """Store an object under its name, replacing an older one: readers see all of it or none of it."""

    def read(self, name: str) -> bytes:
        """Return an object's bytes.

        Raises:
            FileNotFoundError: there is none of that name.
        """

    def make_folder(self, name: str) -> None:
        """Make a folder that may stay empty; a store that has no folders does nothing."""


class LocalSink:
    """A folder. Objects are written aside, into `.partial`, and renamed into place.

    Args:
        root: the folder; it and its subfolders are made when first needed.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        self._partial = self.root / ".partial"
        self._folders: set[Path] = set()

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
            # Writing names no file in its errors; the user wants to know which.
            raise OSError(error.errno, error.strerror, str(path)) from None

    def read(self, name: str) -> bytes:
        """Return an object's bytes.

        Raises:
            FileNotFoundError: there is none of that name.
        """
        return (self.root / name).read_bytes()

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
