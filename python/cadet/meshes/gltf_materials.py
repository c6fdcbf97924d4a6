"""The base colors of glTF materials (specification, 3.9) and the extensions that change them."""

from __future__ import annotations

from typing import Final

import numpy as np

from cadet.checks import shown
from cadet.meshes.coloring import BLEND, MASK, OPAQUE, Look
from cadet.meshes.gltf_container import Container
from cadet.meshes.gltf_extensions import PICTURES, SPECULAR_GLOSSINESS, TEXTURE_TRANSFORM, TRANSMISSION
from cadet.meshes.gltf_tables import Table
from cadet.meshes.pictures import CLAMP, MIRROR, REPEAT, Picture, picture_from_bytes
from cadet.meshes.triangles import Color

_WHITE: Final = (1.0, 1.0, 1.0, 1.0)
_WRAPS: Final = {33071: CLAMP, 33648: MIRROR, 10497: REPEAT}
_ALPHAS: Final = {"OPAQUE": OPAQUE, "BLEND": BLEND, "MASK": MASK}


class Materials:
    """Reads materials of a file.

    Args:
        container: the file.
        notes: gets a line for each picture that is not read.
    """

    def __init__(self, container: Container, notes: list[str]) -> None:
        self._container = container
        self._notes = notes
        self._looks: dict[int, Look] = {}
        self._pictures: dict[int, Picture | str] = {}

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
        # The factor alone says nothing of a surface whose picture can't be seen.
        if isinstance(picture, str):
            self._notes.append(f"{material.file}: material {shown(name)}: {picture}: gray paint")
        moved = (None if texture is None else texture.extension(TEXTURE_TRANSFORM)) or Table({}, "", material.file)
        uv_set = 0 if texture is None else texture.whole("texCoord", 0)
        return Look(
            name=name,
            albedo=None if isinstance(picture, str) else (red, green, blue),
            opacity=opacity,
            picture=picture if isinstance(picture, Picture) else None,
            wraps=wraps,
            uv_from_uv=_moved(moved),
            uv_set=moved.whole("texCoord", uv_set),
            alpha=_ALPHAS.get(material.text("alphaMode", "OPAQUE"), OPAQUE),
            alpha_factor=alpha,
            cutoff=material.number("alphaCutoff", 0.5),
        )

    def _texture(self, info: Table) -> tuple[Picture | str | None, tuple[str, str]]:
        """Return a texture's picture, or why there is none, and how it is repeated."""
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
        found: Picture | str = f"{texture.where} names no picture"
        for number in numbers:
            found = self._picture(number)
            if isinstance(found, Picture):
                break
        return found, wraps

    def _picture(self, number: int) -> Picture | str:
        if number not in self._pictures:
            image = self._container.items("images")[number]
            uri = image.text("uri")
            name = shown(image.text("name") if uri.startswith("data:") or not uri else uri)
            data = self._container.picture(number)
            picture = None if data is None else picture_from_bytes(data)
            if picture is not None:
                self._pictures[number] = picture
            elif data is None:
                self._pictures[number] = f"no picture {name} beside the mesh"
            elif data.startswith((b"\xabKTX", b"DDS ")):
                kind = "KTX" if data.startswith(b"\xabKTX") else "DDS"
                self._pictures[number] = f"the picture {name} is {kind}, which is not read: convert it to PNG or JPEG"
            else:
                self._pictures[number] = f"the picture {name} is no PNG, JPEG, or WebP that can be decoded"
        return self._pictures[number]


def _moved(transform: Table) -> tuple[Color, Color]:
    """Return the rows of KHR_texture_transform: scaled, turned, and moved."""
    ou, ov = transform.numbers("offset", (0.0, 0.0))
    su, sv = transform.numbers("scale", (1.0, 1.0))
    angle_rad = transform.number("rotation", 0.0)
    sin, cos = float(np.sin(angle_rad)), float(np.cos(angle_rad))
    return (cos * su, sin * sv, ou), (-sin * su, cos * sv, ov)
