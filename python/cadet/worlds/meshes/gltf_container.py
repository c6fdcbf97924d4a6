"""A glTF file's JSON, its buffers, and the bytes of its pictures.

Khronos Group, glTF 2.0 Specification (2021): 3.6.1 buffers, 4.4 the binary container.
"""

from __future__ import annotations

import base64
import binascii
import re
import struct
from typing import Final
from urllib.parse import unquote, unquote_to_bytes

from cadet._util.checks import shown
from cadet._util.plain_text import json_from_text
from cadet.errors import FileFormatError, MissingFileError
from cadet.worlds.meshes.beside import Beside
from cadet.worlds.meshes.gltf_extensions import COMPRESSED
from cadet.worlds.meshes.gltf_tables import Table

_MAGIC: Final = b"glTF"
_JSON_CHUNK: Final = 0x4E4F534A
_BINARY_CHUNK: Final = 0x004E4942


class Container:
    """The JSON, and the bytes that it refers to.

    Args:
        document: the file's bytes, JSON or a binary container.
        file: its name, for messages.
        beside: the files beside it.

    Raises:
        FileFormatError: neither, or of another version.
    """

    def __init__(self, document: bytes, file: str, beside: Beside) -> None:
        text, self._binary = _chunks(document, file)
        self.root = Table(json_from_text(text, file), "", file)
        self._file = file
        self._beside = beside
        self._buffers: dict[int, bytes] = {}
        version = self.root.table("asset").text("version", "none")
        if not version.startswith("2."):
            remedy = "convert it to glTF 2.0, for instance in Blender"
            raise FileFormatError(f"not a glTF 2.0 file: its asset.version is {shown(version)}; {remedy}", file)
        self._lists: dict[str, list[Table]] = {}

    def items(self, key: str) -> list[Table]:
        """Return one of the lists at the top."""
        if key not in self._lists:
            self._lists[key] = self.root.tables(key)
        return self._lists[key]

    def item(self, owner: Table, key: str, kind: str) -> Table:
        """Return what an index of `owner` names in a list at the top."""
        found = self.items(kind)
        return found[owner.whole(key, below=len(found))]

    def view(self, number: int) -> bytes:
        """Return the bytes of a buffer view.

        Raises:
            FileFormatError: compressed bytes, or a view beyond its buffer.
        """
        view = self.items("bufferViews")[number]
        index = view.whole("buffer", below=len(self.items("buffers")))
        buffer = self.items("buffers")[index]
        packed = next((name for name in COMPRESSED if view.extension(name)), None)
        if packed is not None and buffer.extension(packed) and "uri" not in buffer:
            raise FileFormatError(f"{view.where}: {packed} is not read: {COMPRESSED[packed]}", self._file)
        data = self._buffer(index)
        first, length = view.whole("byteOffset", 0), view.whole("byteLength")
        if first + length > len(data):
            raise FileFormatError(f"{view.where}: beyond the end of its buffer", self._file)
        return data[first : first + length]

    def picture(self, number: int) -> bytes | None:
        """Return the bytes of a picture; None where its file is not there."""
        image = self.items("images")[number]
        if "bufferView" in image:
            return self.view(image.whole("bufferView", below=len(self.items("bufferViews"))))
        return self._of_uri(image)

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            buffer = self.items("buffers")[index]
            data = self._of_uri(buffer) if "uri" in buffer else self._binary
            if data is None:
                uri = shown(buffer.text("uri"))
                raise MissingFileError(f"{self._file}: no file {uri} beside it: copy it there, or export it as .glb")
            length = buffer.whole("byteLength")
            if len(data) < length:
                raise FileFormatError(f"{buffer.where}: {len(data)} bytes of {length}: the file is cut", self._file)
            self._buffers[index] = data
        return self._buffers[index]

    def _of_uri(self, owner: Table) -> bytes | None:
        uri = owner.text("uri")
        if not uri.startswith("data:"):
            if re.match(r"https?:", uri):
                raise FileFormatError(
                    f"{owner.where}: {shown(uri)} is not fetched: save it beside the mesh", self._file
                )
            return self._beside.find(unquote(uri), uri)
        kind, comma, text = uri.partition(",")
        data = unquote_to_bytes(text)
        if not comma or not kind.endswith(";base64"):
            return data
        data = b"".join(data.split()).rstrip(b"=").translate(bytes.maketrans(b"-_", b"+/"))
        try:
            return base64.b64decode(data + b"=" * (-len(data) % 4), validate=True)
        except binascii.Error as error:
            raise FileFormatError(f"{owner.where}.uri: data that are not base64: {error}", self._file) from None


def _chunks(document: bytes, file: str) -> tuple[bytes, bytes]:
    """Split a container into its JSON and its buffer; JSON alone is returned as it is."""
    if not document.startswith(_MAGIC):
        return document.removeprefix(b"\xef\xbb\xbf"), b""
    if len(document) < 12:
        raise FileFormatError("invalid glTF: the container ends in its header", file)
    version, length = struct.unpack_from("<II", document, 4)
    if version != 2 or length > len(document):
        raise FileFormatError(f"invalid glTF: version {version}, {len(document)} of {length} bytes", file)
    found: dict[int, bytes] = {}
    at = 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", document, at)
        if at + 8 + size > length:
            raise FileFormatError("invalid glTF: a chunk reaches beyond the container's end", file)
        found.setdefault(kind, document[at + 8 : at + 8 + size])
        at += 8 + size
    if _JSON_CHUNK not in found:
        raise FileFormatError("invalid glTF: a container without a JSON chunk", file)
    return found[_JSON_CHUNK], found.get(_BINARY_CHUNK, b"")
