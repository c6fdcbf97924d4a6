"""glTF files of one box, written by the specification; tests change them before they are read."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from cadet.worlds.meshes import Beside, MeshTriangles, gltf_from_bytes

CORNERS = np.array([[x, y, z] for x in (-0.9, 0.9) for y in (0.0, 1.5) for z in (-2.1, 2.1)])
FACES = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3]
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
KINDS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}


class Writer:
    """A file of one box, written by the specification; tests change its `document` before they read it."""

    def __init__(self) -> None:
        self.data = b""
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "box"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
            "materials": [{"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.1, 0.1, 1]}}],
            "buffers": [],
            "bufferViews": [],
            "accessors": [],
        }
        self.add(CORNERS.astype("f4"))
        self.add(np.array(FACES, "u2"))

    @property
    def primitive(self) -> dict[str, Any]:
        found: dict[str, Any] = self.document["meshes"][0]["primitives"][0]
        return found

    def view(self, data: bytes, stride: int = 0) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.document["bufferViews"].append(view | ({"byteStride": stride} if stride else {}))
        self.data += data
        return len(self.document["bufferViews"]) - 1

    def add(self, values: Any, **more: Any) -> int:
        """Add an accessor of an array, its rows padded to four bytes; return its number."""
        rows = np.asarray(values).reshape(len(values), -1)
        size = rows.itemsize * rows.shape[1]
        stride = size + -size % 4 if rows.shape[1] > 1 else size
        packed = np.zeros((len(rows), stride), np.uint8)
        packed[:, :size] = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), size)
        view = self.view(packed.tobytes(), stride if stride != size else 0)
        self.document["accessors"].append(
            {
                "bufferView": view,
                "componentType": KINDS[rows.dtype.name],
                "count": len(rows),
                "type": TYPES[rows.shape[1]],
                **more,
            }
        )
        return len(self.document["accessors"]) - 1

    def finished(self) -> dict[str, Any]:
        """Return the JSON with its buffer inside, if nothing else is in its place."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        self.document["buffers"] = self.document["buffers"] or [{"byteLength": len(self.data), "uri": uri}]
        return self.document

    def read(self, folder: Path) -> MeshTriangles:
        text = json.dumps(self.finished()).encode()
        return gltf_from_bytes(text, "m.gltf", Beside(folder, folder / "m.gltf"))


def size(mesh: MeshTriangles) -> list[float]:
    return [round(float(v), 3) for v in np.ptp(mesh.corners.reshape(-1, 3), axis=0)]


def volume(mesh: MeshTriangles) -> float:
    a, b, c = mesh.corners.astype(float).reshape(-1, 3, 3).transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum() / 6.0)


def png(*pixels: tuple[int, ...], rows: int = 1) -> dict[str, str]:
    """Return an image of RGB or RGBA pixels."""
    return {"uri": "data:image/png;base64," + base64.b64encode(png_bytes(*pixels, rows=rows)).decode()}


def png_bytes(*pixels: tuple[int, ...], rows: int = 1) -> bytes:
    """Return a PNG file of RGB or RGBA pixels."""
    texels = np.array(pixels, np.uint8).reshape(rows, -1, len(pixels[0]))
    order = [2, 1, 0, 3][: texels.shape[2]]
    return bytes(cv2.imencode(".png", texels[..., order])[1].tobytes())


def textured(*images: dict[str, str], uv: Any = None, **texture: Any) -> Writer:
    """Return a box whose only material shows a picture."""
    w = Writer()
    w.document |= {"images": list(images), "textures": [{"source": 0, **texture}]}
    w.document["materials"] = [{"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    if uv is not None:
        w.primitive["attributes"]["TEXCOORD_0"] = w.add(np.asarray(uv, "f4"))
    return w
