"""One sample's messages as the bytes that wait for their bag: a line of JSON, then the messages."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import NamedTuple


class Message(NamedTuple):
    """A message in CDR."""

    topic: str
    """Its topic."""
    type: str
    """Its type's name, such as "sensor_msgs/msg/PointCloud2"."""
    data: bytes
    """The message."""


def bytes_of_block(stamp_ns: int, messages: Sequence[Message]) -> bytes:
    """Return messages of one time."""
    sizes = [(message.topic, message.type, len(message.data)) for message in messages]
    head = json.dumps([stamp_ns, sizes], separators=(",", ":"))
    return b"".join([head.encode("ascii"), b"\n", *(message.data for message in messages)])


def block_of_bytes(data: bytes) -> tuple[int, list[Message]]:
    """Return the time and the messages that `bytes_of_block` was given."""
    start = data.index(b"\n") + 1
    stamp_ns, sizes = json.loads(data[:start])
    messages = []
    for topic, kind, size in sizes:
        messages.append(Message(topic, kind, data[start : start + size]))
        start += size
    return stamp_ns, messages
