"""Where ground truth and detections come from: folders or memory; and which frames count."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeAlias, TypeVar

from cadet._util.checks import as_tuple, is_one_of, shown
from cadet.errors import CadetError, MissingFileError
from cadet.evaluation.objects import Detections, GroundTruth
from cadet.evaluation.packed import Packed, pack, read_packed
from cadet.evaluation.projected import project_sides
from cadet.formats.kitti import ImageSet, Label, read_image_set
from cadet.formats.kitti.files.text import text_from_bytes
from cadet.formats.kitti.image_sets import check_not_empty

Objects = TypeVar("Objects", GroundTruth, Detections)
Frames: TypeAlias = "Mapping[str, Objects | Sequence[Label]] | Sequence[Objects | Sequence[Label]]"
GroundTruthSource: TypeAlias = "str | Path | Frames[GroundTruth]"
DetectionSource: TypeAlias = "str | Path | Frames[Detections]"
Split: TypeAlias = str | Path | Sequence[str]

FRAME_RULES: Final = ("results", "all")

BOXES_2D: Final = ("given", "project")

_SHOWN: Final = 3


@dataclass(frozen=True)
class Chosen:
    """The frames that count.

    Attributes:
        ids: of the frames.
        truths: a folder and the frames' ids, or objects in memory.
        detections: likewise; a frame without results has the id None.
        labels: the folder of the labels; None for ground truth in memory.
        num_missing: how many of the split, or of all, have no results.
        frames: the frame rule.
    """

    ids: tuple[str, ...]
    truths: tuple[Path, list[str | None]] | Packed[GroundTruth]
    detections: tuple[Path, list[str | None]] | Packed[Detections]
    labels: Path | None
    num_missing: int
    frames: str

    def sources(self) -> tuple[Any, Any]:
        """Return both sides as the core takes them."""
        truths, detections = self.truths, self.detections
        return (
            truths.source() if isinstance(truths, Packed) else truths,
            detections.source() if isinstance(detections, Packed) else detections,
        )

    def loaded(self) -> tuple[Packed[GroundTruth], Packed[Detections]]:
        """Return both sides in memory; files are read.

        Raises:
            KittiFormatError: a malformed line.
        """
        truths, detections = self.truths, self.detections
        return (
            truths if isinstance(truths, Packed) else read_packed(*truths, GroundTruth),
            detections if isinstance(detections, Packed) else read_packed(*detections, Detections),
        )


def choose(
    gt: GroundTruthSource, det: DetectionSource, split: Split | None, frames: str, boxes_2d: str = BOXES_2D[0]
) -> Chosen:
    """Apply the frame rule, and make 2D boxes if `boxes_2d` is "project".

    Raises:
        CadetError: an unknown rule, no frame, a frame with results but no ground truth, sequences of unequal length.
        MissingFileError: a folder or split that is not there.
    """
    if not is_one_of(boxes_2d, BOXES_2D):
        raise CadetError(f"boxes_2d: unknown {shown(boxes_2d)}, expected one of {', '.join(BOXES_2D)}")
    if not is_one_of(frames, FRAME_RULES):
        raise CadetError(f"frames: unknown rule {shown(frames)}, expected one of {', '.join(FRAME_RULES)}")
    holder = "testing" if isinstance(split, str) and split == "test" else "training"
    truths = _folder(gt, "label_2", holder) if isinstance(gt, str | Path) else _by_id(gt, "gt")
    detections = _folder(det, "data") if isinstance(det, str | Path) else _by_id(det, "det")
    _check_pairing(gt, det)
    labeled, found = _ids(truths), set(_ids(detections))
    if split is not None:
        known = _split_ids(split, truths if isinstance(truths, Path) else None)
    else:
        # A frame with results but no ground truth is an error, so it must not be left out here.
        known = tuple(sorted(found.union(labeled)))
    ids = known if frames == "all" else tuple(frame_id for frame_id in known if frame_id in found)
    if not ids:
        raise MissingFileError(f"{_name(det if known else gt)}: no frames: expected files such as 000000.txt")
    _check_labeled(ids, labeled, gt)
    results = [frame_id if frame_id in found else None for frame_id in ids]
    chosen = Chosen(
        ids=tuple(ids),
        truths=_side(truths, ids, GroundTruth),
        detections=_side(detections, results, Detections),
        labels=truths if isinstance(truths, Path) else None,
        num_missing=len(known) - sum(frame_id in found for frame_id in known),
        frames=frames,
    )
    return chosen if boxes_2d == BOXES_2D[0] else _projected(chosen)


def _projected(chosen: Chosen) -> Chosen:
    if chosen.labels is None:
        raise CadetError("boxes_2d: the ground truth is not a KITTI folder, so there is no calib to project with")
    truths, detections = project_sides(*chosen.loaded(), chosen.ids, chosen.labels.parent)
    return replace(chosen, truths=truths, detections=detections)


def _folder(path: str | Path, inner: str, holder: str = "training") -> Path:
    """Find the files of KITTI's usual layouts: the folder itself, or one inside."""
    path = Path(path)
    for folder in (path / inner, path / holder / inner):
        if folder.is_dir():
            return folder
    if not path.is_dir():
        raise MissingFileError(f"{path}: no such folder")
    return path


def _by_id(frames: Frames[Any], name: str) -> Mapping[str, Any]:
    if isinstance(frames, Mapping):
        return {str(frame_id): objects for frame_id, objects in frames.items()}
    if not isinstance(frames, Sequence):
        raise CadetError(f"{name}: expected a folder, or frames in a dictionary or a sequence, got {shown(frames)}")
    return {f"{index:06d}": objects for index, objects in enumerate(frames)}


def _check_pairing(gt: object, det: object) -> None:
    kinds = ["folder" if isinstance(side, str | Path | Mapping) else "sequence" for side in (gt, det)]
    if kinds[0] != kinds[1]:
        raise CadetError("a sequence of frames has no ids to pair with a folder's or a dictionary's: use a dictionary")
    if isinstance(gt, Sequence) and isinstance(det, Sequence) and kinds[0] == "sequence" and len(gt) != len(det):
        raise CadetError(f"detections: expected {len(gt)} frames as the ground truth has, got {len(det)}")


def _ids(side: Path | Mapping[str, Any]) -> tuple[str, ...]:
    if isinstance(side, Path):
        names = os.listdir(side)  # noqa: PTH208 - names alone
        return tuple(sorted(name.removesuffix(".txt") for name in names if name.endswith(".txt") and name[0] != "."))
    return tuple(sorted(side))


def _split_ids(split: Split, truths: Path | None) -> tuple[str, ...]:
    if isinstance(split, str | Path) and Path(split).suffix == ".txt":
        path = Path(split)
        if not path.is_file():
            raise MissingFileError(f"{path}: no such split")
        listed = ImageSet.from_text(text_from_bytes(path.read_bytes(), path.name, "utf-8"), path.name).ids
        if not listed:
            raise MissingFileError(f"{path} names no frames")
        return listed
    if isinstance(split, str | Path):
        if truths is None:
            raise CadetError(f"split: {shown(split)} is looked for beside the labels' folder; in memory, give the ids")
        roots = (truths, *truths.resolve().parents[:2])
        root = next((root for root in roots if (root / "ImageSets").is_dir()), None)
        if root is None:
            raise MissingFileError(f"{truths}: no ImageSets lies beside these labels; name a list's file as the split")
        named = read_image_set(root, str(split)).ids
        check_not_empty(named, root, str(split))
        return named
    ids = as_tuple("", "split", split, "ids")
    if not all(isinstance(frame_id, str) for frame_id in ids):
        raise CadetError(f"split: expected frames' ids, got {shown(ids)}")
    return tuple(dict.fromkeys(ids))


def _check_labeled(ids: Iterable[str], labeled: Sequence[str], gt: object) -> None:
    known = set(labeled)
    without = [frame_id for frame_id in ids if frame_id not in known]
    if without:
        raise MissingFileError(
            f"{_name(gt)}: frame {without[0]} has no ground truth: {len(without)} frames that count have none "
            f"({_few(without)}); the ground truth's are {_few(labeled) or 'none'}"
        )


def _few(ids: Sequence[str]) -> str:
    return ", ".join([*ids[:_SHOWN], *["..."] * (len(ids) > _SHOWN)])


def _name(source: object) -> str:
    return str(source) if isinstance(source, str | Path) else "in memory"


def _side(side: Path | Mapping[str, Any], ids: Sequence[str | None], kind: type[GroundTruth] | type[Detections]) -> Any:
    if isinstance(side, Path):
        return side, list(ids)
    return pack([_objects(() if frame_id is None else side[frame_id], kind, frame_id) for frame_id in ids], kind)


def _objects(given: Any, kind: type[GroundTruth] | type[Detections], frame_id: str | None) -> GroundTruth | Detections:
    if isinstance(given, kind):
        return given
    if isinstance(given, Sequence) and all(isinstance(label, Label) for label in given):
        return kind.from_labels(given)
    raise CadetError(f"frame {frame_id}: expected {kind.__name__} or labels, got {type(given).__name__}")
