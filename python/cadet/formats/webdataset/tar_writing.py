"""Tar archives that are a function of their members' names and bytes alone."""

from __future__ import annotations

import tarfile
from collections.abc import Iterable, Iterator

from cadet.formats.webdataset.member import Member
from cadet.formats.webdataset.tar_reading import padded

_END = bytes(2 * tarfile.BLOCKSIZE)


def archive_chunks(files: Iterable[tuple[str, bytes]], members: dict[str, Member]) -> Iterator[bytes]:
    """Yield an archive piece by piece, with no time, owner or rights of any machine in it.

    Args:
        files: names of at most 100 letters, and bytes.
        members: gets where each file lies.
    """
    offset = 0
    for name, data in files:
        info = tarfile.TarInfo(name)
        info.size = len(data)
        info.mode = 0o644
        header = info.tobuf(tarfile.USTAR_FORMAT)
        offset += len(header)
        members[name] = Member(offset, len(data))
        offset += padded(len(data))
        yield header
        yield data
        yield bytes(padded(len(data)) - len(data))
    yield _END
