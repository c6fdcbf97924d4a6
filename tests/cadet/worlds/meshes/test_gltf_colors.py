"""Colors of glTF files: textures at each face's coordinates, factors, alphas, corners, and pictures not read."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mesh_files.gltf_boxes import Writer, png, textured

RED, GREEN, BLUE, BLACK = (255, 0, 0), (0, 255, 0), (0, 0, 255), (0, 0, 0)
LEFT = [[0.25, 0.25]] * 8


@pytest.mark.parametrize(
    ("transform", "wrap", "expected"),
    [
        ({}, 10497, RED),
        ({"offset": [0.5, 0]}, 10497, GREEN),
        ({"offset": [0, 0.5]}, 10497, BLUE),
        ({"scale": [3, 1]}, 10497, GREEN),
        ({"scale": [7, 1]}, 33071, GREEN),
        ({"offset": [1, 0]}, 33648, GREEN),
        ({"offset": [-1, 0]}, 10497, RED),
        # Counter-clockwise, v down: (0.25, 0.25) comes to (0.25, -0.25), above the picture: its lower row again.
        ({"rotation": np.pi / 2}, 10497, BLUE),
        ({"texCoord": 1}, 10497, BLACK),
    ],
)
def test_textures_are_moved_and_wrapped(
    transform: dict[str, Any], wrap: int, expected: tuple[int, ...], tmp_path: Path
) -> None:
    w = textured(png(RED, GREEN, BLUE, BLACK, rows=2), uv=LEFT, sampler=0)
    w.document["samplers"] = [{"wrapS": wrap, "wrapT": wrap}]
    w.primitive["attributes"]["TEXCOORD_1"] = w.add(np.full((8, 2), 0.75, "f4"))
    info = w.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
    info["extensions"] = {"KHR_texture_transform": transform}
    (material,) = w.read(tmp_path).materials
    assert material.albedo == pytest.approx(np.array(expected) / 255, abs=0.003)


def test_palettes_color_each_face(tmp_path: Path) -> None:
    uv = [[0.25, 0.5]] * 4 + [[0.75, 0.5]] * 4
    w = textured(png(GREEN, BLACK))
    w.document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [1, 0.5, 1, 1]
    w.primitive["attributes"]["TEXCOORD_0"] = w.add((np.array(uv) * 255).astype("u1"), normalized=True)
    mesh = w.read(tmp_path)
    of_face = [mesh.materials[number].albedo for number in mesh.material_ids]
    np.testing.assert_allclose(of_face[:2], [(0, 0.5, 0)] * 2, atol=0.003)
    np.testing.assert_allclose(of_face[2:4], [(0, 0, 0)] * 2, atol=0.003)
    assert {m.name for m in mesh.materials} == {"skin"}


def test_without_texture_coordinates_the_mean_is_taken(tmp_path: Path) -> None:
    # Half black, half full red: a mean of 0.5 in linear light, 0.21 by sRGB's numbers; nothing of what is clear.
    (material,) = textured(png((255, 0, 0, 255), (0, 0, 0, 255), (0, 255, 0, 0))).read(tmp_path).materials
    assert material.albedo == pytest.approx((0.5, 0.0, 0.0), abs=0.003)
    assert material.opacity == 1.0


@pytest.mark.parametrize(
    ("more", "alpha", "opacity"),
    [
        ({}, 51, 1.0),
        ({"alphaMode": "BLEND"}, 51, 0.2),
        ({"alphaMode": "MASK"}, 51, 0.0),
        ({"alphaMode": "MASK", "alphaCutoff": 0.1}, 51, 1.0),
        ({"alphaMode": "BLEND", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}}}, 255, 0.5),
    ],
)
def test_alphas_make_panes(more: dict[str, Any], alpha: int, opacity: float, tmp_path: Path) -> None:
    w = textured(png((255, 255, 255, alpha)), uv=LEFT)
    w.document["materials"][0] |= more
    (material,) = w.read(tmp_path).materials
    assert material.opacity == pytest.approx(opacity, abs=1e-6)


def test_corners_and_old_materials_have_colors(tmp_path: Path) -> None:
    w = Writer()
    w.primitive["attributes"]["COLOR_0"] = w.add(np.full((8, 4), 32768, "u2"), normalized=True)
    (material,) = w.read(tmp_path).materials
    assert material.albedo == pytest.approx((0.4, 0.05, 0.05), abs=0.003)
    w = textured(png(GREEN))
    old = {"diffuseFactor": [0.5, 0.5, 0.5, 1], "diffuseTexture": {"index": 0}}
    w.document["materials"] = [{"name": "old", "extensions": {"KHR_materials_pbrSpecularGlossiness": old}}]
    (material,) = w.read(tmp_path).materials
    assert material.albedo == pytest.approx((0.0, 0.5, 0.0), abs=0.003)


KTX = {"uri": "data:image/ktx2;base64," + base64.b64encode(b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(60)).decode()}


@pytest.mark.parametrize(
    ("images", "texture", "color", "note"),
    [
        ([png(RED)], {"source": None, "extensions": {"EXT_texture_webp": {"source": 0}}}, (1, 0, 0), None),
        ([png(RED), KTX], {"extensions": {"KHR_texture_basisu": {"source": 1}}}, (1, 0, 0), None),
        ([KTX, png(RED)], {"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}, (1, 0, 0), None),
        (
            [KTX],
            {"source": None, "extensions": {"KHR_texture_basisu": {"source": 0}}},
            None,
            "not read: 'image 0' (KTX): their materials are gray",
        ),
        ([], {"source": None}, None, "'textures[0]' (names no picture): their materials are gray paint; put"),
        ([{"uri": "gone.png"}], {}, None, "pictures that are not read: 'gone.png' (not there): their"),
        ([{"uri": "data:,text"}], {}, None, "'image 0' (no PNG, JPEG or WebP image"),
    ],
)
def test_textures_take_the_picture_that_can_be_read(
    images: list[dict[str, str]], texture: dict[str, Any], color: Any, note: str | None, tmp_path: Path
) -> None:
    mesh = textured(*images, uv=LEFT, **texture).read(tmp_path)
    (material,) = mesh.materials
    assert material.albedo == (None if color is None else pytest.approx(color))
    assert [note in line for line in mesh.notes] == [True] if note else mesh.notes == ()


def test_a_million_colors_become_few_near_ones(tmp_path: Path) -> None:
    side = 150
    grid = np.stack(np.meshgrid(np.linspace(0, 4, side), np.linspace(0, 1.8, side)), -1).reshape(-1, 2)
    corners = np.column_stack([grid, np.sin(grid[:, 0])]).astype("f4")
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1)
    w = textured(png(*[(i, j, 128) for j in range(0, 256, 2) for i in range(0, 256, 2)], rows=128))
    w.primitive.update(
        {
            "attributes": {"POSITION": w.add(corners), "TEXCOORD_0": w.add((grid / [4, 1.8]).astype("f4"))},
            "indices": w.add(np.column_stack([first, first + 1, first + side]).reshape(-1).astype("u4")),
        }
    )
    mesh = w.read(tmp_path)
    assert 100 < len(mesh.materials) <= 254
    found = np.sqrt([mesh.materials[number].albedo for number in mesh.material_ids])
    stated = (grid[first] + grid[first + 1] + grid[first + side]) / 3.0 / [4, 1.8]
    linear = np.where(stated <= 0.04045, stated / 12.92, ((stated + 0.055) / 1.055) ** 2.4)
    assert np.abs(found[:, :2] - np.sqrt(linear)).max() < 0.1
    assert np.abs(found[:, :2] - np.sqrt(linear)).mean() < 0.03
