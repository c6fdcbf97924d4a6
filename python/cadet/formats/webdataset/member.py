"""A file in an archive: where it lies, and the names that it may have."""

from __future__ import annotations

from typing import NamedTuple

from cadet._util.checks import MAX_PATH_BYTES, shown
from cadet.errors import FileFormatError


class ArchiveError(FileFormatError):
    """An archive that is damaged, or that holds what no dataset's does: `FileFormatError`'s arguments."""


class Member(NamedTuple):
    """Where a file's data lies in its archive."""

    offset: int
    """Of its first byte."""
    size: int
    """In bytes."""


def check_member_name(name: str, archive: str) -> str:
    """Return a member's name without the parts that mean nothing: `./a//b/` is `a/b`.

    Raises:
        ArchiveError: an absolute name, one that leads out of a folder, or one that no file has everywhere.
    """
    parts = [part for part in name.split("/") if part not in ("", ".")]
    if name.startswith(("/", "\\")) or name[1:2] == ":":
        raise ArchiveError(f"the member {shown(name)} has an absolute name", archive)
    if ".." in parts:
        raise ArchiveError(f"the member {shown(name)} leads out of its folder", archive)
    if not name.isascii() or not name.isprintable() or "\\" in name or len(name) > MAX_PATH_BYTES:
        raise ArchiveError(f"the member {shown(name)} has a name that is not a plain path", archive)
    return "/".join(parts)
