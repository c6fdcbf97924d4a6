"""Wavefront OBJ files: triangles and what colors them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import shown
from cadet.errors import FileFormatError
from cadet.worlds.meshes.beside import Beside
from cadet.worlds.meshes.coloring import BLEND, Batch, Look, materials_of
from cadet.worlds.meshes.mtl import LibraryMaterial, materials_from_text
from cadet.worlds.meshes.obj_lines import ObjLines, lines_from_text
from cadet.worlds.meshes.pictures import (
    CLAMP,
    LINEAR_FROM_BYTE,
    REPEAT,
    Picture,
    note_of_unread,
    picture_from_bytes,
)
from cadet.worlds.meshes.polygons import triangles_of
from cadet.worlds.meshes.text import text_from_bytes
from cadet.worlds.meshes.triangles import MeshTriangles


def obj_from_bytes(data: bytes, file: str, beside: Beside) -> MeshTriangles:
    """Read an OBJ file, and its libraries and pictures as far as they are there.

    Args:
        data: the file's bytes.
        file: its name, for messages.
        beside: the files beside it.

    Raises:
        FileFormatError: a line that makes no sense, or no faces at all.
        CadetError: a path out of the folder.
    """
    lines = lines_from_text(text_from_bytes(data), file)
    vertices = np.array(lines.coordinates, np.float64).reshape(-1, 3)
    corners = lines.index_array("corners") - 1
    _check_finite(vertices, corners, lines, file)
    with np.errstate(over="ignore", invalid="ignore"):
        cut, owners = triangles_of(vertices, corners, lines.index_array("counts"))
    if not len(cut):
        what = (
            "its surfaces are free-form, export it as polygons (a mesh)"
            if lines.has_surfaces
            else "is it a Wavefront OBJ file?"
        )
        raise FileFormatError(f"no faces: {what}", file)
    notes: list[str] = []
    if lines.has_surfaces:
        notes.append(f"{file}: free-form surfaces are not read: export all of it as polygons")
    looks = _looks(lines, file, beside, notes)
    batches, order = _batches(lines, looks, vertices, corners, cut, owners)
    ids, materials = materials_of(batches)
    back = np.argsort(np.concatenate(order), kind="stable")
    return MeshTriangles(
        sha256=beside.sha256(data),
        corners=np.concatenate([b.corners for b in batches])[back].reshape(-1, 9).astype(np.float32),
        material_ids=np.concatenate(ids)[back],
        part_ids=np.concatenate([b.part_ids for b in batches])[back],
        materials=materials,
        parts=tuple(lines.parts),
        notes=tuple(dict.fromkeys(notes)),
    )


def _check_finite(vertices: NDArray[np.float64], corners: NDArray[np.int64], lines: ObjLines, file: str) -> None:
    # As far as the numbers of the core reach.
    used = corners[~(np.abs(vertices[corners]) < 1e30).all(axis=1)]
    if len(used):
        index = int(used.min())
        where = ", ".join(f"{value:g}" for value in vertices[index])
        raise FileFormatError(
            f"v: a coordinate is not finite: ({where}); remove the corner or export it again",
            file,
            lines.vertex_lines[index],
        )


def _batches(
    lines: ObjLines,
    looks: list[Look],
    vertices: NDArray[np.float64],
    corners: NDArray[np.int64],
    cut: NDArray[np.int64],
    owners: NDArray[np.int64],
) -> tuple[list[Batch], list[NDArray[np.int64]]]:
    """Gather the triangles of each material, and which ones these are."""
    places = np.array(lines.places, np.float64).reshape(-1, 2) * [1.0, -1.0] + [0.0, 1.0]
    corner_places = lines.index_array("corner_places") - 1
    colors = _vertex_colors(lines)
    material_of = lines.index_array("face_materials")[owners]
    part_of = lines.index_array("face_parts")[owners].astype(np.uint32)
    batches, order = [], []
    for number in np.unique(material_of).tolist():
        rows = np.flatnonzero(material_of == number)
        look = looks[number]
        groups = (
            [(rows, None)] if look.picture is None or not len(places) else _with_places(rows, corner_places[cut[rows]])
        )
        for some, place_ids in groups:
            if len(some):
                of_corner = corners[cut[some]]
                uv = None if place_ids is None else places[place_ids]
                shade = None if colors is None else colors[of_corner]
                batches.append(Batch(look, vertices[of_corner], part_of[some], uv, shade))
                order.append(some)
    return batches, order


def _with_places(
    rows: NDArray[np.int64], place_ids: NDArray[np.int64]
) -> list[tuple[NDArray[np.int64], NDArray[np.int64] | None]]:
    """Part the triangles into those whose corners all have texture coordinates, and others."""
    has = (place_ids >= 0).all(axis=1)
    return [(rows[has], place_ids[has]), (rows[~has], None)]


def _vertex_colors(lines: ObjLines) -> NDArray[np.float64] | None:
    """Return (n, 4) linear colors of the corners; white where a line has none, None where no line has one."""
    if not lines.vertex_colors:
        return None
    stated = np.ones((len(lines.vertex_lines), 3))
    stated[list(lines.vertex_colors)] = list(lines.vertex_colors.values())
    stated = np.clip(np.nan_to_num(stated, nan=1.0), 0.0, 255.0)
    # Programs write sRGB, from 0 to 1 or as bytes.
    stated = np.clip(stated if stated.max() > 1.5 else stated * 255.0, 0.0, 255.0)
    linear = LINEAR_FROM_BYTE[np.rint(stated).astype(np.int64)]
    return np.column_stack([linear, np.ones(len(linear))])


def _looks(lines: ObjLines, file: str, beside: Beside, notes: list[str]) -> list[Look]:
    """Return the look of each material that the file names."""
    stated: dict[str, LibraryMaterial] = {}
    for names in lines.libraries:
        for name, data in _libraries(names, file, beside, notes):
            last = name.replace("\\", "/").split("/")[-1]
            stated |= {m.name: m for m in materials_from_text(text_from_bytes(data), last, notes)}
    pictures: dict[str, Picture | str] = {}
    looks = []
    lost = []
    for name in lines.materials:
        found = _of_name(stated, name)
        if name and found is None:
            lost.append(name)
        looks.append(Look(name) if found is None else _look(found.name, found, pictures, file, beside, notes))
    unread = {name: why for name, why in pictures.items() if isinstance(why, str)}
    notes += note_of_unread(file, unread, "their materials have Kd alone, gray paint where it is black")
    if lost and stated:
        notes.append(f"{file}: no material {', '.join(map(shown, lost[:5]))} in its libraries: gray paint")
    elif lost and not lines.libraries:
        notes.append(f"{file}: no line names a material library (mtllib): gray paint")
    return looks


def _libraries(names: str, file: str, beside: Beside, notes: list[str]) -> list[tuple[str, bytes]]:
    """Find the libraries of a line: a file of the whole name, or else one of each word."""
    wholes = [names, names.split(" #")[0].strip(), names.strip('"')]
    whole = beside.find(*wholes)
    if whole is not None:
        return [(names, whole)]
    found = []
    for name in names.split():
        data = beside.find(name)
        if data is not None:
            found.append((name, data))
    missing = [name for name in names.split() if name not in dict(found)]
    if missing:
        missing_text = " ".join(missing) if found else names
        others = beside.names(".mtl")
        there = f" (there is {', '.join(others[:3])})" if others and not found else ""
        notes.append(f"{file}: no material library {shown(missing_text)} beside it{there}: gray paint")
    return found


def _of_name(stated: Mapping[str, LibraryMaterial], name: str) -> LibraryMaterial | None:
    """Find a material as written, without a comment behind it, or the one whose letters differ in case alone."""
    for same in (name, name.split(" #")[0].strip()):
        if same in stated:
            return stated[same]
    alike = [
        material
        for other, material in stated.items()
        if name.casefold() in (other.casefold(), other.split(" #")[0].strip().casefold())
    ]
    return alike[0] if len(alike) == 1 else None


def _look(
    name: str,
    stated: LibraryMaterial,
    pictures: dict[str, Picture | str],
    file: str,
    beside: Beside,
    notes: list[str],
) -> Look:
    opacity = 1.0 if stated.dissolve is None else min(max(stated.dissolve, 0.0), 1.0)
    look = Look(name, stated.diffuse, opacity)
    map_, mask = stated.map_diffuse, stated.map_dissolve
    if mask is not None and (map_ is None or mask.file != map_.file):
        notes.append(f"{file}: material {shown(name)}: its map_d is not read: give its opacity as d")
    if map_ is None:
        return look
    if map_.file not in pictures:
        pictures[map_.file] = picture_from_bytes(beside.find(map_.file, map_.file.split(" #")[0].strip()))
    picture = pictures[map_.file]
    # Many programs write black beside a picture, which is to be seen all the same.
    is_black = stated.diffuse is None or max(stated.diffuse) <= 0.0
    if is_black:
        look = replace(look, albedo=None)
    if isinstance(picture, str):
        return look
    (su, sv), (ou, ov) = map_.scale, map_.offset
    return replace(
        look,
        picture=picture,
        wraps=(CLAMP, CLAMP) if map_.is_clamped else (REPEAT, REPEAT),
        # In the file v points up, and here down.
        uv_from_uv=((su, 0.0, ou), (0.0, sv, 1.0 - sv - ov)),
        alpha=BLEND if mask is not None and mask.file == map_.file else look.alpha,
    )
