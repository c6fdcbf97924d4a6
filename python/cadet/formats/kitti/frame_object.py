"""The objects of a frame: a line of its labels and what else the generator knows of it, in one place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import shown
from cadet._util.summary import summary
from cadet.errors import CadetError
from cadet.formats.kitti.label import Label

_NUMBERS: Final = {"actor_id": 0, "visible_fraction": 0, "num_points": 0, "velocity_world": 3, "location_cam": 3} | {
    "dimensions_hwl": 3,
    "rotation_y": 0,
}
"""The entries of `meta["objects"]` that are read, and of how many numbers each is; 0 for one that stands alone."""


@dataclass(frozen=True, eq=False)
class FrameObject:
    """An object that the camera sees.

    Attributes:
        type: its class, such as "Car", even if its label is a DontCare region.
        label: its line of the labels; a DontCare region for an object that is seen and gets no label.
        box_cam: (7,) float64 [x, y, z, l, w, h, rotation_y], bottom center in the cam frame, meters and radians.
        id: as in `Frame.instance`, the same in every frame of an episode.
        model: its model's name.
        visible_fraction: of its silhouette, the share of pixels that nothing hides.
        num_points: returns on it.
        velocity_world: (x, y, z) in m/s.

    All but the first three are None where nothing but KITTI's label is known.
    """

    type: str
    label: Label
    box_cam: NDArray[np.float64]
    id: int | None = None
    model: str | None = None
    visible_fraction: float | None = None
    num_points: int | None = None
    velocity_world: tuple[float, float, float] | None = None

    @property
    def is_labeled(self) -> bool:
        """Whether it gets a label, rather than a DontCare region."""
        return not self.label.is_dont_care

    def __repr__(self) -> str:
        x, y, z = np.round(self.box_cam[:3], 2).tolist()
        known = {name: getattr(self, name) for name in ("id", "visible_fraction", "num_points", "velocity_world")}
        return summary(self, f"at {(x, y, z)} in the cam frame", type=self.type, **known, is_labeled=self.is_labeled)


def objects_of(labels: tuple[Label, ...], meta: Mapping[str, Any] | None) -> tuple[FrameObject, ...]:
    """Join labels with what a `meta` says of them, line by line.

    Without it the labels are all that is known, and DontCare regions, which stand for no object, are left out.

    Raises:
        CadetError: `meta["objects"]` is malformed, or has not one entry for each label.
    """
    entries = None if meta is None else meta.get("objects")
    if entries is None:
        return tuple(FrameObject(label.type, label, label.box_cam) for label in labels if not label.is_dont_care)
    if not isinstance(entries, list) or len(entries) != len(labels):
        count = len(entries) if isinstance(entries, list) else shown(entries)
        raise CadetError(
            f"objects: {len(labels)} labels, and {count} in meta: filter frame.objects rather than frame.labels"
        )
    return tuple(_object(index, *pair) for index, pair in enumerate(zip(labels, entries, strict=True)))


def _object(index: int, label: Label, entry: Any) -> FrameObject:
    where = f"meta.objects[{index}]"
    if not isinstance(entry, Mapping):
        raise CadetError(f"{where}: expected a table, got {shown(entry)}")
    for name in ("type", "model"):
        if not isinstance(entry.get(name), str):
            raise CadetError(f"{where}.{name}: expected a string, got {shown(entry.get(name))}")
    found: dict[str, Any] = {}
    for name, count in _NUMBERS.items():
        values = np.asarray(entry.get(name), object)
        if values.shape != ((count,) if count else ()) or not all(isinstance(v, (int, float)) for v in values.flat):
            wanted = f"{count} numbers" if count else "a number"
            raise CadetError(f"{where}.{name}: expected {wanted}, got {shown(entry.get(name))}")
        found[name] = tuple(map(float, values)) if count else values.item()
    height, width, length = found["dimensions_hwl"]
    return FrameObject(
        type=entry["type"],
        label=label,
        box_cam=np.array([*found["location_cam"], length, width, height, found["rotation_y"]]),
        id=int(found["actor_id"]),
        model=entry["model"],
        visible_fraction=float(found["visible_fraction"]),
        num_points=int(found["num_points"]),
        velocity_world=found["velocity_world"],
    )
