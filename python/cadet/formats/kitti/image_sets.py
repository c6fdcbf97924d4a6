"""The lists of frames under `ImageSets`."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path, PurePosixPath
from typing import Final

from cadet._util.checks import as_path, check_text, is_one_of, shown
from cadet._util.summary import summary
from cadet._util.user_files import read_file
from cadet.errors import CadetError, FileFormatError, KittiFormatError, MissingFileError
from cadet.formats.kitti.files.dialects import accept
from cadet.formats.kitti.files.folder import REQUIRED, is_id, sample_folder, set_root, write_whole
from cadet.formats.kitti.files.other_layouts import no_frames

LISTS: Final = "ImageSets"
_SPLITS: Final = ("train", "val")
_BESIDE: Final = ("train", "val", "trainval", "test")
"""Lists that may lie beside `training`, where AVOD looks for them."""
_FILE_SUFFIXES: Final = (".png", ".jpg", ".jpeg", ".bin", ".txt")


@dataclass(frozen=True)
class ImageSet:
    """The ids of one split, in order.

    Attributes:
        ids: stems of frames' files, none twice.
        ends_with_newline: whether the file does; KITTI's lists differ, kept so that text round trips.

    Raises:
        KittiFormatError: an id that no file can have, or one that appears twice.
    """

    ids: tuple[str, ...]
    ends_with_newline: bool = field(default=True, compare=False, repr=False)

    def __post_init__(self) -> None:
        _check_ids(self.ids, "image set", count(1))

    def __repr__(self) -> str:
        ends = f" from {self.ids[0]} to {self.ids[-1]}" if self.ids else ""
        return summary(self, f"{len(self.ids)} ids{ends}")

    def __len__(self) -> int:
        return len(self.ids)

    def __iter__(self) -> Iterator[str]:
        return iter(self.ids)

    @classmethod
    def from_text(cls, text: str, file: str = "image set") -> ImageSet:
        """Parse a list, one id a line. Blank lines are passed over, and of paths the stem is taken.

        Args:
            text: the file's text.
            file: its name for messages.

        Raises:
            KittiFormatError: a line holds what no id can be, or repeats one.
        """
        ids: list[str] = []
        places: list[int] = []
        odd: dict[str, int] = {}
        lines = text.removesuffix("\n").split("\n") if text else []
        for number, line in enumerate(map(str.strip, lines), start=1):
            frame_id = _stem(line)
            if frame_id:
                ids.append(frame_id)
                places.append(number)
            if frame_id != line or not line:
                odd.setdefault("a file's name is read as its frame's id" if line else "a blank line is ignored", number)
        for message, number in odd.items():
            accept("list-line", f"{message}: other programs expect an id on every line", file, number)
        _check_ids(ids, file, places)
        return cls(tuple(ids), text.endswith("\n") or not text)

    def to_text(self) -> str:
        """Write the list, one id a line."""
        return "\n".join(self.ids) + ("\n" if self.ids and self.ends_with_newline else "")


def list_paths(root: str | Path) -> dict[str, Path]:
    """Return the lists of a dataset by split: those of `ImageSets`, or those beside `training` where it has none."""
    place = set_root(root)
    paths = {path.stem: path for path in sorted((place / LISTS).glob("*.txt"))}
    return paths or {split: path for split in _BESIDE if (path := place / f"{split}.txt").is_file()}


def read_image_set(root: str | Path, split: str) -> ImageSet:
    """Read the list of a split: `root/ImageSets/<split>.txt`, or what `list_paths` finds.

    Raises:
        MissingFileError: there is no such list.
        KittiFormatError: a line holds what no id can be, or repeats one.
    """
    check_text("", "split", split)
    path = _list_path(root, split)
    if not path.is_file():
        raise MissingFileError(f"{path}: no such split")
    return read_list(path)


def read_list(path: Path) -> ImageSet:
    """Read the file of a list.

    Raises:
        KittiFormatError: not UTF-8, or a line holds what no id can be, or repeats one.
    """
    name = list_name(path)
    try:
        text = list_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise KittiFormatError(f"not UTF-8 ({error.reason}): save the list as UTF-8 or ASCII", name) from None
    if path.parent.name != LISTS:
        accept("list-place", f"a list beside the frames' folder is read: others look for it in {LISTS}", name)
    return ImageSet.from_text(text, name)


def list_name(path: Path) -> str:
    """Name a list in messages."""
    return f"{LISTS}/{path.name}" if path.parent.name == LISTS else path.name


def list_bytes(path: Path) -> bytes:
    """Return the bytes of a list.

    Raises:
        KittiFormatError: not a regular file.
    """
    try:
        return read_file(path, name=list_name(path))
    except FileFormatError as error:
        raise KittiFormatError(error.reason, error.file) from None


def write_image_set(root: str | Path, split: str, image_set: ImageSet) -> None:
    """Write `root/ImageSets/<split>.txt`, whole or not at all."""
    path = as_path("root", root) / LISTS / as_path("split", f"{split}.txt")
    write_whole({path: image_set.to_text().encode("utf-8")})


def list_frame(root: str | Path, frame_id: str, split: str) -> None:
    """Put a frame into a split's list and into `trainval`, and make the other split's list where there is none.

    A list whose ids rise keeps them so; to another the id is appended. A frame that stands there already stays.

    Args:
        root: the dataset's folder.
        frame_id: of the frame.
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
    file = as_path("split", f"{split}.txt")
    return list_paths(root).get(split, set_root(root) / LISTS / file)


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
        raise MissingFileError(no_frames(Path(root), sample_folder(root), REQUIRED))
    sizes = {name: len(list_bytes(path).split()) for name, path in list_paths(root).items()}
    others = ", ".join(f"{name} ({size})" for name, size in sizes.items() if size)
    instead = f"choose another list: {others}" if others else "no other list there names any"
    if split == "val":
        instead += "; cadet-gen writes validation frames from the 21st on: -n 40 gives 20"
    raise MissingFileError(f"{_list_path(root, split)} names no frames; {instead}")


def _stem(line: str) -> str:
    """Return the id that a line of a list means: the stem, where it names a file."""
    name = PurePosixPath(line.replace("\\", "/")).name
    return next((name.removesuffix(suffix) for suffix in _FILE_SUFFIXES if name.endswith(suffix)), name)


def _check_ids(ids: Sequence[str], file: str, lines: Iterable[int]) -> None:
    seen: set[str] = set()
    for number, frame_id in zip(lines, ids, strict=False):
        if not isinstance(frame_id, str) or not is_id(frame_id):
            raise KittiFormatError(f"expected a frame's id such as 000012, got {shown(frame_id)}", file, number)
        if frame_id in seen:
            raise KittiFormatError(f"id {frame_id} appears twice", file, number)
        seen.add(frame_id)
