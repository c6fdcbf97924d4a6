"""A mesh's triangles and materials as its file states them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet

MAX_TRIANGLES: Final = _cadet.ActorMesh.MAX_TRIANGLES
MAX_MATERIALS: Final = _cadet.ActorMesh.MAX_MATERIALS
Color = tuple[float, float, float]
"""Linear red, green, and blue from 0 to 1."""


@dataclass(frozen=True)
class MeshMaterial:
    """A material, or the one of its colors that some triangles have."""

    name: str
    """Its name; empty where triangles name none."""
    albedo: Color | None = None
    """Its color; None where the file states none that can be read."""
    opacity: float = 1.0
    """From 0, clear, to 1."""


@dataclass(frozen=True)
class MeshTriangles:
    """What a mesh's files hold, read. Two of them are equal if their files are."""

    sha256: str
    """The hash of the mesh's file and of all that it took from the files beside it."""
    corners: NDArray[np.float32] = field(compare=False, repr=False)
    """(n, 9) three corners each, in the file's units and axes; of glTF files with x forward, y left, and z up."""
    material_ids: NDArray[np.uint32] = field(compare=False, repr=False)
    """(n,) indices into `materials`."""
    part_ids: NDArray[np.uint32] = field(compare=False, repr=False)
    """(n,) indices into `parts`."""
    materials: tuple[MeshMaterial, ...] = field(repr=False)
    """Those that some triangle has."""
    parts: tuple[tuple[str, ...], ...] = field(repr=False)
    """The names of each part, the outermost first: nodes within nodes, or an object and its group."""
    notes: tuple[str, ...] = ()
    """What was not read or was read otherwise than it is written, a line each."""
