"""Names in shards: `000123.image_2.png` is the file `image_2/000123.png` of KITTI's folder."""

from __future__ import annotations

import re
from collections.abc import Container
from typing import Final

from cadet._util.checks import shown
from cadet.errors import CadetError
from cadet.formats.kitti.files.folder import SUFFIXES, read_suffixes

_KINDS: Final = {f"{kind}{suffix}": kind for kind in SUFFIXES for suffix in read_suffixes(kind)}
_RANKS: Final = {kind: rank for rank, kind in enumerate(SUFFIXES)}
_MOST_LETTERS: Final = 80
_ID: Final = rf"[0-9A-Za-z_+=@,()#~-]{{1,{_MOST_LETTERS}}}"
_NAME: Final = re.compile(rf"({_ID})\.(.+)")


def member_name(frame_id: str, kind: str, suffix: str | None = None) -> str:
    """Name a frame's file of one kind (a key of `files.folder.SUFFIXES`), as `file_path` does in a folder.

    Raises:
        CadetError: an id with a dot, at which WebDataset cuts names, or with what an index or archive cannot hold.
    """
    if re.fullmatch(_ID, frame_id) is None:
        remedy = f"ASCII without dots and blanks, at most {_MOST_LETTERS} letters: rename its files"
        raise CadetError(f"frame {shown(frame_id)}: in shards ids are {remedy}")
    return f"{frame_id}.{kind}{suffix or SUFFIXES[kind]}"


def found_member(members: Container[str], frame_id: str, kind: str) -> str | None:
    """Find a frame's file of one kind by each suffix that is read; None where there is none."""
    names = (member_name(frame_id, kind, suffix) for suffix in read_suffixes(kind))
    return next((name for name in names if name in members), None)


def parse_member_name(name: str) -> tuple[str, str] | None:
    """Return the frame's id and the kind of file; None for a name that no frame's file has."""
    found = _NAME.fullmatch(name)
    kind = None if found is None else _KINDS.get(found[2])
    return None if found is None or kind is None else (found[1], kind)


def member_order(name: str) -> tuple[str, int]:
    """Sort members by frame, then as KITTI's folders are listed: one order of bytes, whoever wrote them first."""
    parsed = parse_member_name(name)
    return (name, 0) if parsed is None else (parsed[0], _RANKS[parsed[1]])
