"""The base colors of glTF materials (specification, 3.9) and the extensions that change them."""

from __future__ import annotations

from typing import Final

import numpy as np

from cadet.worlds.meshes.coloring import BLEND, MASK, OPAQUE, Look
from cadet.worlds.meshes.gltf_container import Container
from cadet.worlds.meshes.gltf_extensions import PICTURES, SPECULAR_GLOSSINESS, TEXTURE_TRANSFORM, TRANSMISSION
from cadet.worlds.meshes.gltf_tables import Table
from cadet.worlds.meshes.pictures import CLAMP, MIRROR, REPEAT, Picture, note_of_unread, picture_from_bytes
from cadet.worlds.meshes.triangles import Color

_WHITE: Final = (1.0, 1.0, 1.0, 1.0)
_WRAPS: Final = {33071: CLAMP, 33648: MIRROR, 10497: REPEAT}
_ALPHAS: Final = {"OPAQUE": OPAQUE, "BLEND": BLEND, "MASK": MASK}


class Materials:
    """Reads materials of a file.

    Args:
        container: the file.
    """

    def __init__(self, container: Container) -> None:
        self._container = container
        self._looks: dict[int, Look] = {}
        self._pictures: dict[int, Picture | str] = {}
        self._unread: dict[str, str] = {}

    def notes(self) -> list[str]:
        """Return a line about the pictures that were not read, if there are any."""
        return note_of_unread(self._container.root.file, self._unread, "their materials are gray paint")

    def look(self, number: int) -> Look:
        """Return the look of a material."""
        if number not in self._looks:
            self._looks[number] = self._read(self._container.items("materials")[number], number)
        return self._looks[number]

    def _read(self, material: Table, number: int) -> Look:
        surface = material.extension(SPECULAR_GLOSSINESS)
        if surface is None:
            surface = material.table("pbrMetallicRoughness")
            keys = ("baseColorFactor", "baseColorTexture")
        else:
            keys = ("diffuseFactor", "diffuseTexture")
        red, green, blue, alpha = surface.numbers(keys[0], _WHITE)
        transmission = material.extension(TRANSMISSION)
        opacity = (
            1.0 if transmission is None else 1.0 - min(max(transmission.number("transmissionFactor", 0.0), 0.0), 1.0)
        )
        name = material.text("name") or f"material {number}"
        texture = surface.table(keys[1]) if keys[1] in surface else None
        picture, wraps = (None, (REPEAT, REPEAT)) if texture is None else self._texture(texture)
        moved = (None if texture is None else texture.extension(TEXTURE_TRANSFORM)) or Table({}, "", material.file)
        uv_set = 0 if texture is None else texture.whole("texCoord", 0)
        return Look(
            name=name,
            # The factor alone says nothing of a surface whose picture can't be seen.
            albedo=None if picture is None and texture is not None else (red, green, blue),
            opacity=opacity,
            picture=picture,
            wraps=wraps,
            uv_from_uv=_moved(moved),
            uv_set=moved.whole("texCoord", uv_set),
            alpha=_ALPHAS.get(material.text("alphaMode", "OPAQUE"), OPAQUE),
            alpha_factor=alpha,
            cutoff=material.number("alphaCutoff", 0.5),
        )

    def _texture(self, info: Table) -> tuple[Picture | None, tuple[str, str]]:
        """Return a texture's picture, if one can be read, and how it is repeated."""
        texture = self._container.item(info, "index", "textures")
        wraps = (REPEAT, REPEAT)
        if "sampler" in texture:
            sampler = self._container.item(texture, "sampler", "samplers")
            wrap_s, wrap_t = (_WRAPS.get(sampler.whole(key, 10497), REPEAT) for key in ("wrapS", "wrapT"))
            wraps = (wrap_s, wrap_t)
        sources = [texture, *(texture.extension(name) for name in PICTURES)]
        numbers = [
            source.whole("source", below=len(self._container.items("images")))
            for source in sources
            if source is not None and "source" in source
        ]
        if not numbers:
            self._unread[texture.where] = "names no picture"
        found = {number: self._picture(number) for number in numbers}
        picture = next((picture for picture in found.values() if isinstance(picture, Picture)), None)
        if picture is None:
            self._unread |= {self._name(number): str(why) for number, why in found.items()}
        return picture, wraps

    def _picture(self, number: int) -> Picture | str:
        if number not in self._pictures:
            self._pictures[number] = picture_from_bytes(self._container.picture(number))
        return self._pictures[number]

    def _name(self, number: int) -> str:
        image = self._container.items("images")[number]
        uri = image.text("uri")
        return (image.text("name") if uri.startswith("data:") else uri) or f"image {number}"


def _moved(transform: Table) -> tuple[Color, Color]:
    """Return the rows of KHR_texture_transform: scaled, turned, and moved."""
    ou, ov = transform.numbers("offset", (0.0, 0.0))
    su, sv = transform.numbers("scale", (1.0, 1.0))
    angle_rad = transform.number("rotation", 0.0)
    sin, cos = float(np.sin(angle_rad)), float(np.cos(angle_rad))
    return (cos * su, sin * sv, ou), (-sin * su, cos * sv, ov)
