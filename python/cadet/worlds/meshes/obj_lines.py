"""The lines of a Wavefront OBJ file: corners, faces, and what they belong to.

Wavefront Technologies, "Object files (.obj)" (Advanced Visualizer manual, appendix B1), as other programs write it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import shown
from cadet.errors import FileFormatError
from cadet.worlds.meshes.polygons import MAX_CORNERS
from cadet.worlds.meshes.text import lines_of
from cadet.worlds.meshes.triangles import MAX_TRIANGLES

# Names may end in a backslash, and comments: only numbers go on in the next line.
_CONTINUED: Final = ("v", "vt", "vn", "f", "fo", "l", "p")


@dataclass
class ObjLines:
    """What the lines of an OBJ file say, one entry a corner or a face."""

    coordinates: list[float] = field(default_factory=list)
    """x, y, z of each vertex."""
    vertex_lines: list[int] = field(default_factory=list)
    vertex_colors: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    """Red, green, blue of the vertices that have them, by their index."""
    places: list[float] = field(default_factory=list)
    """u, v of each texture coordinate."""
    libraries: list[str] = field(default_factory=list)
    """The rest of each line that names material libraries."""
    materials: list[str] = field(default_factory=lambda: [""])
    """The names of materials in use; the first is none."""
    parts: list[tuple[str, ...]] = field(default_factory=lambda: [("", "")])
    """Object and group."""
    corners: list[int] = field(default_factory=list)
    """Of all faces: numbers of vertices from 1, one face after the other."""
    corner_places: list[int] = field(default_factory=list)
    """Of all faces: numbers of texture coordinates from 1, 0 where a corner has none."""
    counts: list[int] = field(default_factory=list)
    """Of each face: how many corners."""
    face_lines: list[int] = field(default_factory=list)
    face_materials: list[int] = field(default_factory=list)
    face_parts: list[int] = field(default_factory=list)
    has_surfaces: bool = False
    """True where there are free-form surfaces, which are not read."""

    def index_array(self, name: str) -> NDArray[np.int64]:
        """Return one of the lists of whole numbers as an array."""
        return np.array(getattr(self, name), np.int64)


def lines_from_text(text: str, file: str) -> ObjLines:
    """Read the lines of an OBJ file.

    Raises:
        FileFormatError: a line that makes no sense, by its number.
    """
    read = _Reader(file)
    keys: dict[str, Callable[[list[str], int], None]] = {
        "v": read.vertex,
        "vt": read.place,
        "f": read.face,
        "fo": read.face,
    }
    names: dict[str, Callable[[str], None]] = {
        "usemtl": read.use_material,
        "o": read.name_object,
        "g": read.name_group,
        "mtllib": read.lines.libraries.append,
    }
    for number, line in lines_of(text, _CONTINUED):
        words = line.split()
        if not words:
            continue
        key = words[0]
        if key == "vn":  # found anew from the faces
            continue
        act = keys.get(key)
        if act is not None:
            act(words, number)
            continue
        key = key.lower()
        if key in names:
            names[key](line.strip()[len(key) :].strip())
        elif key in ("surf", "curv2"):
            read.lines.has_surfaces = True
        elif key in keys:
            keys[key](words, number)
    read.check_indices()
    return read.lines


class _Reader:
    def __init__(self, file: str) -> None:
        self.lines = ObjLines()
        self._file = file
        self._material = self._part = self._num_triangles = 0
        self._materials = {"": 0}
        self._parts = {("", ""): 0}

    def vertex(self, words: list[str], number: int) -> None:
        try:
            values = list(map(float, words[1:]))
        except ValueError:
            values = []
        if len(values) < 3:
            hint = "; decimal points, not commas" if any("," in word for word in words) else ""
            raise self._bad(f"{words[0]}: expected three numbers, got {shown(' '.join(words[1:]))}{hint}", number)
        if len(values) >= 6:
            self.lines.vertex_colors[len(self.lines.vertex_lines)] = (values[3], values[4], values[5])
        self.lines.coordinates += values[:3]
        self.lines.vertex_lines.append(number)

    def place(self, words: list[str], number: int) -> None:
        try:
            u = float(words[1])
            v = float(words[2]) if len(words) > 2 else 0.0
        except (ValueError, IndexError):
            u = v = math.nan
        # Programs write these where a modeler left none.
        self.lines.places += (u, v) if math.isfinite(u) and math.isfinite(v) else (0.0, 0.0)

    def face(self, words: list[str], number: int) -> None:
        lines = self.lines
        count = len(words) - 1
        if count > MAX_CORNERS:
            raise self._bad(f"a face of {count} corners, at most {MAX_CORNERS}: cut it into triangles", number)
        num_slashes = words[-1].count("/")
        try:
            numbers = list(map(int, " ".join(words[1:]).replace("/", " ").split()))
            step = len(numbers) // count
            is_plain = (
                min(numbers) > 0 and words[-1][-1] != "/" and all(word.count("/") == num_slashes for word in words[1:])
            )
        except (ValueError, ZeroDivisionError):
            is_plain = False
        if is_plain and step * count == len(numbers) and step in (num_slashes, num_slashes + 1):
            lines.corners += numbers[::step]
            lines.corner_places += numbers[1::step] if step == num_slashes + 1 and step > 1 else [0] * count
        else:
            for word in words[1:]:
                self._corner(word, number)
        lines.counts.append(count)
        lines.face_lines.append(number)
        lines.face_materials.append(self._material)
        lines.face_parts.append(self._part)
        self._num_triangles += max(count - 2, 0)
        if self._num_triangles > MAX_TRIANGLES:
            raise self._bad(f"more than {MAX_TRIANGLES} triangles: simplify the mesh", number)

    def _corner(self, word: str, number: int) -> None:
        """Read a corner as the format allows it: counted back from here, or without what others have."""
        corner, _, rest = word.partition("/")
        place = rest.partition("/")[0]
        try:
            vertex, texture = int(corner), int(place) if place else 0
        except ValueError:
            raise self._bad(f"f: expected corners such as 1, 1/2, or 1//3, got {shown(word)}", number) from None
        vertex += len(self.lines.vertex_lines) + 1 if vertex < 0 else 0
        texture += len(self.lines.places) // 2 + 1 if texture < 0 else 0
        if vertex < 1:
            raise self._bad(f"f: no corner {corner}: they are counted from 1, or back from -1", number)
        self.lines.corners.append(vertex)
        self.lines.corner_places.append(max(texture, 0))

    def use_material(self, name: str) -> None:
        self._material = self._materials.setdefault(name, len(self._materials))
        if self._material == len(self.lines.materials):
            self.lines.materials.append(name)

    def name_object(self, name: str) -> None:
        self._use_part((name, ""))

    def name_group(self, name: str) -> None:
        self._use_part((self.lines.parts[self._part][0], name))

    def _use_part(self, part: tuple[str, str]) -> None:
        self._part = self._parts.setdefault(part, len(self._parts))
        if self._part == len(self.lines.parts):
            self.lines.parts.append(part)

    def check_indices(self) -> None:
        """Refuse corners that the whole file does not have; of texture coordinates, if it has any at all."""
        for what, found, name in (
            ("corner", len(self.lines.vertex_lines), "corners"),
            ("texture coordinate", len(self.lines.places) // 2, "corner_places"),
        ):
            numbers = getattr(self.lines, name)
            most = max(numbers, default=0)
            if most > found and (found or what == "corner"):
                face = int(np.searchsorted(np.cumsum(self.lines.counts), numbers.index(most), side="right"))
                reason = f"f: {what} {most} of {found}: the file is cut or damaged; export it again"
                raise self._bad(reason, self.lines.face_lines[face])

    def _bad(self, reason: str, number: int) -> FileFormatError:
        return FileFormatError(reason, self._file, number)
