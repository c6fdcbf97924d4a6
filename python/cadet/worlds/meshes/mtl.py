"""Material libraries of Wavefront OBJ files: the few keys that color a mesh.

Wavefront Technologies, "MTL material format" (Lightwave, OBJ/MTL, 1995), as other programs write it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from cadet._util.checks import shown
from cadet.errors import FileFormatError
from cadet.worlds.meshes.text import lines_of
from cadet.worlds.meshes.triangles import Color

# Of each option of a map, the most numbers or words that it takes.
_OPTIONS: Final = {
    "-blendu": 1,
    "-blendv": 1,
    "-boost": 1,
    "-bm": 1,
    "-cc": 1,
    "-clamp": 1,
    "-colorspace": 1,
    "-imfchan": 1,
    "-mm": 2,
    "-o": 3,
    "-s": 3,
    "-t": 3,
    "-texres": 1,
    "-type": 1,
}
_OF_NUMBERS: Final = ("kd", "d", "tr")
_VECTORS: Final = ("-o", "-s", "-t")


@dataclass(frozen=True)
class Map:
    """A picture that a material names."""

    file: str
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    is_clamped: bool = False


@dataclass
class LibraryMaterial:
    """A material as a library states it."""

    name: str
    diffuse: Color | None = None
    dissolve: float | None = None
    map_diffuse: Map | None = None
    map_dissolve: Map | None = None


def materials_from_text(text: str, file: str, notes: list[str]) -> list[LibraryMaterial]:
    """Read a material library.

    Args:
        text: the text.
        file: its name, for messages.
        notes: gets a line for each thing that is not read.

    Raises:
        FileFormatError: a number of a color or an opacity that is none.
    """
    materials: list[LibraryMaterial] = []
    for number, line in lines_of(text, _OF_NUMBERS):
        words = line.split(None, 1)
        if not words or words[0].startswith("#"):
            continue
        key, rest = words[0].lower(), words[1].strip() if len(words) > 1 else ""
        if key == "newmtl":
            materials.append(LibraryMaterial(rest))
        elif materials:
            _read(materials[-1], key, rest, _Place(file, number, words[0], notes))
    return materials


@dataclass(frozen=True)
class _Place:
    file: str
    line: int
    key: str
    notes: list[str]

    def numbers(self, text: str) -> list[float]:
        words = text.split()
        try:
            values = [float(word) for word in words]
        except ValueError:
            values = [math.nan]
        if not values or not all(math.isfinite(value) for value in values):
            raise FileFormatError(
                f"{self.key}: expected numbers, got {shown(text)}: correct the line", self.file, self.line
            )
        return values

    def note(self, what: str) -> None:
        self.notes.append(f"{self.file}:{self.line}: {self.key} {what}")


def _read(material: LibraryMaterial, key: str, rest: str, place: _Place) -> None:
    if key == "kd":
        material.diffuse = _color(rest, place)
    elif key == "d":
        # A halo's opacity is the one of what faces the eye.
        material.dissolve = place.numbers(rest.removeprefix("-halo"))[0]
    elif key == "tr" and material.dissolve is None:
        transparency = place.numbers(rest)[0]
        if transparency >= 1.0:
            place.note(f"{transparency:g} alone would be nothing at all: read as opaque")
        else:
            material.dissolve = 1.0 - transparency
    elif key == "map_kd":
        material.map_diffuse = _map(rest, place)
    elif key == "map_d":
        material.map_dissolve = _map(rest, place)


def _color(text: str, place: _Place) -> Color | None:
    if text.split(None, 1)[:1] in (["spectral"], ["xyz"]):
        place.note(f"{shown(text)} is not read: the material is gray; export its color as red, green, and blue")
        return None
    values = place.numbers(text)
    if len(values) == 2:
        raise FileFormatError(f"{place.key}: expected one or three numbers, got {shown(text)}", place.file, place.line)
    red, green, blue = values[:3] if len(values) > 2 else values * 3
    if max(red, green, blue) > 2.0:
        place.note(f"{shown(text)} is read as bytes, from 0 to 255")
        return red / 255.0, green / 255.0, blue / 255.0
    return red, green, blue


def _map(text: str, place: _Place) -> Map | None:
    """Read the options of a picture and its name, which may have blanks in it; None where there is no name."""
    words = text.split()
    options: dict[str, list[str]] = {}
    while words and words[0].lower() in _OPTIONS:
        option = words.pop(0).lower()
        most = _OPTIONS[option]
        while words and len(options.setdefault(option, [])) < most:
            if option in _VECTORS and not _is_number(words[0]):
                break
            options[option].append(words.pop(0))
    # Blanks within a name are as many as they are in the text.
    name = text[len(text) - len(_last(text, words)) :] if words else ""
    if not name:
        return None
    scale, offset = (_two(options.get(option, []), default, place) for option, default in (("-s", 1.0), ("-o", 0.0)))
    return Map(name, scale, offset, options.get("-clamp") == ["on"])


def _last(text: str, words: list[str]) -> str:
    """Return the end of a text that begins with the first of its last words."""
    for _ in range(len(text.split()) - len(words)):
        text = text.split(None, 1)[1]
    return text


def _two(words: list[str], default: float, place: _Place) -> tuple[float, float]:
    values = [*place.numbers(" ".join(words)), default, default] if words else [default, default]
    return values[0], values[1]


def _is_number(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False
