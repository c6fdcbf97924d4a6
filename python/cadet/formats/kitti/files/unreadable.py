"""Frames that cannot be read: left out, counted and named, unless there are too many to go on without them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Protocol

from cadet._util.notices import notice
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.folder import REQUIRED, SUFFIXES
from cadet.formats.kitti.files.other_layouts import instead

READING_ERRORS: Final = (CadetError, OSError)
"""What reading a frame raises."""
_NAMED: Final = 3


class Unreadable:
    """The frames of a dataset that cannot be read.

    Args:
        root: the dataset, for messages.
    """

    def __init__(self, root: str | Path) -> None:
        self._root = root
        self._errors: dict[str, CadetError | OSError] = {}

    def add(self, frame_id: str, error: CadetError | OSError) -> None:
        """Add a frame and what reading it raised."""
        self._errors[frame_id] = error

    def __contains__(self, frame_id: object) -> bool:
        return frame_id in self._errors

    def __len__(self) -> int:
        return len(self._errors)

    def text(self, total: int) -> str:
        """Say how many of `total` frames cannot be read, and why the first of them."""
        named = "; ".join(f"{frame_id}: {error}" for frame_id, error in list(self._errors.items())[:_NAMED])
        more = f"; and {len(self) - _NAMED} more" if len(self) > _NAMED else ""
        return f"{self._root}: {len(self)} of {total} frames cannot be read ({named}{more})"

    def say(self, total: int) -> None:
        """Warn of the frames that are left out; nothing if there are none.

        Raises:
            CadetError: more than half of the frames cannot be read.
        """
        if 2 * len(self) > total:
            raise CadetError(f"{self.text(total)}: more than half; `cadet check` lists them all")
        self.warn(total, "are left out")

    def warn(self, total: int, consequence: str) -> None:
        """Warn of the frames, if there are any, and of what comes of it."""
        if self._errors:
            notice([f"{self.text(total)} and {consequence}; `cadet check` lists them all"], about="unreadable")


class Frames(Protocol):
    """A dataset's frames: `cadet.kitti.Dataset`, or shards."""

    ids: tuple[str, ...]

    @property
    def folder(self) -> Path:
        """The folder that holds the frames' folders, or archives."""

    def has(self, kind: str, frame_id: str) -> bool:
        """Tell whether a frame has a file of one kind."""


def frames_with_files(
    frames: Frames, unreadable: Unreadable, root: str | Path, kinds: Sequence[str] = REQUIRED
) -> tuple[str, ...]:
    """Return the ids of the frames that have their files; the others become unreadable.

    Args:
        frames: of a folder or of shards.
        unreadable: gets the frames that lack a file.
        root: the dataset, for messages.
        kinds: of the files that are needed.

    Raises:
        MissingFileError: no frame at all has one of these files.
    """
    missing = {kind: [one for one in frames.ids if not frames.has(kind, one)] for kind in kinds}
    for kind, ids in missing.items():
        if ids and len(ids) == len(frames.ids):
            remedy = instead(frames.folder, kind)
            raise MissingFileError(f"{root}: none of {len(ids)} frames has a file in {kind}, which is needed{remedy}")
        for frame_id in ids:
            unreadable.add(frame_id, MissingFileError(f"{kind}/{frame_id}{SUFFIXES[kind]} is missing"))
    return tuple(one for one in frames.ids if one not in unreadable)
