"""Meshes and maps that ended the process, vanished without a word, or took minutes."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

import cadet
from cadet import _cadet
from cadet.errors import CadetError
from cadet.worlds.assets import Assets
from fuzz.road_text import ROADS, map_of, road
from mesh_files.obj_meshes import MTL, assets_folder


def scene_of(xodr: str) -> Any:
    rig = cadet.Rig(camera=cadet.Camera.kitti().resized(124, 38), lidar=cadet.Lidar.vlp16())
    return _cadet.Scene.empty(
        map_name="m.xodr",
        map_xodr=xodr,
        weather=cadet.Weather()._to_native(),
        rig=rig._to_native(),
        config=cadet.SceneConfig()._to_native(),
        assets=None,
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('bV="0"', 'bV="1e308"', r'm\.xodr:\d+: road 4: <paramPoly3 bV>: expected a number .*, got "1e308"'),
        ('curvature="0.02"', 'curvature="nan"', r'm\.xodr:\d+: road 1: <arc curvature>: expected a number .*"nan"'),
        ('id="3" length="40.0"', 'id="3" length="-40"', r"m\.xodr:\d+: road 3: <road length>: expected from 0 to"),
        ('id="3" length="40.0"', 'id="3" length="0"', r'm\.xodr: road "3" skipped: '),
        ('<poly3 a="0" b="0" c="0.01" d="0"/>', "<poly7/>", r"m\.xodr:31: road 3: <geometry> without <line>"),
        ('a="3.2"', 'a="39000"', r"m\.xodr: road 0: a lane is 39\d+\.\d m wide, expected at most 100 m"),
        (
            'b="0.01"',
            'b="390"',
            r"m\.xodr: road 0: a lane is at a height of \d+ m, expected at most 10000 m above or",
        ),
        ('<lane id="-1"', '<lane id="minus"', r'm\.xodr: road "0"'),
    ],
)
def test_broken_roads_are_refused_with_file_and_road(old: str, new: str, message: str) -> None:
    assert old in ROADS
    with pytest.raises(CadetError, match=f"^{message}"):
        scene_of(ROADS.replace(old, new, 1))


@pytest.mark.parametrize("character", ["\n", "\r", "\t", "\x85"])
def test_what_is_refused_is_told_in_one_line(character: str) -> None:
    """The XML reader quotes the character that it stumbles over."""
    with pytest.raises(CadetError, match=r"^m\.xodr:[12]: not readable as XML: ") as refused:
        scene_of(f'<OpenDRIVE><header revMajor="1"/{character}</OpenDRIVE>')
    assert str(refused.value).isprintable()


def test_a_piece_of_road_without_a_length_is_no_loss() -> None:
    piece = '<geometry s="40.0" x="40" y="0" hdg="0" length="0"><line/></geometry>\n</planView>'
    assert scene_of(ROADS.replace("</planView>", piece, 1)).num_triangles == scene_of(ROADS).num_triangles


def test_time_grows_with_the_number_of_roads_and_not_its_square() -> None:
    def seconds(count: int) -> float:
        roads = map_of("".join(road(i, x=i // 20 * 60.0, y=i % 20 * 20.0) for i in range(count)))
        begin = time.process_time()
        scene_of(roads)
        return time.process_time() - begin

    seconds(50)
    assert seconds(1200) < 10.0 * seconds(200)


@pytest.mark.parametrize(
    ("mtl", "obj", "message"),
    [
        (MTL.replace("0.1 0.2 0.5", "a b c"), "", r"car\.mtl:2: Kd: "),
        (MTL, "f 1 2 4\nf 1 2 3\n" * 500_000, r"more than 1000 triangles meet in one place"),
        (
            MTL,
            f"f {' '.join(str(1 + i % 48) for i in range(200_000))}\n",
            r"car\.obj:\d+: a face of 200000 corners, at most 1000: cut it into triangles",
        ),
    ],
)
def test_meshes_that_the_reader_stops_on_are_refused(tmp_path: Path, mtl: str, obj: str, message: str) -> None:
    root = assets_folder(tmp_path / "assets")
    (root / "meshes" / "car.mtl").write_text(mtl)
    with (root / "meshes" / "car.obj").open("a") as file:
        file.write(obj)
    begin = time.process_time()
    with pytest.raises(CadetError, match=message):
        Assets.read(root)
    assert time.process_time() - begin < 20.0


def test_a_meshs_name_holds_no_null_byte(tmp_path: Path) -> None:
    root = assets_folder(tmp_path / "assets", '[[actor]]\nname = "a"\nclass = "Car"\nmesh = "a\\u0000b"\n')
    message = r"^assets\.toml: actor 1\.mesh: expected the path of an OBJ or glTF file, got "
    with pytest.raises(CadetError, match=message):
        Assets.read(root)
