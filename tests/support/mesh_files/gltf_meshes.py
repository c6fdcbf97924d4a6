"""The meshes of `mesh_files.obj_meshes` as glTF 2.0 files, written by the specification."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

MATERIALS: dict[str, dict[str, Any]] = {
    "Body": {"pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.5, 1.0]}},
    "Glass": {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.2, 0.2, 0.2]}},
    "Tyre": {"pbrMetallicRoughness": {"baseColorFactor": [0.0, 0.0, 0.0, 1.0]}},
}


def gltf_of(obj: str) -> tuple[dict[str, Any], bytes]:
    """Turn an OBJ text into glTF's JSON and buffer: a primitive a material, in a node that is moved and turned."""
    corners = [[float(v) for v in line.split()[1:]] for line in obj.splitlines() if line.startswith("v ")]
    faces: dict[str, list[int]] = {}
    name = ""
    for line in obj.splitlines():
        if line.startswith("usemtl "):
            name = line.split()[1]
        elif line.startswith("f "):
            a, b, c, d = (int(v) - 1 for v in line.split()[1:])
            faces.setdefault(name, []).extend([a, b, c, a, c, d])
    x, y, z = np.array(corners).T
    scene = np.stack([y, z, x], axis=1)  # glTF: x to the left, y up, z forward
    # Half a turn about y and 3 m ahead, which the node undoes.
    node_frame = ((scene - [0.0, 0.0, 3.0]) * [-1.0, 1.0, -1.0]).astype("<f4")
    data = node_frame.tobytes()
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": len(data)}]
    accessors: list[dict[str, Any]] = [
        {
            "bufferView": 0,
            "componentType": 5126,
            "count": len(node_frame),
            "type": "VEC3",
            "min": node_frame.min(axis=0).tolist(),
            "max": node_frame.max(axis=0).tolist(),
        }
    ]
    primitives = []
    for number, indices in enumerate(faces.values()):
        packed = np.array(indices, "<u4").tobytes()
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        accessors.append({"bufferView": number + 1, "componentType": 5125, "count": len(indices), "type": "SCALAR"})
        primitives.append({"attributes": {"POSITION": 0}, "indices": number + 1, "material": number})
        data += packed
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "rotation": [0.0, 1.0, 0.0, 0.0], "translation": [0.0, 0.0, 3.0]}],
        "meshes": [{"primitives": primitives}],
        "materials": [{"name": name, **MATERIALS[name]} for name in faces],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    return document, data


def write_gltf(path: Path, document: dict[str, Any], data: bytes, *, inside: bool = False) -> None:
    """Write JSON with its buffer beside it, or inside as a `data:` URI; a name that ends in .glb makes a container."""
    buffer = document["buffers"][0]
    if path.suffix == ".glb":
        path.write_bytes(glb(json.dumps(document).encode(), data))
        return
    if inside:
        buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    else:
        buffer["uri"] = "the%20buffer.bin"
        (path.parent / "the buffer.bin").write_bytes(data)
    path.write_text(json.dumps(document))


def glb(text: bytes, data: bytes) -> bytes:
    """Pack a binary container (specification, section 4.4)."""
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks
