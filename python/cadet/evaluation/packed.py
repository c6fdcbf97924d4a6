"""The objects of many frames, one after the other: what the core compares and what is computed by columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet.evaluation.objects import Detections, GroundTruth

Objects = TypeVar("Objects", GroundTruth, Detections)
CoreSource = tuple[list[int], list[str], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Packed(Generic[Objects]):
    """The objects of F frames.

    Attributes:
        starts: (F + 1,) int64; the objects of frame f are those from `starts[f]` up to `starts[f + 1]`.
        objects: all of them, in the order of the frames and of their files.
    """

    starts: NDArray[np.int64]
    objects: Objects

    def __len__(self) -> int:
        return len(self.starts) - 1

    @property
    def types(self) -> NDArray[np.str_]:
        """(n,) the types' names."""
        return np.array(self.objects.types, np.str_).reshape(-1)

    @property
    def frames(self) -> NDArray[np.int64]:
        """(n,) the index of each object's frame."""
        return np.repeat(np.arange(len(self)), np.diff(self.starts))

    def source(self) -> CoreSource:
        """Return the objects as the core takes them from memory."""
        return self.starts.tolist(), list(self.objects.types), np.ascontiguousarray(self.objects.rows())

    def changed(self, **columns: Any) -> Packed[Objects]:
        """Return the same objects with other columns, such as `boxes_cam`."""
        return replace(self, objects=replace(self.objects, **columns))

    def kept(self, is_kept: NDArray[np.bool_]) -> Packed[Objects]:
        """Return some of the objects, in as many frames."""
        names = [name for name in self.objects.__dataclass_fields__ if name != "types"]
        columns: dict[str, Any] = {name: getattr(self.objects, name)[is_kept] for name in names}
        columns["types"] = tuple(self.types[is_kept].tolist())
        counts = np.bincount(self.frames[is_kept], minlength=len(self))
        return Packed(np.concatenate([[0], np.cumsum(counts)]).astype(np.int64), replace(self.objects, **columns))


def pack(objects: Sequence[Objects], kind: type[Objects]) -> Packed[Objects]:
    """Put the objects of frames one after the other."""
    starts = np.cumsum([0, *(len(frame.types) for frame in objects)])
    empty = _from_rows([], np.zeros((0, kind_columns(kind))), kind)
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(frame, name) for frame in (*objects, empty)])
        for name in kind.__dataclass_fields__
        if name != "types"
    }
    names = tuple(name for frame in objects for name in frame.types)
    return Packed(starts.astype(np.int64), kind(types=names, **columns))


def read_packed(folder: Path, ids: Sequence[str | None], kind: type[Objects]) -> Packed[Objects]:
    """Read label or result files, as the core's own evaluation of folders does.

    Raises:
        KittiFormatError: a malformed line, named with file, line and column.
        MissingFileError: a file that is not there.
    """
    read = _cadet.read_truths if kind is GroundTruth else _cadet.read_detections
    starts, names, rows = read(folder, list(ids))
    return Packed(np.array(starts, np.int64), _from_rows(names, rows, kind))


def kind_columns(kind: type[Objects]) -> int:
    """Return how many numbers the core takes of an object."""
    return 15 if kind is GroundTruth else 14


def _from_rows(names: Sequence[str], rows: NDArray[np.float64], kind: type[Objects]) -> Objects:
    """Take rows apart, the reverse of `rows()`."""
    lead = 2 if kind is GroundTruth else 0
    columns: dict[str, Any] = {
        "alphas": rows[:, lead],
        "boxes_img": rows[:, lead + 1 : lead + 5],
        "boxes_cam": rows[:, lead + 5 : lead + 12],
        "optional": rows[:, -1] != 0.0,
    }
    if kind is GroundTruth:
        columns |= {"truncated": rows[:, 0], "occluded": rows[:, 1]}
    else:
        columns["scores"] = rows[:, -2]
    return kind(types=tuple(names), **columns)
