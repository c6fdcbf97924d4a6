"""The color of each triangle, from its material, a picture, and its corners' colors; and few materials for all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.worlds.meshes.pictures import REPEAT, Picture
from cadet.worlds.meshes.triangles import MAX_MATERIALS, Color, MeshMaterial

OPAQUE, BLEND, MASK = "opaque", "blend", "mask"
# The core assumes glass and seats where a mesh has none.
_MOST_MATERIALS: Final = MAX_MATERIALS - 2


@dataclass(frozen=True, eq=False)
class Look:
    """A material as a file states it."""

    name: str = ""
    """Its name; empty for what names no material."""
    albedo: Color | None = None
    """Linear; it multiplies the picture. None where nothing is known."""
    opacity: float = 1.0
    """What it lets through besides what `alpha` says."""
    picture: Picture | None = None
    wraps: tuple[str, str] = (REPEAT, REPEAT)
    uv_from_uv: tuple[Color, Color] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    """Makes places in the picture of texture coordinates: two rows of factors and an offset."""
    uv_set: int = 0
    """Which of the mesh's sets of texture coordinates."""
    alpha: str = OPAQUE
    """What alphas of the factor, the picture, and the corners mean."""
    alpha_factor: float = 1.0
    cutoff: float = 0.5
    """Of a mask: what is opaque has at least this alpha."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Triangles of one material."""

    look: Look
    corners: NDArray[np.float64]
    """(n, 3, 3)"""
    part_ids: NDArray[np.uint32]
    """(n,)"""
    uv: NDArray[np.float64] | None = None
    """(n, 3, 2) texture coordinates, the first row of the picture at v = 0."""
    colors: NDArray[np.float64] | None = None
    """(n, 3, 4) the corners' linear red, green, blue, and alpha."""


def _shades(batch: Batch) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Return (n, 3) linear colors, None where nothing is known, and (n,) opacities; n is 1 where all are the same."""
    look = batch.look
    factors: list[NDArray[np.float64]] = []
    if look.picture is not None:
        if batch.uv is None:
            factors.append(look.picture.mean()[None])
        else:
            with np.errstate(over="ignore", invalid="ignore"):
                rows = [
                    row[0] * batch.uv[..., 0] + row[1] * batch.uv[..., 1] + row[2] for row in np.array(look.uv_from_uv)
                ]
            factors.append(look.picture.over(np.stack(rows, axis=-1), look.wraps))
    if batch.colors is not None:
        factors.append(np.clip(batch.colors, 0.0, 1.0).sum(axis=1) / 3.0)
    product = np.clip(np.array([[*(look.albedo or (1.0, 1.0, 1.0)), 1.0]]), 0.0, 1.0)
    for factor in factors:
        # To 8 bits, so that the last bit of a sum is nobody's paint.
        product = product * np.rint(factor * 255.0) / 255.0
    is_known = look.albedo is not None or bool(factors)
    rgb, alpha = product[:, :3] if is_known else None, product[:, 3]
    alpha = alpha * look.alpha_factor
    if look.alpha == OPAQUE:
        alpha = np.ones(1)
    elif look.alpha == MASK:
        alpha = (alpha >= look.cutoff).astype(np.float64)
    return rgb, np.clip(alpha, 0.0, 1.0) * look.opacity


def materials_of(batches: Sequence[Batch]) -> tuple[list[NDArray[np.uint32]], tuple[MeshMaterial, ...]]:
    """Find the materials that color all triangles, near colors of one material joined where there are too many.

    Returns:
        For each batch (n,) indices into the materials, and those.
    """
    ids = [np.zeros(len(batch.corners), np.uint32) for batch in batches]
    found: dict[MeshMaterial, int] = {}
    varied = []
    for number, batch in enumerate(batches):
        rgb, opacity = _shades(batch)
        if rgb is None or len(rgb) == 1:
            albedo = None if rgb is None else _as_color(rgb[0].tolist())
            material = MeshMaterial(batch.look.name, albedo, float(opacity[0]))
            ids[number][:] = found.setdefault(material, len(found))
        else:
            varied.append((number, np.column_stack([rgb, np.broadcast_to(opacity, len(rgb))])))
    if varied:
        names = list(dict.fromkeys(batches[number].look.name for number, _ in varied))
        owners = np.concatenate([np.full(len(v), names.index(batches[number].look.name)) for number, v in varied])
        values = np.concatenate([v for _, v in varied])
        cells, means, of_name = _cells(owners, values, _MOST_MATERIALS - len(found))
        materials = [
            MeshMaterial(names[owner], _as_color(color), opacity)
            for owner, (*color, opacity) in zip(of_name.tolist(), means.tolist(), strict=True)
        ]
        numbers = np.array([found.setdefault(material, len(found)) for material in materials], np.uint32)
        ends = np.cumsum([len(v) for _, v in varied])
        for (number, v), end in zip(varied, ends.tolist(), strict=True):
            ids[number] = numbers[cells[end - len(v) : end]]
    return ids, tuple(found)


def _cells(
    owners: NDArray[np.int64], values: NDArray[np.float64], most: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
    """Join near colors and opacities of one owner until there are few enough, or one an owner.

    Returns:
        (n,) the cell of each value, (m, 4) the cells' means, and (m,) the cells' owners.
    """
    # Steps of a square root look alike to the eye; opacities have 16.
    levels = np.rint(np.sqrt(np.clip(values[:, :3], 0.0, 1.0)) * 255.0).astype(np.int64)
    opacity = np.rint(values[:, 3] * 16.0).astype(np.int64)
    for step in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 128, 256):
        red, green, blue = (levels // step).T
        keys = (((owners * 256 + red) * 256 + green) * 256 + blue) * 32 + opacity
        distinct, first, cells = np.unique(keys, return_index=True, return_inverse=True)
        if len(distinct) <= most:
            break
    cells = cells.reshape(-1)
    counts = np.bincount(cells)
    means = np.stack([np.bincount(cells, values[:, k]) / counts for k in range(4)], axis=1)
    means[:, :3] = np.rint(means[:, :3] * 255.0) / 255.0
    means[:, 3] = np.where(opacity[first] == 16, 1.0, np.round(means[:, 3], 3))
    return cells, means, owners[first]


def _as_color(values: list[float]) -> Color:
    red, green, blue = values
    return red, green, blue
