"""Tar shards with an index beside each, as what a packing sink writes and reads."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import Path

from cadet._util.sink import LocalSink
from cadet.errors import CadetError
from cadet.formats.webdataset.index import SUFFIX, text_from_index
from cadet.formats.webdataset.member import Member
from cadet.formats.webdataset.member_names import member_order
from cadet.formats.webdataset.shard import Shard
from cadet.formats.webdataset.tar_writing import archive_chunks


class ShardFormat:
    """See `cadet.formats.packing_sink.ArchiveFormat`."""

    suffix = ".tar"

    def views(self, path: Path) -> Iterator[Shard]:
        """Yield a shard as its index shows it and as its headers do, if they can be read."""
        for look in (Shard.open, Shard.by_headers):
            with contextlib.suppress(CadetError):
                yield look(path)

    def order(self, name: str) -> tuple[str, str, int]:
        """Sort by frame, then by kind."""
        return member_order(name)

    def write(self, sink: LocalSink, archive: str, files: Iterable[tuple[str, bytes]]) -> None:
        """Write a shard and its index."""
        members: dict[str, Member] = {}
        # An index beside another archive than its own would be worse than none.
        (sink.root / _index_of(archive)).unlink(missing_ok=True)
        sink.put(archive, archive_chunks(files, members))
        sink.put(_index_of(archive), text_from_index(members).encode("ascii"))

    def is_sound(self, sink: LocalSink, archive: str) -> bool:
        """Tell whether headers and end are whole, and the index is the shard's."""
        try:
            members = Shard.by_headers(sink.root / archive).members
            return sink.read(_index_of(archive)) == text_from_index(members).encode("ascii")
        except (CadetError, FileNotFoundError):
            return False


def _index_of(shard: str) -> str:
    return shard.removesuffix(ShardFormat.suffix) + SUFFIX
