"""The lists of frames under `ImageSets`."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from cadet.checks import as_path, check_text, is_one_of, shown
from cadet.errors import CadetError, KittiFormatError, MissingFileError
from cadet.kitti.files import write_whole
from cadet.summary import summary

_ID: Final = re.compile(r"[0-9]{6}")
_SPLITS: Final = ("train", "val")


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

    def __repr__(self) -> str:
        ends = f" from {self.ids[0]} to {self.ids[-1]}" if self.ids else ""
        return summary(self, f"{len(self.ids)} ids{ends}")

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
        # A blank line is no id, a lone one neither: other programs stop there.
        ids = tuple(text.removesuffix("\n").split("\n")) if text else ()
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
    check_text("", "split", split)
    path = _list_path(root, split)
    if not path.is_file():
        raise MissingFileError(f"{path}: no such split")
    return ImageSet.from_text(path.read_text(encoding="ascii", errors="replace"), f"ImageSets/{path.name}")


def write_image_set(root: str | Path, split: str, image_set: ImageSet) -> None:
    """Write `root/ImageSets/<split>.txt`, whole or not at all."""
    write_whole({_list_path(root, split): image_set.to_text().encode("ascii")})


def list_frame(root: str | Path, frame_id: str, split: str) -> None:
    """Put a frame into a split's list and into `trainval`, and make the other split's list where there is none.

    A list whose ids rise keeps them so; to another the id is appended. A frame that stands there already stays.

    Args:
        root: the dataset's folder.
        frame_id: six digits.
        split: "train" or "val".

    Raises:
        CadetError: another split, or the frame stands in the other's list.
        KittiFormatError: a list that is there already is malformed.
    """
    other = other_split(root, frame_id, split)
    for name in (split, "trainval"):
        ids = _listed(root, name)
        if frame_id not in ids:
            is_rising = list(ids) == sorted(ids)
            write_image_set(root, name, ImageSet(tuple(sorted((*ids, frame_id))) if is_rising else (*ids, frame_id)))
    if not _list_path(root, other).exists():
        write_image_set(root, other, ImageSet(()))


def other_split(root: str | Path, frame_id: str, split: str) -> str:
    """Return "val" for "train" and "train" for "val" if the frame may stand in `split`.

    Raises:
        CadetError: another split, or the frame stands in the other's list.
        KittiFormatError: the other's list is malformed.
    """
    if not is_one_of(split, _SPLITS):
        raise CadetError(f"split: expected {' or '.join(_SPLITS)}, or None for no list, got {shown(split)}")
    other = _SPLITS[1 - _SPLITS.index(split)]
    if frame_id in _listed(root, other):
        raise CadetError(f"{_list_path(root, other)}: frame {frame_id} is listed there; pass split={other!r}")
    return other


def _list_path(root: str | Path, split: str) -> Path:
    return as_path("root", root) / "ImageSets" / as_path("split", f"{split}.txt")


def _listed(root: str | Path, split: str) -> tuple[str, ...]:
    return read_image_set(root, split).ids if _list_path(root, split).is_file() else ()


def check_not_empty(ids: Collection[str], root: str | Path, split: str | None) -> None:
    """Refuse a choice of no frames, and name the lists that have some.

    Args:
        ids: of the frames that were chosen.
        root: the folder that holds `ImageSets`.
        split: the list that was read; None for every frame.

    Raises:
        MissingFileError: there is no frame.
    """
    if ids:
        return
    if split is None:
        raise MissingFileError(f"{root}: no frames")
    folder = Path(root) / "ImageSets"
    counts = {path.stem: len(path.read_bytes().split()) for path in sorted(folder.glob("*.txt"))}
    others = ", ".join(f"{name} ({count})" for name, count in counts.items() if count)
    instead = f"choose another list: {others}" if others else "no other list there names any"
    if split == "val":
        instead += "; cadet-gen writes validation frames from the 21st on: -n 40 gives 20"
    raise MissingFileError(f"{folder / split}.txt names no frames; {instead}")


def _check_ids(ids: tuple[str, ...], file: str) -> None:
    seen: set[str] = set()
    for number, frame_id in enumerate(ids, start=1):
        if not _ID.fullmatch(frame_id):
            raise KittiFormatError(f"expected a six-digit id, got {frame_id!r}", file, number)
        if frame_id in seen:
            raise KittiFormatError(f"id {frame_id} appears twice", file, number)
        seen.add(frame_id)
