"""One shard: a tar archive whose members are read at any place, by its index or by its own headers."""

from __future__ import annotations

import os
import tarfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cadet._util.checks import shown
from cadet.errors import MissingFileError
from cadet.formats.webdataset.index import SUFFIX, index_from_text
from cadet.formats.webdataset.member import ArchiveError, Member
from cadet.formats.webdataset.tar_reading import read_members

_MAX_INDEX_BYTES: Final = 1 << 26


@dataclass(frozen=True)
class Shard:
    """An archive and where its files lie. Nothing stays open, so that any process may read.

    Attributes:
        path: of the archive.
        members: where each file's data lies, by its name.
        is_indexed: whether an index says so: each header is then checked when its file is read.
    """

    path: Path
    members: Mapping[str, Member]
    is_indexed: bool

    @classmethod
    def open(cls, path: Path) -> Shard:
        """Find the files of an archive, by the index beside it where there is one.

        Raises:
            MissingFileError: there is no such archive.
            ArchiveError: it, or its index, is one that `read_members` or `index_from_text` refuses.
        """
        index = path.with_suffix(SUFFIX)
        if not path.is_file() or not index.is_file():
            return cls.by_headers(path)
        if index.stat().st_size > _MAX_INDEX_BYTES:
            raise ArchiveError(f"{index.stat().st_size} bytes, expected at most {_MAX_INDEX_BYTES}", str(index))
        text = index.read_bytes().decode("ascii", errors="replace")
        return cls(path, index_from_text(text, str(index)), is_indexed=True)

    @classmethod
    def by_headers(cls, path: Path) -> Shard:
        """Find the files of an archive without its index.

        Raises:
            MissingFileError: there is no such archive.
            ArchiveError: it is one that `read_members` refuses.
        """
        if not path.is_file():
            raise MissingFileError(f"{path}: no such archive")
        return cls(path, read_members(path, str(path)), is_indexed=False)

    def read(self, name: str) -> bytes:
        """Return a file's bytes.

        Raises:
            KeyError: no file of that name.
            ArchiveError: the archive is cut, or its index belongs to another.
            OSError: it can't be read.
        """
        offset, size = self.members[name]
        file = os.open(self.path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            data = os.pread(file, tarfile.BLOCKSIZE + size, max(0, offset - tarfile.BLOCKSIZE))
        finally:
            os.close(file)
        header, data = data[: tarfile.BLOCKSIZE], data[tarfile.BLOCKSIZE :]
        if self.is_indexed:
            self._check_header(name, header, offset, size)
        if len(data) != size:
            raise ArchiveError(f"the member {shown(name)} is cut: {len(data)} of {size} bytes", str(self.path))
        return data

    def _check_header(self, name: str, header: bytes, offset: int, size: int) -> None:
        try:
            info = tarfile.TarInfo.frombuf(header, "ascii", "replace")
            found = (info.name.removeprefix("./"), info.size, info.type in (tarfile.REGTYPE, tarfile.AREGTYPE))
        except (tarfile.TarError, ValueError):
            found = None
        if offset < tarfile.BLOCKSIZE or found != (name, size, True):
            raise ArchiveError(
                f"there is no member {shown(name)} of {size} bytes at byte {offset}, as {self.path.stem}{SUFFIX} says: "
                "remove that file, and the archive is read without it",
                str(self.path),
            )
