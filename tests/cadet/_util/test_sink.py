from __future__ import annotations

import errno
from collections.abc import Iterator
from pathlib import Path

import pytest

from cadet._util.sink import LocalSink


def test_objects_come_back_and_nothing_lies_aside(tmp_path: Path) -> None:
    sink = LocalSink(tmp_path)
    sink.put("a/b.txt", b"one")
    sink.put("a/b.txt", [b"t", b"wo"])
    assert sink.read("a/b.txt") == b"two"
    assert list((tmp_path / ".partial").iterdir()) == []
    sink.remove_partial()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    sink.put("c", b"")
    assert sink.read("c") == b""


def test_what_fails_half_way_leaves_the_old_object(tmp_path: Path) -> None:
    sink = LocalSink(tmp_path)
    sink.put("a/b.txt", b"old")

    def chunks() -> Iterator[bytes]:
        yield b"new"
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OSError, match="No space left on device") as caught:
        sink.put("a/b.txt", chunks())
    assert caught.value.filename == str(tmp_path / "a/b.txt")
    assert sink.read("a/b.txt") == b"old"
    assert list((tmp_path / ".partial").iterdir()) == []


def test_a_missing_object_is_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        LocalSink(tmp_path).read("nothing")
