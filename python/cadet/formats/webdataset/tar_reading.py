"""Tar archives of unknown origin, read without trust: every header is checked before anything is taken from it."""

from __future__ import annotations

import io
import tarfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

from cadet._util.checks import shown
from cadet.errors import FileFormatError
from cadet.formats.webdataset.member import ArchiveError, Member, check_member_name

MAX_MEMBER_BYTES: Final = 1 << 28
"""The greatest member that is read: a frame's largest file has some 2 MB."""
MAX_MEMBERS: Final = 200_000
"""The most members of one archive."""
_MAX_HEADER_BYTES: Final = 1 << 16
"""Extended headers hold a name, no data."""
_BLOCK_BYTES: Final = 512
_END: Final = bytes(2 * _BLOCK_BYTES)
_FILES: Final = (tarfile.REGTYPE, tarfile.AREGTYPE)
_REFUSED: Final = {
    tarfile.SYMTYPE: "a symbolic link",
    tarfile.LNKTYPE: "a hard link",
    tarfile.CHRTYPE: "a device",
    tarfile.BLKTYPE: "a device",
    tarfile.FIFOTYPE: "a pipe",
    tarfile.GNUTYPE_SPARSE: "a sparse file",
    tarfile.DIRTYPE: "a folder with data",
}


def read_members(archive: Path | BinaryIO, name: str) -> dict[str, Member]:
    """List the files in an uncompressed tar archive, whole and in order; their data is not read.

    Args:
        archive: its path, or the archive itself.
        name: its name for messages.

    Returns:
        Where each file's data lies, by its name. Folders are left out.

    Raises:
        ArchiveError: a name that leads out of a folder or appears twice; a link, device, pipe or sparse file; a
            file of more than `MAX_MEMBER_BYTES`, or more than `MAX_MEMBERS`; a damaged, compressed or cut archive.
        OSError: it can't be read.
    """
    if isinstance(archive, Path):
        with archive.open("rb") as file:
            return read_members(file, name)
    members: dict[str, Member] = {}
    end = 0
    for info in _headers(archive, name):
        end = info.offset_data
        file_name = check_member_name(info.name, name)
        if info.type in _FILES and not info.issparse():
            if file_name in members:
                raise ArchiveError(f"the member {shown(file_name)} appears twice", name)
            if not 0 <= info.size <= MAX_MEMBER_BYTES:
                raise ArchiveError(
                    f"the member {shown(file_name)} declares {info.size} bytes, expected at most {MAX_MEMBER_BYTES}",
                    name,
                )
            if len(members) == MAX_MEMBERS:
                raise ArchiveError(f"the member {shown(file_name)} is one more than {MAX_MEMBERS}", name)
            members[file_name] = Member(info.offset_data, info.size)
            end += padded(info.size)
        elif info.type != tarfile.DIRTYPE or info.size != 0:
            kind = "a sparse file" if info.issparse() else _REFUSED.get(info.type, f"of the unknown type {info.type!r}")
            raise ArchiveError(f"the member {shown(file_name)} is {kind}, expected a file", name)
    archive.seek(end)
    # Where a header is damaged, readers see the end of the archive.
    if archive.read(len(_END)) != _END:
        raise ArchiveError(f"no member and no end of the archive at byte {end}: it is cut or damaged", name)
    return members


def padded(size: int) -> int:
    """Return how many bytes a file of a size takes in an archive, its header aside."""
    return -(-size // _BLOCK_BYTES) * _BLOCK_BYTES


def _headers(archive: BinaryIO, name: str) -> Iterator[tarfile.TarInfo]:
    last = "the first member"
    try:
        with tarfile.open(fileobj=_HeaderReader(archive), mode="r:") as tar:
            while (info := tar.next()) is not None:
                last = f"the member after {shown(info.name)}"
                yield info
    except FileFormatError:
        raise
    except (tarfile.TarError, ValueError, OverflowError, RecursionError, EOFError) as error:
        raise ArchiveError(f"{last}: invalid tar header: {' '.join(str(error).split()) or 'damaged'}", name) from None


class _HeaderReader(io.RawIOBase):
    """What `tarfile` may read of an archive: headers alone, and none that asks for much memory."""

    def __init__(self, archive: BinaryIO) -> None:
        self._archive = archive

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._archive.tell()

    def seek(self, offset: int, whence: int = 0, /) -> int:
        return self._archive.seek(offset, whence)

    def read(self, size: int = -1, /) -> bytes:
        if not 0 <= size <= _MAX_HEADER_BYTES:
            raise ValueError(f"a header declares {size} bytes, expected at most {_MAX_HEADER_BYTES}")
        return self._archive.read(size)
