"""The index of a shard: where each member lies, in the text format that NVIDIA DALI's WebDataset reader takes.

Its first line is the format's version and the number of samples. Each other line is a sample: of each of its files the
extension, the offset and size of its data in bytes, and its name in the archive.
Source: DALI's documentation of `readers.webdataset` and the output of its tool `wds2idx`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import groupby
from typing import Final

from cadet._util.checks import shown
from cadet.formats.webdataset.member import ArchiveError, Member, check_member_name
from cadet.formats.webdataset.tar_reading import MAX_MEMBER_BYTES, MAX_MEMBERS

SUFFIX: Final = ".idx"
"""Stands in place of an archive's `.tar`."""
_VERSION: Final = "v1.2"
_NUMBER: Final = re.compile(r"[0-9]{1,15}")
_FIELDS: Final = 4


def text_from_index(members: Mapping[str, Member]) -> str:
    """Return the index of an archive; files of one sample must stand together."""
    samples = [list(files) for _, files in groupby(members.items(), key=lambda item: _split(item[0])[0])]
    lines = [f"{_VERSION} {len(samples)}\n"]
    for files in samples:
        fields = (f"{_split(name)[1]} {member.offset} {member.size} {name}" for name, member in files)
        lines.append(" ".join(fields) + "\n")
    return "".join(lines)


def index_from_text(text: str, name: str) -> dict[str, Member]:
    """Parse an index.

    Args:
        text: the file's text.
        name: its name for messages.

    Returns:
        Where each file's data should lie, by its name: a claim of this file's, which says nothing of the archive yet.

    Raises:
        ArchiveError: another format or version, a cut or malformed line, or what `read_members` refuses.
    """
    head, *lines = text.split("\n")
    if re.fullmatch(rf"{re.escape(_VERSION)} [0-9]{{1,9}}", head) is None:
        raise ArchiveError(f"expected {_VERSION!r} and a number of samples, got {shown(head)}", name, 1)
    if lines.pop() if lines else True:
        raise ArchiveError("the last line has no end: the file is cut", name, len(lines) + 2)
    if len(lines) != int(head.split(" ")[1]):
        raise ArchiveError(f"{len(lines)} samples, and its first line says {head.split(' ')[1]}", name)
    members: dict[str, Member] = {}
    for number, line in enumerate(lines, start=2):
        fields = line.split(" ")
        if len(fields) % _FIELDS:
            raise ArchiveError(f"expected four fields for each file, got {len(fields)} in all", name, number)
        for at in range(0, len(fields), _FIELDS):
            file_name, member = _parsed(fields[at : at + _FIELDS], name, number)
            if file_name in members:
                raise ArchiveError(f"the member {shown(file_name)} appears twice", name, number)
            members[file_name] = member
        if len(members) > MAX_MEMBERS:
            raise ArchiveError(f"more than {MAX_MEMBERS} members", name, number)
    return members


def _parsed(fields: list[str], name: str, number: int) -> tuple[str, Member]:
    _, offset, size, file_name = fields
    if not _NUMBER.fullmatch(offset) or not _NUMBER.fullmatch(size) or int(size) > MAX_MEMBER_BYTES:
        raise ArchiveError(
            f"the member {shown(file_name)}: expected an offset and at most {MAX_MEMBER_BYTES} bytes, "
            f"got {shown(offset)} and {shown(size)}",
            name,
            number,
        )
    return check_member_name(file_name, name), Member(int(offset), int(size))


def _split(name: str) -> tuple[str, str]:
    """Return a file's sample and extension, which begins at the first dot of its last part."""
    folder, slash, last = name.rpartition("/")
    sample, _, extension = last.partition(".")
    return f"{folder}{slash}{sample}", extension
