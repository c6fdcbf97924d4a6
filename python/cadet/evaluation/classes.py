"""Classes of the evaluation: the types of each, those that are neither right nor wrong, and the limits of overlap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from cadet._util.checks import as_tuple, check_text, shown
from cadet.errors import CadetError
from cadet.evaluation.limits import METRICS, MinOverlap, class_limits, resolve_limits
from cadet.formats.kitti.label import is_object_type, kitti_spelling

NEIGHBORS: Final = {"Car": ("Van",), "Pedestrian": ("Person_sitting",)}
"""KITTI's neighbors: finding one as the class is neither right nor wrong."""


@dataclass(frozen=True)
class EvalClass:
    """A class: objects and detections of its types are one another's.

    Attributes:
        name: the class's name in reports.
        types: the names in labels and results that belong to it.
        min_overlap: 2D, BEV and 3D overlap that a detection must exceed; one number for all three, or a dictionary by
            metric.
        neighbors: types of objects that may be taken for this class: neither right nor wrong.

    Raises:
        CadetError: an empty name, what is no type's name, a type among its own neighbors, a limit outside
            0 <= limit < 1.
    """

    name: str
    types: tuple[str, ...]
    min_overlap: tuple[float, float, float]
    neighbors: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_text("EvalClass", "name", self.name)
        if not self.name:
            raise CadetError("class: its name is empty")
        owner = f"class {self.name}"
        for field in ("types", "neighbors"):
            names = as_tuple(owner, field, getattr(self, field), "names")
            for name in names:
                if not is_object_type(name):
                    raise CadetError(f"{owner}.{field}: expected types of labels such as Car, got {shown(name)}")
            object.__setattr__(self, field, tuple(dict.fromkeys(map(kitti_spelling, names))))
        if not self.types:
            raise CadetError(f"{owner}.types: expected at least one")
        both = [name for name in self.types if name in self.neighbors]
        if both:
            raise CadetError(f"{owner}.neighbors: {both[0]} is one of its own types")
        # Nothing is taken from KITTI for an own class, so all three limits must be there.
        object.__setattr__(self, "min_overlap", class_limits(owner + ".min_overlap", self.min_overlap, None))

    def core(self) -> tuple[list[str], list[str], list[float]]:
        """Return the class as the core takes it."""
        return list(self.types), list(self.neighbors), list(self.min_overlap)

    def limits(self) -> dict[str, float]:
        """Return the limits by metric."""
        return dict(zip(METRICS, self.min_overlap, strict=True))


def resolve_classes(classes: str | Sequence[str | EvalClass], min_overlap: MinOverlap) -> tuple[EvalClass, ...]:
    """Return the classes: those given as such, and types by name, to which `min_overlap` applies.

    Raises:
        CadetError: what is no class's name, a name twice, no class, or limits as in `resolve_limits`.
    """
    given = (classes,) if isinstance(classes, str) else as_tuple("", "classes", classes, "names")
    given = tuple(kitti_spelling(item) if isinstance(item, str) else item for item in given)
    named = [name for name in given if not isinstance(name, EvalClass)]
    if not given or len({getattr(item, "name", str(item)) for item in given}) < len(given):
        shown_names = [getattr(item, "name", item) for item in given]
        raise CadetError(f"classes: expected at least one, each once, got {shown(shown_names)}")
    limits = resolve_limits(named, min_overlap)
    return tuple(
        item if isinstance(item, EvalClass) else EvalClass(item, (item,), limits[item], NEIGHBORS.get(item, ()))
        for item in given
    )
