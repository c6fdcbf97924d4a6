"""OBJ files and material libraries as other programs write them: the same box, or one line that says what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cadet import CadetError
from cadet.worlds.meshes import Beside, MeshTriangles, obj_from_bytes
from mesh_files.gltf_boxes import png_bytes

CORNERS = "".join(f"v {x} {y} {z}\n" for x in (0, 4) for y in (0, 1.8) for z in (0, 1.5))
PLACES = "vt 0.25 0.5\nvt 0.75 0.5\n"
SIDES = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
FACES = "".join(f"f {a} {b} {c} {d}\n" for a, b, c, d in SIDES)
RED = (0.6, 0.0, 0.0)
LIBRARY = "newmtl Paint\nKd 0.6 0 0\n"


def read(folder: Path, obj: str | bytes, **files: str | bytes) -> MeshTriangles:
    """Read an OBJ file with files beside it; `_` stands for the dot in their names."""
    for name, content in files.items():
        data = content.encode() if isinstance(content, str) else content
        (folder / name.replace("_", ".")).write_bytes(data)
    mesh = folder / "m.obj"
    return obj_from_bytes(obj.encode() if isinstance(obj, str) else obj, "m.obj", Beside(folder, mesh))


def colors(mesh: MeshTriangles) -> dict[str, tuple[float, ...] | None]:
    return {material.name: material.albedo for material in mesh.materials}


def volume(mesh: MeshTriangles) -> float:
    a, b, c = mesh.corners.astype(float).reshape(-1, 3, 3).transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum() / 6.0)


BOX = f"mtllib m.mtl\n{CORNERS}usemtl Paint\n{FACES}"


@pytest.mark.parametrize(
    "obj",
    [
        BOX,
        BOX.rstrip("\n"),
        BOX.replace("\n", "\r\n"),
        BOX.replace("\n", "\r"),
        b"\xef\xbb\xbf" + BOX.encode(),
        BOX.encode("utf-16"),
        b"# Gr\xf6\xdfe \x85 in m\n" + BOX.encode(),
        BOX.replace("1 2 4 3", "1 2 \\\n4 3").replace("1 5 6 2", "1 \\  \r\n5 \\\n 6 2"),
        BOX.replace(" ", "\t"),
        BOX.replace("\n", "   \n").replace("f ", "  f  "),
        BOX.replace("f 1 2 4 3", "f 1 2 4 3 # front\n# C:\\models\\").replace("v 0 0 0", "v 0 0 0 # first"),
        BOX.replace("f 1 2 4 3", "f -8 -7 -5 -6"),
        PLACES + BOX.replace("f 1 2 4 3", "f 1/1 2/2 4/1 3/1").replace("f 1 5 6 2", "f 1/1/1 5//1 6/-1/3 2"),
        BOX.replace("f 1 2 4 3", "f 1/1/1 2/1/1 4/1/1 3/1/1").replace("f 5 7 8 6", "f 5// 7// 8// 6//"),
        BOX.replace("f 1 2 4 3", "f 1//1 2//1 4//1 3//1").replace("f 5 7 8 6", "fo 5/ 7/ 8/ 6/"),
        BOX.replace("usemtl", "s 1\nl 1 2\np 1 2 3\nvp 0.5\nvn 0 0 1\nf 1 2\no Body of it\ng a b\nusemtl"),
        BOX.replace("v 0 0 0\n", "v 0 0 0 1.0\n"),
        BOX.replace("usemtl Paint", "g\nusemtl Paint # the first"),
        BOX.replace("usemtl Paint", "usemtl paint"),
        # Each face after its own corners (trimesh 2364), and groups that are named like faces (trimesh 1829).
        "mtllib m.mtl\nusemtl Paint\ng f 1 2 3\n"
        + "".join("".join(f"{CORNERS.splitlines()[c - 1]}\n" for c in side) + "f -4 -3 -2 -1\n" for side in SIDES),
        BOX.replace("mtllib m.mtl", "mtllib M.MTL"),
        BOX.replace("mtllib m.mtl", "mtllib C:\\work\\cars\\m.mtl"),
        BOX.replace("mtllib m.mtl", "mtllib /home/me/m.mtl # written by me"),
        BOX.replace("mtllib m.mtl", 'mtllib "m.mtl"'),
        BOX.replace("mtllib m.mtl", "mtllib other.mtl m.mtl"),
        BOX.replace("mtllib m.mtl", "mtllib other.mtl\nmtllib m.mtl"),
    ],
)
def test_what_programs_write_is_the_same_red_box(obj: str | bytes, tmp_path: Path) -> None:
    mesh = read(tmp_path, obj, m_mtl=LIBRARY, other_mtl="newmtl Other\nKd 0 1 0\n")
    assert len(mesh.corners) == 12
    assert volume(mesh) == pytest.approx(4 * 1.8 * 1.5)
    assert colors(mesh) == {"Paint": RED}
    assert mesh.notes == ()


@pytest.mark.parametrize(
    ("library", "color", "opacity", "note"),
    [
        ("Kd 0.5", (0.5, 0.5, 0.5), 1.0, None),
        ("Kd 0.6 0 0 1.0", RED, 1.0, None),
        ("KD\t0.6  0\t0 # red", RED, 1.0, None),
        ("Kd 0.6 \\\n 0 0", RED, 1.0, None),  # three.js 4984
        ("Kd 153 0 0", RED, 1.0, "m.mtl:2: Kd '153 0 0' is read as bytes"),
        ("Kd spectral x.rfl 1", None, 1.0, "m.mtl:2: Kd 'spectral x.rfl 1' is not read: the material is gray"),
        ("Kd xyz 0.2 0.2 0.2", None, 1.0, "is not read"),
        ("Kd 0.6 0 0\nKs 0.1 x\nillum 2.0\nNs -1.#IND\nKa\nmap_Bump", RED, 1.0, None),
        ("Kd 0.6 0 0\nd 0.3", RED, 0.3, None),
        ("Kd 0.6 0 0\nd -halo 0.3", RED, 0.3, None),
        ("Kd 0.6 0 0\nTr 0.7", RED, 0.3, None),
        ("Kd 0.6 0 0\nTr 0.7\nd 0.4", RED, 0.4, None),
        ("Kd 0.6 0 0\nd 0.4\nTr 0.7", RED, 0.4, None),
        ("Kd 0.6 0 0\nD 0.3\nTr 0.3", RED, 0.3, None),  # IfcOpenShell 140, LeoCAD 20
        ("Kd 0.6 0 0\nTr 1.0", RED, 1.0, "m.mtl:3: Tr 1 alone would be nothing at all: read as opaque"),
        ("Kd 0.6 0 0\nmap_Kd", RED, 1.0, None),
        ("Kd 0.6 -1e308 0", RED, 1.0, None),
        (
            "Kd 0.6 0 0\nmap_Kd gone.png",
            RED,
            1.0,
            "pictures that are not read: 'gone.png' (not there): their materials have Kd alone",
        ),
        (
            "Kd 0 0 0\nmap_Kd gone.png",
            None,
            1.0,
            "'gone.png' (not there): their materials have Kd alone, gray paint where it is black; put them",
        ),
        ("map_Kd m.mtl", None, 1.0, "'m.mtl' (no PNG, JPEG or WebP image"),
        ("Kd 0.6 0 0\nmap_d mask.png", RED, 1.0, "its map_d is not read: give its opacity as d"),
        ("", None, 1.0, None),
    ],
)
def test_libraries_are_read_as_programs_write_them(
    library: str, color: tuple[float, ...] | None, opacity: float, note: str | None, tmp_path: Path
) -> None:
    mesh = read(tmp_path, BOX, m_mtl=f"newmtl Paint\n{library}\n")
    (material,) = mesh.materials
    assert material.albedo == (None if color is None else pytest.approx(color))
    assert material.opacity == pytest.approx(opacity)
    assert [note in line for line in mesh.notes] == [True] if note is not None else mesh.notes == ()


@pytest.mark.parametrize(
    ("obj", "names", "note"),
    [
        (BOX.replace("usemtl Paint", "usemtl"), {""}, None),
        (
            BOX.replace("usemtl Paint", "usemtl Lack"),
            {"Lack"},
            "m.obj: no material 'Lack' in its libraries: gray paint",
        ),
        (
            BOX.replace("m.mtl", "none.mtl"),
            {"Paint"},
            "no material library 'none.mtl' beside it (there is m.mtl): gray",
        ),
        (BOX.replace("m.mtl", "a b.mtl"), {"Paint"}, "no material library 'a b.mtl' beside it (there is m.mtl): gray"),
        (BOX.replace("mtllib m.mtl\n", ""), {"Paint"}, "m.obj: no line names a material library (mtllib): gray paint"),
        (f"{CORNERS}{FACES}", {""}, None),
    ],
)
def test_what_has_no_color_is_gray_and_said_once(obj: str, names: set[str], note: str | None, tmp_path: Path) -> None:
    mesh = read(tmp_path, obj, m_mtl=LIBRARY)
    assert colors(mesh) == dict.fromkeys(names)
    assert [note in line for line in mesh.notes] == [True] if note is not None else mesh.notes == ()


@pytest.mark.parametrize(
    ("kd", "options", "first", "second"),
    [
        ("1 1 1", "", (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)),
        ("0 0 0", "", (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)),
        ("0.5 0.5 0.5", "", (0.0, 0.5, 0.0), (0.0, 0.0, 0.0)),
        ("1 1 1", "-s 1 1 1 -o 0.5 0 0 ", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ("1 1 1", "-clamp on -o 0.5 ", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ("1 1 1", "-blendu on -mm 0 1 -bm 1.0 -imfchan l C:\\textures\\", (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)),
    ],
)
def test_a_picture_colors_each_face_where_it_lies_in_it(
    kd: str, options: str, first: tuple[float, ...], second: tuple[float, ...], tmp_path: Path
) -> None:
    (tmp_path / "two colors.png").write_bytes(png_bytes((0, 255, 0), (0, 0, 0)))
    obj = f"mtllib m.mtl\n{CORNERS}{PLACES}usemtl Paint\n"
    obj += "".join("f " + " ".join(f"{c}/{1 if n < 3 else 2}" for c in side) + "\n" for n, side in enumerate(SIDES))
    mesh = read(tmp_path, obj, m_mtl=f"newmtl Paint\nKd {kd}\nmap_Kd {options}two colors.png\n")
    found = [mesh.materials[number].albedo for number in mesh.material_ids]
    np.testing.assert_allclose(found[:6], [first] * 6, atol=0.003)
    np.testing.assert_allclose(found[6:], [second] * 6, atol=0.003)


def test_corners_have_colors_in_srgb(tmp_path: Path) -> None:
    for red in ("0.5", "127.5"):
        lines = [f"{line} {red} 0 0" if line.startswith("v ") else line for line in f"{CORNERS}{FACES}".splitlines()]
        mesh = read(tmp_path, "\n".join(lines))
        assert colors(mesh)[""] == pytest.approx((0.214, 0.0, 0.0), abs=0.005)


@pytest.mark.parametrize(
    ("obj", "message"),
    [
        ("", "m.obj: no faces: is it a Wavefront OBJ file?"),
        ("\x89PNG\n\0", "m.obj: no faces: is it a Wavefront OBJ file?"),
        (
            "v 0 0 0\ncstype bspline\nsurf 0 1 0 1 1 2\n",
            "m.obj: no faces: its surfaces are free-form, export it as poly",
        ),
        ("v 0 0\n", "m.obj:1: v: expected three numbers, got '0 0'"),
        ("v 0,5 1,0 2,5\n", "m.obj:1: v: expected three numbers, got '0,5 1,0 2,5'; decimal points, not commas"),
        (f"{CORNERS}f 1 2 9\n", "m.obj:9: f: corner 9 of 8: the file is cut or damaged"),
        (f"{CORNERS}f 1 2 3\nf 1 -9 3\n", "m.obj:10: f: no corner -9: they are counted from 1"),
        (f"{CORNERS}f 0 1 2\n", "m.obj:9: f: no corner 0: they are counted from 1"),
        (f"{CORNERS}f 1 two 3\n", "m.obj:9: f: expected corners such as 1, 1/2, or 1//3, got 'two'"),
        (f"{CORNERS}vt 0 0\nf 1/1 2/7 3/1\n", "m.obj:10: f: texture coordinate 7 of 1"),
        (f"{CORNERS}v nan 0 0\nf 1 2 9\n", "m.obj:9: v: a coordinate is not finite: (nan, 0, 0)"),
        (f"{CORNERS}v 1e300 0 0\nf 1 2 9\n", "m.obj:9: v: a coordinate is not finite"),
        (f"{CORNERS}v 1.#QNAN 0 0\n", "m.obj:9: v: expected three numbers"),
        (f"{CORNERS}f{' 1 2' * 600}\n", "m.obj:9: a face of 1200 corners, at most 1000"),
        (f"mtllib m.mtl\n{CORNERS}usemtl Paint\n{FACES}", "m.mtl:2: Kd: expected one or three numbers, got '1 2'"),
        (f"mtllib n.mtl\n{CORNERS}usemtl Paint\n{FACES}", "n.mtl:3: d: expected numbers, got 'x': correct the line"),
    ],
)
def test_what_makes_no_sense_is_refused_by_its_line(obj: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(CadetError) as caught:
        read(tmp_path, obj, m_mtl="newmtl Paint\nKd 1 2\n", n_mtl="newmtl Paint\n\nd x\n")
    assert str(caught.value).startswith(message)


def test_corners_that_no_face_has_may_be_anything(tmp_path: Path) -> None:
    assert len(read(tmp_path, f"{CORNERS}v nan inf 0\n{FACES}").corners) == 12


def test_objects_and_groups_are_parts(tmp_path: Path) -> None:
    mesh = read(tmp_path, f"{CORNERS}o Car\ng body\nf 1 2 4 3\ng Shadow plane\nf 5 7 8 6\no Wheel\nf 1 5 6 2\n")
    assert [mesh.parts[number] for number in mesh.part_ids[::2]] == [
        ("Car", "body"),
        ("Car", "Shadow plane"),
        ("Wheel", ""),
    ]


def test_nothing_is_read_from_outside_of_the_folder(tmp_path: Path) -> None:
    root = tmp_path / "own"
    root.mkdir()
    (tmp_path / "m.mtl").write_text(LIBRARY)
    with pytest.raises(
        CadetError, match=r"'\.\./m\.mtl' lies outside of the folder of assets: copy it beside the mesh"
    ):
        read(root, BOX.replace("m.mtl", "../m.mtl"))
    (root / "m.mtl").symlink_to(tmp_path / "m.mtl")
    with pytest.raises(CadetError, match="lies outside"):
        read(root, BOX)
