"""The parts of a glTF 2.0 file that lie outside of its JSON: buffers, and the mean colors of its pictures.

Khronos Group, glTF 2.0 Specification (2021): 3.6.1 buffers, 3.9 materials, 4.4 the binary container.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from cadet.errors import FileFormatError
from cadet.image_file import decode_file
from cadet.plain_text import json_from_text

_MAGIC: Final = b"glTF"
_JSON_CHUNK: Final = 0x4E4F534A
_BINARY_CHUNK: Final = 0x004E4942
# IEC 61966-2-1: sRGB's linear part and its power.
_SRGB_LINEAR_TO: Final = 0.04045
Color = tuple[float, float, float]


@dataclass(frozen=True)
class GltfFile:
    """A glTF file with everything that it needs, held in memory."""

    document: bytes = field(repr=False)
    """The file's bytes: JSON, or a binary container (GLB)."""
    buffers: tuple[bytes, ...] = field(default=(), repr=False)
    """Each of its buffers by index; empty for the one inside the container."""
    image_colors: tuple[Color | None, ...] = ()
    """The mean linear color of each picture that is some material's base color."""

    @property
    def sha256(self) -> str:
        """The hash of all its bytes and colors."""
        digest = hashlib.sha256(repr(self.image_colors).encode())
        for part in (self.document, *self.buffers):
            digest.update(hashlib.sha256(part).digest())
        return digest.hexdigest()


def gltf_from_bytes(document: bytes, file: str, read_beside: Callable[[str], bytes]) -> GltfFile:
    """Find what a glTF file refers to.

    Args:
        document: the file's bytes, JSON or a binary container.
        file: its name, for messages.
        read_beside: returns the bytes of a file that lies beside it, by its relative path.

    Raises:
        FileFormatError: neither JSON nor a container, or a part that is no buffer, no picture, or missing.
        CadetError: whatever `read_beside` raises.
    """
    text, binary = _chunks(document, file)
    values = json_from_text(text, file)
    if not isinstance(values, Mapping):
        raise FileFormatError("no glTF: expected an object", file)
    reader = _Reader(values, binary, file, read_beside)
    buffers = tuple(reader.buffer(number) for number in range(len(reader.tables("buffers"))))
    return GltfFile(document, tuple(b"" if part is binary else part for part in buffers), reader.image_colors(buffers))


def _chunks(document: bytes, file: str) -> tuple[bytes, bytes]:
    """Split a container into its JSON and its buffer; JSON alone is returned as it is."""
    if not document.startswith(_MAGIC):
        return document, b""
    if len(document) < 12:
        raise FileFormatError("no glTF: the container ends in its header", file)
    version, length = struct.unpack_from("<II", document, 4)
    if version != 2 or length > len(document):
        raise FileFormatError(f"no glTF: container of version {version} with {len(document)} of {length} bytes", file)
    found: dict[int, bytes] = {}
    at = 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", document, at)
        if at + 8 + size > length:
            raise FileFormatError("no glTF: a chunk reaches beyond the container's end", file)
        found.setdefault(kind, document[at + 8 : at + 8 + size])
        at += 8 + size
    if _JSON_CHUNK not in found:
        raise FileFormatError("no glTF: a container without a JSON chunk", file)
    return found[_JSON_CHUNK], found.get(_BINARY_CHUNK, b"")


class _Reader:
    def __init__(self, values: Mapping[str, Any], binary: bytes, file: str, beside: Callable[[str], bytes]) -> None:
        self._values = values
        self._binary = binary
        self._file = file
        self._beside = beside

    def tables(self, key: str) -> list[Mapping[str, Any]]:
        tables = self._values.get(key, [])
        if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
            raise FileFormatError(f"{key}: expected a list of objects", self._file)
        return tables

    def table(self, key: str, number: object) -> Mapping[str, Any]:
        tables = self.tables(key)
        if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < len(tables):
            raise FileFormatError(f"{key}: expected a number below {len(tables)}, got {number!r}", self._file)
        return tables[number]

    def buffer(self, number: int) -> bytes:
        uri = self.table("buffers", number).get("uri")
        return self._binary if uri is None else self._bytes_of(uri, f"buffer {number}")

    def image_colors(self, buffers: tuple[bytes, ...]) -> tuple[Color | None, ...]:
        """Average the pictures that materials take their base color from; the others are not looked at."""
        used = set()
        for material in self.tables("materials"):
            surface = material.get("pbrMetallicRoughness", {})
            texture = surface.get("baseColorTexture") if isinstance(surface, Mapping) else None
            if isinstance(texture, Mapping):
                used.add(self.table("textures", texture.get("index")).get("source"))
        return tuple(
            _mean_color(self._image(number, buffers), f"image {number}", self._file) if number in used else None
            for number in range(len(self.tables("images")))
        )

    def _image(self, number: int, buffers: tuple[bytes, ...]) -> bytes:
        image = self.table("images", number)
        if "bufferView" not in image:
            return self._bytes_of(image.get("uri"), f"image {number}")
        view = self.table("bufferViews", image["bufferView"])
        first, length, index = (view.get(key, 0) for key in ("byteOffset", "byteLength", "buffer"))
        if not all(isinstance(value, int) and value >= 0 for value in (first, length, index)) or index >= len(buffers):
            raise FileFormatError(f"image {number}: a view that is none", self._file)
        part: bytes = buffers[index][first : first + length]
        return part

    def _bytes_of(self, uri: object, owner: str) -> bytes:
        if not isinstance(uri, str):
            raise FileFormatError(f"{owner}: expected the path of a file, got {uri!r}", self._file)
        if not uri.startswith("data:"):
            return self._beside(unquote(uri))
        kind, _, data = uri.partition(",")
        if not kind.endswith(";base64"):
            raise FileFormatError(f"{owner}: data that are not base64", self._file)
        try:
            return base64.b64decode(data, validate=True)
        except binascii.Error as error:
            raise FileFormatError(f"{owner}: data that are not base64: {error}", self._file) from None


def _mean_color(data: bytes, owner: str, file: str) -> Color:
    """Average a picture's linear light; what is transparent counts less."""
    try:
        pixels = decode_file(data, owner).pixels
    except FileFormatError as error:
        raise FileFormatError(str(error), file) from None
    values: NDArray[np.float64] = pixels.astype(np.float64) / np.iinfo(pixels.dtype).max
    alpha = values[..., -1:] if values.shape[2] in (2, 4) else np.ones_like(values[..., :1])
    colors = values[..., :3] if values.shape[2] >= 3 else values[..., :1].repeat(3, axis=2)
    linear = np.where(colors <= _SRGB_LINEAR_TO, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    weight = max(float(alpha.sum()), 1e-9)
    # To 8 bits, so that the last bit of a sum is nobody's paint.
    red, green, blue = (np.rint((linear * alpha).sum(axis=(0, 1)) / weight * 255.0) / 255.0).tolist()
    return red, green, blue
