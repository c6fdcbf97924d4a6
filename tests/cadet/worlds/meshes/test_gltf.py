"""glTF files as other programs write them: extensions, quantized and sparse values, skins, scenes, and damage."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cadet import CadetError
from mesh_files.gltf_boxes import CORNERS, Writer, size, volume


def test_a_box_has_our_axes(tmp_path: Path) -> None:
    mesh = Writer().read(tmp_path)
    assert size(mesh) == [4.2, 1.8, 1.5]
    assert volume(mesh) == pytest.approx(4.2 * 1.8 * 1.5, rel=1e-5)
    assert [(m.name, m.albedo, m.opacity) for m in mesh.materials] == [("red", (0.8, 0.1, 0.1), 1.0)]
    assert mesh.parts == (("box",),)


HARMLESS = [
    "KHR_materials_unlit KHR_texture_transform KHR_materials_clearcoat KHR_materials_ior KHR_materials_specular",
    "KHR_materials_sheen KHR_materials_volume KHR_materials_emissive_strength KHR_materials_iridescence",
    "KHR_materials_anisotropy KHR_materials_dispersion KHR_materials_transmission KHR_materials_variants",
    "KHR_materials_diffuse_transmission KHR_lights_punctual EXT_lights_image_based KHR_xmp_json_ld",
    "KHR_animation_pointer MSFT_lod VRM",
    "KHR_node_visibility EXT_mesh_features EXT_structural_metadata CESIUM_primitive_outline FB_geometry_metadata",
    "EXT_texture_webp KHR_texture_basisu KHR_mesh_quantization KHR_materials_pbrSpecularGlossiness",
]


@pytest.mark.parametrize("extension", " ".join(HARMLESS).split())
def test_extensions_that_change_nothing_are_accepted(extension: str, tmp_path: Path) -> None:
    w = Writer()
    w.document |= {"extensionsUsed": [extension], "extensionsRequired": [extension]}
    mesh = w.read(tmp_path)
    assert (size(mesh), mesh.notes) == ([4.2, 1.8, 1.5], ())


@pytest.mark.parametrize(
    ("extension", "remedy"),
    [
        ("KHR_draco_mesh_compression", "with `gltf-transform copy IN OUT` or in Blender with compression off"),
        ("EXT_meshopt_compression", "`gltfpack` without -c"),
        ("KHR_meshopt_compression", "`gltfpack` without -c"),
        ("KHR_techniques_webgl", "export it without, or as plain glTF 2.0"),
    ],
)
def test_other_extensions_are_refused_by_name_or_warned_of(extension: str, remedy: str, tmp_path: Path) -> None:
    w = Writer()
    w.document |= {"extensionsUsed": [extension]}
    notes = w.read(tmp_path).notes
    assert len(notes) == ("compression" not in extension), "compressed data are said where they are met"
    w.document |= {"extensionsRequired": [extension]}
    with pytest.raises(CadetError, match=f"it requires the extension .*, which is not read: .*{remedy}"):
        w.read(tmp_path)


def test_compressed_data_are_named_where_nothing_else_is_there(tmp_path: Path) -> None:
    w = Writer()
    w.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    assert size(w.read(tmp_path)) == [4.2, 1.8, 1.5], "what else is there is read"
    del w.document["accessors"][0]["bufferView"]
    with pytest.raises(CadetError, match="KHR_draco_mesh_compression is not read: decompress"):
        w.read(tmp_path)
    w = Writer()
    packed = {"EXT_meshopt_compression": {"fallback": True}}
    w.document["buffers"] = [{"byteLength": len(w.data), "extensions": packed}]
    w.document["bufferViews"][0]["extensions"] = {"EXT_meshopt_compression": {"buffer": 0}}
    with pytest.raises(CadetError, match=r"bufferViews\[0\]: EXT_meshopt_compression is not read: decompress"):
        w.read(tmp_path)


@pytest.mark.parametrize(
    ("dtype", "is_normalized"), [("int16", True), ("uint16", True), ("int8", True), ("int16", False), ("uint8", False)]
)
def test_quantized_corners_are_read(dtype: str, is_normalized: bool, tmp_path: Path) -> None:
    w = Writer()
    most = np.iinfo(dtype).max
    least = 0.0 if dtype.startswith("u") else -1.0
    steps = np.rint((CORNERS - CORNERS.min(0)) / np.ptp(CORNERS, 0) * (1 - least) * most + least * most)
    w.primitive["attributes"]["POSITION"] = w.add(steps.astype(dtype), normalized=is_normalized)
    span = (1 - least) * (1 if is_normalized else most)
    w.document["nodes"][0]["scale"] = (np.ptp(CORNERS, 0) / span).tolist()
    mesh = w.read(tmp_path)
    assert size(mesh) == [4.2, 1.8, 1.5]
    assert volume(mesh) == pytest.approx(4.2 * 1.8 * 1.5, rel=1e-5)


def test_sparse_values_replace_some(tmp_path: Path) -> None:
    w = Writer()
    moved = [2.0 * CORNERS[7]]
    w.document["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": w.view(np.array([7], "u1").tobytes()), "componentType": 5121},
        "values": {"bufferView": w.view(np.array(moved, "f4").tobytes())},
    }
    assert size(w.read(tmp_path)) == [6.3, 2.7, 3.0]


def test_strips_and_fans_are_the_triangles_of_the_specification(tmp_path: Path) -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0]], "f4")
    for mode, indices, num in ((5, [0, 1, 2, 3, 4], 3), (6, [0, 1, 3, 2], 2), (4, [0, 1, 2, 1, 3, 2, 2], 2)):
        w = Writer()
        w.primitive.update(
            {
                "mode": mode,
                "indices": w.add(np.array(indices, "u4")),
                "attributes": {"POSITION": w.add(square)},
            }
        )
        corners = w.read(tmp_path).corners.reshape(-1, 3, 3)
        assert len(corners) == num
        # All look toward the file's +z, which is ours +x.
        assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 0] > 0).all()


def test_nodes_mirror_hide_and_carry(tmp_path: Path) -> None:
    w = Writer()
    w.document["nodes"] = [
        {"children": [1, 2], "scale": [-1, 1, 1], "name": "Car"},
        {"mesh": 0, "translation": [0, 2, 0], "name": "Body"},
        {
            "mesh": 0,
            "matrix": np.diag([9.0, 9, 9, 1]).flatten().tolist(),
            "extensions": {"KHR_node_visibility": {"visible": False}},
        },
    ]
    mesh = w.read(tmp_path)
    assert (size(mesh), mesh.parts) == ([4.2, 1.8, 1.5], (("Car", "Body"),))
    assert volume(mesh) == pytest.approx(4.2 * 1.8 * 1.5, rel=1e-5), "a mirrored box still looks outward"
    assert mesh.corners.reshape(-1, 3)[:, 2].min() == pytest.approx(2.0)


def test_skins_and_morphs_rest_as_the_file_says(tmp_path: Path) -> None:
    w = Writer()
    w.document["nodes"] = [
        {"mesh": 0, "skin": 0, "scale": [50, 50, 50]},
        {"scale": [2, 2, 2], "children": [2]},
        {"translation": [0, 0, 1]},
    ]
    w.document["scenes"] = [{"nodes": [0, 1]}]
    inverse = np.eye(4, dtype="f4")
    inverse[2, 3] = -1.0  # glTF keeps columns
    w.document["skins"] = [{"joints": [2], "inverseBindMatrices": w.add(inverse.T.reshape(1, 16))}]
    w.primitive["attributes"] |= {
        "JOINTS_0": w.add(np.zeros((8, 4), "u1")),
        "WEIGHTS_0": w.add(np.tile(np.array([[1, 0, 0, 0]], "f4"), (8, 1))),
    }
    mesh = w.read(tmp_path)
    assert size(mesh) == [8.4, 3.6, 3.0], "the joints carry the mesh, and its own node does not"
    w = Writer()
    w.primitive["targets"] = [{"POSITION": w.add((CORNERS * [1, 0, 0]).astype("f4"))}]
    w.document["meshes"][0]["weights"] = [0.5]
    assert size(w.read(tmp_path)) == [4.2, 2.7, 1.5]


def _spoil(**changes: Any) -> Callable[[Writer], None]:
    def change(w: Writer) -> None:
        for path, value in changes.items():
            *steps, last = (int(step) if step.isdigit() else step for step in path.split("__"))
            target: Any = w.document
            for step in steps:
                target = target[step]
            target[last] = value

    return change


NESTED = [{"children": [number + 1]} for number in range(300)] + [{"mesh": 0}]
WIDE = [{"children": [number + 1] * 20} for number in range(8)] + [{"mesh": 0}]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_spoil(asset=[]), "asset: expected an object, got []"),
        (_spoil(asset={"version": "1.0"}), "not a glTF 2.0 file: its asset.version is '1.0'; convert it"),
        (_spoil(nodes=NESTED), "more than 256 nodes within each other"),
        (_spoil(nodes=WIDE), "or 100000 in all"),
        (_spoil(nodes__0={"mesh": 0, "children": [0]}), "nodes[0]: more than 256 nodes within each other"),
        (_spoil(nodes__0__mesh=1), "nodes[0].mesh: expected a whole number below 1, got 1"),
        (_spoil(nodes__0__mesh=[0]), "nodes[0].mesh: expected a whole number below 1, got [0]"),
        (_spoil(nodes__0__scale=[1, 2]), "nodes[0].scale: expected 3 numbers, got [1, 2]"),
        (_spoil(nodes__0__scale=[1, 2, 10**400]), "nodes[0].scale[2]: a whole number of 401 digits"),
        (_spoil(nodes__0__matrix=[True] * 16), "nodes[0].matrix: expected 16 numbers"),
        (_spoil(scenes__0__nodes=[3]), "scenes[0].nodes: expected whole numbers below 1, got [3]"),
        (_spoil(scene=-1), "scene: expected a whole number below 1, got -1"),
        (_spoil(accessors__0__count=10**12), "accessors[0]: more than 100000000 values"),
        (_spoil(accessors__0__count=9), "accessors[0]: beyond the end of its view"),
        (_spoil(accessors__0__componentType=5124), "accessors[0].componentType: expected one of 5120"),
        (_spoil(accessors__0__type="VEC2"), "accessors[0].type: expected VEC3, got 'VEC2'"),
        (_spoil(accessors__1__componentType=5126, accessors__1__count=18), "expected unsigned whole numbers"),
        (_spoil(accessors__1__byteOffset=10**9), "accessors[1]: beyond the end of its view"),
        (_spoil(bufferViews__0__byteLength=10**9), "bufferViews[0]: beyond the end of its buffer"),
        (
            _spoil(accessors__0={"componentType": 5126, "count": 8 * 10**7, "type": "VEC3"}),
            "more than 100000000 values",
        ),
        (_spoil(accessors__1__sparse={"count": 99}), "accessors[1].sparse.count: expected a whole number below 37"),
        (_spoil(materials__0__name=["a"]), "materials[0].name: expected a string, got ['a']"),
        (_spoil(materials__0__pbrMetallicRoughness=[]), "materials[0].pbrMetallicRoughness: expected an object"),
        (_spoil(materials=7), "materials: expected a list of objects, got 7"),
        (_spoil(extensionsRequired={"a": 1}), "extensionsRequired: expected a list of strings"),
        (_spoil(meshes__0__primitives__0__indices=0), "expected SCALAR, got 'VEC3'"),
        (_spoil(meshes__0__primitives__0__mode=1), "no triangles in its scene"),
    ],
)
def test_damage_is_refused_where_it_is(spoil: Callable[[Writer], None], message: str, tmp_path: Path) -> None:
    w = Writer()
    spoil(w)
    with pytest.raises(CadetError) as caught:
        w.read(tmp_path)
    said = str(caught.value)
    assert said.startswith("m.gltf: ") and message in said and "\n" not in said


def test_names_are_found_as_exporters_write_them(tmp_path: Path) -> None:
    w = Writer()
    data = w.data
    (tmp_path / "Tex").mkdir()
    for name, uri in (
        ("a b%.bin", "a%20b%25.bin"),
        ("50%.bin", "50%.bin"),
        ("Tex/C.BIN", "tex\\c.bin"),
        ("é.bin", "é.bin"),
    ):
        (tmp_path / name).write_bytes(data)
        w.document["buffers"] = [{"byteLength": len(data), "uri": uri}]
        assert size(w.read(tmp_path)) == [4.2, 1.8, 1.5]
