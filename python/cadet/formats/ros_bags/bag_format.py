"""MCAP files of episodes, as what a packing sink writes and reads: a member is the messages of one sample."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path
from typing import Any, Final

from cadet._util.sink import LocalSink
from cadet.errors import CadetError, FileFormatError
from cadet.formats.ros_bags.message_block import Message, block_of_bytes, bytes_of_block
from cadet.formats.ros_bags.message_types import definition, load
from cadet.formats.ros_bags.messages import ODOMETRY

MEMBER: Final = ".messages"
_LIBRARY: Final = "cadet"
_AT_ONCE: Final = 1
"""Bytes of a chunk: each message is one, so that a reader of one topic reads no other's."""


class BagFormat:
    """See `cadet.formats.packing_sink.ArchiveFormat`."""

    suffix = ".mcap"

    def views(self, path: Path) -> Iterator[Bag]:
        """Yield the bag, if it can be read."""
        try:
            yield Bag(path)
        except CadetError:
            return

    def order(self, name: str) -> str:
        """Sort by the samples' numbers."""
        return name

    def write(self, sink: LocalSink, archive: str, files: Iterable[tuple[str, bytes]]) -> None:
        """Write the messages in the order of their samples."""
        sink.put(archive, _chunks(files))

    def is_sound(self, sink: LocalSink, archive: str) -> bool:
        """Tell whether the bag is to the last byte what its messages give."""
        path = sink.root / archive
        try:
            bag = Bag(path)
            with path.open("rb") as file:
                chunks = _chunks((name, bag.read(name)) for name in bag.members)
                return all(file.read(len(chunk)) == chunk for chunk in chunks) and not file.read(1)
        except CadetError:
            return False


class Bag:
    """A bag whose samples are read one after the other.

    Args:
        path: its file.

    Raises:
        FileFormatError: it is cut or damaged.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._samples: Iterator[tuple[int, bytes]] = iter(())
        self._last: int | None = None
        found = [message.sequence for _, _, message in self._messages([ODOMETRY])]
        self.members = tuple(f"{number:06d}{MEMBER}" for number in found)

    def read(self, name: str) -> bytes:
        """Return the messages of a sample, fast where it follows the one that was read last.

        Raises:
            KeyError: there is none.
            FileFormatError: the bag is damaged.
        """
        number = int(name.removesuffix(MEMBER))
        if self._last is None or number <= self._last:
            self._samples = self._blocks()
        self._last = None
        for found, block in self._samples:
            self._last = found
            if found == number:
                return block
        self._last = None
        raise KeyError(name)

    def _blocks(self) -> Iterator[tuple[int, bytes]]:
        for number, rows in groupby(self._messages(None), key=lambda row: row[2].sequence):
            found = list(rows)
            messages = [Message(channel.topic, schema.name, message.data) for schema, channel, message in found]
            yield number, bytes_of_block(found[0][2].log_time, messages)

    def _messages(self, topics: list[str] | None) -> Iterator[tuple[Any, Any, Any]]:
        """Yield schema, channel, and message in the order of the file."""
        reader, error = load("mcap.reader"), load("mcap.exceptions").McapError
        try:
            with self._path.open("rb") as file:
                bag = reader.make_reader(file, validate_crcs=True)
                if bag.get_summary() is None:
                    raise FileFormatError("it has no end", self._path.name)
                yield from bag.iter_messages(topics, log_time_order=False)
        except (error, struct.error, ValueError, KeyError, EOFError, OverflowError, MemoryError) as problem:
            reason = " ".join(str(problem).split())[:200]
            raise FileFormatError(f"no whole MCAP file: {reason}", self._path.name) from None


def _chunks(files: Iterable[tuple[str, bytes]]) -> Iterator[bytes]:
    """Yield the bytes of a bag: not compressed, since images are, and libraries' versions compress differently."""
    mcap = load("mcap.writer")
    out = _Pipe()
    writer = mcap.Writer(out, chunk_size=_AT_ONCE, compression=mcap.CompressionType.NONE)
    writer.start(profile="ros2", library=_LIBRARY)
    schemas: dict[str, int] = {}
    channels: dict[str, int] = {}
    for name, data in files:
        stamp_ns, messages = block_of_bytes(data)
        for topic, kind, content in messages:
            if kind not in schemas:
                schemas[kind] = writer.register_schema(kind, "ros2msg", definition(kind).encode("ascii"))
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "cdr", schemas[kind])
            number = int(name.removesuffix(MEMBER))
            writer.add_message(channels[topic], stamp_ns, content, stamp_ns, sequence=number)
        yield out.taken()
    writer.finish()
    yield out.taken()


class _Pipe:
    """What takes the writer's bytes until they are taken on."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._at = 0

    def write(self, data: bytes) -> int:
        """Take bytes."""
        self._parts.append(bytes(data))
        self._at += len(data)
        return len(data)

    def tell(self) -> int:
        """Return how many bytes were taken in all."""
        return self._at

    def taken(self) -> bytes:
        """Return what was written since the last call."""
        parts, self._parts = self._parts, []
        return b"".join(parts)
