"""Parquet files of samples, as what a packing sink writes and reads: a member is a sample's file of one kind."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterable, Iterator
from itertools import groupby, islice
from pathlib import Path
from typing import Any, Final

from cadet._util.sink import LocalSink
from cadet.errors import CadetError, FileFormatError
from cadet.formats.parquet.rows import COLUMNS, KINDS, arrow, row_of_files, schema
from cadet.formats.webdataset.member_names import member_name, member_order, parse_member_name

_ROWS_AT_ONCE: Final = 20
"""Rows of a group: some 55 MB of KITTI's rig in memory."""
_SMALL: Final = [name for name in COLUMNS if name not in {kind.column for kind in KINDS.values()}]


class ParquetFormat:
    """See `cadet.formats.packing_sink.ArchiveFormat`."""

    suffix = ".parquet"

    def views(self, path: Path) -> Iterator[ParquetShard]:
        """Yield the file, if it can be read."""
        with contextlib.suppress(CadetError):
            yield ParquetShard(path)

    def order(self, name: str) -> tuple[str, str, int]:
        """Sort by frame, then by kind."""
        return member_order(name)

    def write(self, sink: LocalSink, archive: str, files: Iterable[tuple[str, bytes]]) -> None:
        """Write a row for each sample."""
        sink.put(archive, _chunks(files))

    def is_sound(self, sink: LocalSink, archive: str) -> bool:
        """Tell whether the file can be read; a page's checksum tells whether it is as it was written."""
        return any(True for _ in self.views(sink.root / archive))


class ParquetShard:
    """A file whose samples are read at any place, fast where they follow each other. Nothing stays open.

    Args:
        path: its file.

    Raises:
        FileFormatError: it is cut or damaged, or has other columns.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._seen: dict[str, tuple[int, dict[str, Any]]] = {}
        with _opened(path) as file:
            if not file.schema_arrow.equals(schema(), check_metadata=True):
                raise ValueError("it has other columns")
            groups = [file.read_row_group(group, _SMALL, use_threads=False) for group in range(file.num_row_groups)]
            self._ids = [group["id"].to_pylist() for group in groups]
        self._group_of = {one: group for group, ids in enumerate(self._ids) for one in ids}
        self.members = tuple(member_name(one, kind) for one in self._group_of for kind in KINDS)

    def read(self, name: str) -> bytes:
        """Return a sample's file of one kind.

        Raises:
            KeyError: there is none.
            FileFormatError: the file is damaged.
        """
        frame_id, kind = parse_member_name(name) or (name, "")
        group, column = self._group_of[frame_id], KINDS[kind].column
        if column not in self._seen or self._seen[column][0] != group:
            with _opened(self._path) as file:
                values = file.read_row_group(group, [column], use_threads=False)[column].to_pylist()
                self._seen[column] = (group, dict(zip(self._ids[group], values, strict=True)))
        value = self._seen[column][1][frame_id]
        if value is None:
            raise KeyError(name)
        return KINDS[kind].data(value)


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    try:
        with arrow().parquet.ParquetFile(path, page_checksum_verification=True) as file:
            yield file
    except (arrow().ArrowException, OSError, ValueError) as problem:
        reason = " ".join(str(problem).split())[:200]
        raise FileFormatError(f"no whole Parquet file of cadet's: {reason}", path.name) from None


def _chunks(files: Iterable[tuple[str, bytes]]) -> Iterator[bytes]:
    """Yield the bytes of a file, one group of rows after the other."""
    rows = (
        row_of_files(frame_id, {_parsed(name)[1]: data for name, data in of_frame})
        for frame_id, of_frame in groupby(files, key=lambda file: _parsed(file[0])[0])
    )
    out, table = io.BytesIO(), arrow().Table
    with arrow().parquet.ParquetWriter(
        out,
        schema(),
        compression="zstd",
        compression_level=3,
        use_dictionary=False,
        write_statistics=False,
        write_page_checksum=True,
    ) as writer:
        while some := list(islice(rows, _ROWS_AT_ONCE)):
            writer.write_table(table.from_pylist(some, schema()))
            yield _taken(out)
    yield _taken(out)


def _parsed(name: str) -> tuple[str, str]:
    parsed = parse_member_name(name)
    assert parsed is not None
    return parsed


def _taken(out: io.BytesIO) -> bytes:
    """Take what was written since the last call."""
    data = out.getvalue()
    out.seek(0)
    out.truncate()
    return data
