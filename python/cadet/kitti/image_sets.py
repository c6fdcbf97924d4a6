"""The lists of frames under `ImageSets`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from cadet.errors import KittiFormatError, MissingFileError
from cadet.kitti.files import write_whole

_ID: Final = re.compile(r"[0-9]{6}")


@dataclass(frozen=True)
class ImageSet:
    """The ids of one split, in order.

    Attributes:
        ids: six-digit ids, none twice.
        ends_with_newline: whether the file does; KITTI's lists differ, kept so that text round trips.

    Raises:
        KittiFormatError: an id is not six digits or appears twice.
    """

    ids: tuple[str, ...]
    ends_with_newline: bool = field(default=True, compare=False, repr=False)

    def __post_init__(self) -> None:
        _check_ids(self.ids, "image set")

    def __len__(self) -> int:
        return len(self.ids)

    def __iter__(self) -> Iterator[str]:
        return iter(self.ids)

    @classmethod
    def from_text(cls, text: str, file: str = "image set") -> ImageSet:
        """Parse a list, one id a line.

        Args:
            text: the file's text.
            file: its name for messages.

        Raises:
            KittiFormatError: a line is not a six-digit id, or repeats one.
        """
        ends_with_newline = text.endswith("\n") or not text
        lines = text[:-1] if text.endswith("\n") else text
        ids = tuple(lines.split("\n")) if lines else ()
        _check_ids(ids, file)
        return cls(ids, ends_with_newline)

    def to_text(self) -> str:
        """Write the list, one id a line."""
        return "\n".join(self.ids) + ("\n" if self.ids and self.ends_with_newline else "")


def read_image_set(root: str | Path, split: str) -> ImageSet:
    """Read `root/ImageSets/<split>.txt`.

    Raises:
        MissingFileError: there is no such list.
        KittiFormatError: a line is not a six-digit id, or repeats one.
    """
    path = Path(root) / "ImageSets" / f"{split}.txt"
    if not path.is_file():
        raise MissingFileError(f"{path}: no such split")
    return ImageSet.from_text(path.read_text(encoding="ascii", errors="replace"), f"ImageSets/{path.name}")


def write_image_set(root: str | Path, split: str, image_set: ImageSet) -> None:
    """Write `root/ImageSets/<split>.txt`, whole or not at all."""
    write_whole({Path(root) / "ImageSets" / f"{split}.txt": image_set.to_text().encode("ascii")})


def _check_ids(ids: tuple[str, ...], file: str) -> None:
    seen: set[str] = set()
    for number, frame_id in enumerate(ids, start=1):
        if not _ID.fullmatch(frame_id):
            raise KittiFormatError(f"expected a six-digit id, got {frame_id!r}", file, number)
        if frame_id in seen:
            raise KittiFormatError(f"id {frame_id} appears twice", file, number)
        seen.add(frame_id)
