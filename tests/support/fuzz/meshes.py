"""Meshes and folders of assets as targets: OBJ with its library, glTF whose JSON stays JSON, assets.toml."""

from __future__ import annotations

import json
import random
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from cadet import Assets
from fuzz.mutations import damage_bytes, damage_text, damage_values
from fuzz.target import Input, Target
from mesh_files.gltf_boxes import CORNERS, png, png_bytes, textured
from mesh_files.gltf_meshes import glb, gltf_of
from mesh_files.obj_meshes import CAR, MTL, car_obj

_SEPARATOR = "\f"


def _all_of_it() -> dict[str, Any]:
    """Return the JSON of a file that has nearly everything that is read."""
    w = textured(png((255, 0, 0, 255), (0, 255, 0, 100)), uv=np.linspace(0, 2, 16).reshape(8, 2), sampler=0)
    w.document["samplers"] = [{"wrapS": 33648, "wrapT": 33071}]
    (material,) = w.document["materials"]
    moved = {"KHR_texture_transform": {"offset": [0.1, 0.2], "scale": [2, 1], "rotation": 0.3, "texCoord": 0}}
    material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = moved
    material |= {"alphaMode": "MASK", "alphaCutoff": 0.4, "extensions": {"KHR_materials_transmission": {}}}
    old = {"diffuseFactor": [1, 0, 0, 1], "diffuseTexture": {"index": 0, "texCoord": 0}}
    w.document["materials"].append({"alphaMode": "BLEND", "extensions": {"KHR_materials_pbrSpecularGlossiness": old}})
    w.primitive["attributes"] |= {
        "COLOR_0": w.add(np.full((8, 3), 200, "u1"), normalized=True),
        "JOINTS_0": w.add(np.zeros((8, 4), "u1")),
        "WEIGHTS_0": w.add(np.full((8, 4), 0.25, "f4")),
    }
    w.primitive["targets"] = [{"POSITION": w.add(CORNERS.astype("f4"))}]
    strip = {"attributes": {"POSITION": w.add(CORNERS.astype("i1"), normalized=False)}, "mode": 5, "material": 1}
    w.document["meshes"][0] |= {"weights": [0.1], "name": "body"}
    w.document["meshes"][0]["primitives"].append(strip)
    w.document["skins"] = [{"joints": [1, 2], "inverseBindMatrices": w.add(np.stack([np.eye(4, dtype="f4")] * 2))}]
    w.document["nodes"] = [
        {"mesh": 0, "skin": 0, "name": "car", "children": [1]},
        {"matrix": np.eye(4).flatten().tolist(), "children": [2]},
        {"rotation": [0, 0, 0, 1], "translation": [0, 0, 0], "extensions": {"KHR_node_visibility": {"visible": True}}},
    ]
    w.document["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": w.view(b"\7\0\0\0"), "componentType": 5125},
        "values": {"bufferView": w.view(bytes(12)), "byteOffset": 0},
    }
    return w.finished()


_DOCUMENT = _all_of_it()


def _damage_json(rng: random.Random) -> str:
    return json.dumps(damage_values(rng, _DOCUMENT))


def _read_folder(name: str, files: dict[str, Input]) -> object:
    """Read a folder of assets that holds these files, the mesh of that name among them."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        files = {"assets.toml": CAR.replace("meshes/car.obj", name), **files}
        for file, content in files.items():
            data = content.encode("utf-8", "surrogatepass") if isinstance(content, str) else content
            (root / file).write_bytes(data)
        return Assets.read(root)


def _read_obj(value: Input) -> object:
    assert isinstance(value, str)
    obj, _, mtl = value.partition(_SEPARATOR)
    return _read_folder("car.obj", {"car.obj": obj, "car.mtl": mtl, "a.png": png_bytes((0, 255, 0), (0, 0, 0))})


def _read_assets(value: Input) -> object:
    return _read_folder("car.obj", {"car.obj": car_obj(), "car.mtl": MTL, "assets.toml": value})


_OBJ = (
    car_obj().replace("usemtl Body", "vt 0.1 0.9\nvt 0.9 0.2\no Car\ng body\nusemtl Body", 1)
    + "f 1/1 2/2 3/1 4/-1 5 \\\n6//1\nl 1 2\nv 1 2 3 0.5 0.5 0.5\n"
)
_LIBRARY = MTL + "newmtl More\nKd 0.5\nTr 0.5\nd -halo 0.5\nmap_Kd -s 1 1 1 -clamp on a.png\n"
_TOML = CAR.replace("meshes/", "") + (
    'scale = 1.5\nyaw_deg = 10\nup = "z"\nsize_lwh = [4, 1.7, 1.5]\n'
    'materials.glass = ["Gl*"]\nmaterials.leave_out = []\n'
)
_VALUES = '0 -1 1.5 1e300 nan true "" "z" "y" "*" "car.mtl" "Van" [] [[]] [4,1.7,1.4] ["*"] ["Body"] {} {a=1}'.split()


def _damage_toml(rng: random.Random) -> str:
    """Return the TOML with other values for some of its keys; half of the time with damage of any kind."""
    if rng.random() < 0.5:
        return damage_text(rng, _TOML)
    lines = _TOML.split("\n")
    for _ in range(rng.choice((1, 1, 2))):
        number = rng.randrange(len(lines))
        key, equals, _ = lines[number].partition(" = ")
        lines[number] = f"{key} = {rng.choice(_VALUES)}" if equals else lines[number]
    return "\n".join(lines)


MESH_TARGETS = (
    Target("meshes", lambda rng: damage_text(rng, _OBJ + _SEPARATOR + _LIBRARY), _read_obj),
    Target(
        "glTF containers",
        lambda rng: damage_bytes(rng, glb(json.dumps(gltf_of(car_obj())[0]).encode(), gltf_of(car_obj())[1])),
        lambda value: _read_folder("car.glb", {"car.glb": value}),
    ),
    Target("glTF", _damage_json, lambda value: _read_folder("car.gltf", {"car.gltf": value})),
    Target("folders of assets", _damage_toml, _read_assets),
)
