"""Names in shards: `000123.image_2.png` is the file `image_2/000123.png` of KITTI's folder.

A further camera's `cameras/rear/image_2/000123.png` is `000123.cameras.rear.image_2.png`.
"""

from __future__ import annotations

import re
from collections.abc import Container
from typing import Final

from cadet._util.checks import shown
from cadet.errors import CadetError
from cadet.formats.kitti.files.folder import CAMERAS, SUFFIXES, camera_kind, is_kind, read_suffixes, suffix_of

_KINDS: Final = {f"{kind}{suffix}": kind for kind in SUFFIXES for suffix in read_suffixes(kind)}
_RANKS: Final = {kind: rank for rank, kind in enumerate(SUFFIXES)}
_OF_CAMERA: Final = re.compile(rf"{CAMERAS}\.([^.]+)\.([^.]+\..+)")
_MOST_LETTERS: Final = 80
_ID: Final = rf"[0-9A-Za-z_+=@,()#~-]{{1,{_MOST_LETTERS}}}"
_NAME: Final = re.compile(rf"({_ID})\.(.+)")


def member_name(frame_id: str, kind: str, suffix: str | None = None) -> str:
    """Name a frame's file of one kind (see `files.folder.is_kind`), as `file_path` does in a folder.

    Raises:
        CadetError: an id with a dot, at which WebDataset cuts names, or with what an index or archive cannot hold.
    """
    if re.fullmatch(_ID, frame_id) is None:
        remedy = f"ASCII without dots and blanks, at most {_MOST_LETTERS} letters: rename its files"
        raise CadetError(f"frame {shown(frame_id)}: in shards ids are {remedy}")
    return f"{frame_id}.{kind.replace('/', '.')}{suffix or suffix_of(kind)}"


def found_member(members: Container[str], frame_id: str, kind: str) -> str | None:
    """Find a frame's file of one kind by each suffix that is read; None where there is none."""
    names = (member_name(frame_id, kind, suffix) for suffix in read_suffixes(kind))
    return next((name for name in names if name in members), None)


def parse_member_name(name: str) -> tuple[str, str] | None:
    """Return the frame's id and the kind of file; None for a name that no frame's file has."""
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    of_camera = _OF_CAMERA.fullmatch(found[2])
    kind = _KINDS.get(found[2] if of_camera is None else of_camera[2])
    if kind is not None and of_camera is not None:
        kind = camera_kind(of_camera[1], kind)
    return None if kind is None or not is_kind(kind) else (found[1], kind)


def kind_order(kind: str) -> tuple[str, int]:
    """Sort kinds by camera, then as KITTI's folders are listed."""
    camera, _, own = kind.rpartition("/")
    return camera, _RANKS[own]


def member_order(name: str) -> tuple[str, str, int]:
    """Sort members by frame, then by kind: one order of bytes, whoever wrote them first."""
    parsed = parse_member_name(name)
    return (name, "", 0) if parsed is None else (parsed[0], *kind_order(parsed[1]))
