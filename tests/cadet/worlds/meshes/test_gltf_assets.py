"""glTF meshes: the same car as an OBJ file gives, and broken files refused in one line."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

import cadet
from cadet.cli.gen import cadet_gen
from mesh_files.gltf_meshes import glb, gltf_of, write_gltf
from mesh_files.obj_meshes import CAR, assets_folder, car_obj


def gltf_folder(root: Path, name: str = "car.gltf", *, inside: bool = False) -> Path:
    folder = assets_folder(root, CAR.replace("car.obj", name))
    write_gltf(folder / "meshes" / name, *gltf_of(car_obj()), inside=inside)
    return folder


def captured(folder: Path) -> cadet.Frame:
    scene = cadet.Scene.empty(assets=folder)
    scene.add("car", x_m=12.0, y_m=1.0, yaw_rad=2.5, model="mine")
    return scene.capture()


def actor_triangles(folder: Path) -> NDArray[np.float64]:
    scene = cadet.Scene.empty(assets=folder)
    scene.add("car", x_m=12.0, y_m=1.0, yaw_rad=0.0, model="mine")
    vertices, faces, actor_ids = scene.triangles()
    corners = vertices[faces[actor_ids > 0]].astype(np.float64)
    rows = np.sort(corners.reshape(len(corners), -1).round(3), axis=0)
    return np.asarray(rows)


@pytest.mark.parametrize(("name", "inside"), [("car.gltf", False), ("car.gltf", True), ("car.glb", False)])
def test_the_same_car_from_gltf_and_obj(name: str, inside: bool, tmp_path: Path) -> None:
    obj = assets_folder(tmp_path / "obj")
    gltf = gltf_folder(tmp_path / "gltf", name, inside=inside)
    np.testing.assert_allclose(actor_triangles(gltf), actor_triangles(obj), atol=2e-3)
    # Its nose, colors, and panes too: what camera and LIDAR see of it.
    ours, theirs = captured(gltf), captured(obj)
    assert np.abs(ours.image.astype(int) - theirs.image.astype(int)).mean() < 0.05
    assert ours.labels == theirs.labels
    assert len(ours.points_velo) == pytest.approx(len(theirs.points_velo), rel=1e-3)


def _spoil(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def spoil(path: Path) -> None:
        document = json.loads(path.read_text())
        change(document)
        path.write_text(json.dumps(document))

    return spoil


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.write_bytes(b"glTF\x02\0\0\0"), "the container ends in its header"),
        (lambda path: path.write_bytes(glb(b"{}", b"")[:-4]), "of 28 bytes|version 2"),
        (lambda path: path.write_text("{"), "invalid JSON"),
        (lambda path: path.write_text("[]"), "invalid glTF: expected an object"),
        (_spoil(lambda d: d["buffers"][0].update(uri="gone.bin")), "no file 'gone.bin' beside it"),
        (_spoil(lambda d: d["buffers"][0].update(uri="../../x.bin")), "'../../x.bin' lies outside of the folder"),
        (_spoil(lambda d: d["buffers"][0].update(uri="data:,abc")), r"buffers\[0\]: 3 bytes of 1440"),
        (_spoil(lambda d: d["buffers"][0].update(uri="data:;base64,\u00e9")), "data that are not base64"),
        (_spoil(lambda d: d["buffers"][0].update(uri="\ud800.bin")), "half of a surrogate pair"),
        (_spoil(lambda d: d["buffers"][0].update(uri="https://a.b/c.bin")), "not fetched: save it beside the mesh"),
        (_spoil(lambda d: d["buffers"][0].update(uri=7)), r"buffers\[0\].uri: expected a string, got 7"),
        (_spoil(lambda d: d["buffers"][0].update(byteLength=10**9)), r"buffers\[0\]: \d+ bytes of 1000000000"),
        (_spoil(lambda d: d["nodes"][0].update(children=[0])), "within each other"),
        (_spoil(lambda d: d["accessors"][1].update(count=10**6)), r"accessors\[1\]: beyond the end of its view"),
        (_spoil(lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"])), "KHR_draco_mesh_compression"),
        (_spoil(lambda d: d.update(images=[{"uri": "the%20buffer.bin"}], textures=[{"source": 0}])), None),
        (_spoil(lambda d: d.update(scenes=[])), None),
        (_spoil(lambda d: d["asset"].update(version="1.0")), "its asset.version is '1.0'; convert it"),
    ],
)
def test_broken_files_are_refused_in_one_line(
    spoil: Callable[[Path], None], message: str | None, tmp_path: Path
) -> None:
    folder = gltf_folder(tmp_path / "own")
    (tmp_path / "x.bin").write_bytes(b"")
    spoil(folder / "meshes" / "car.gltf")
    if message is None:  # a picture that no material shows is not looked at; without scenes all nodes are shown
        cadet.Assets.read(folder)
        return
    with pytest.raises(cadet.CadetError, match=message) as error:
        cadet.Assets.read(folder)
    assert "\n" not in str(error.value)


def test_gltf_has_its_own_axes(tmp_path: Path) -> None:
    folder = gltf_folder(tmp_path / "own")
    (folder / "assets.toml").write_text(CAR.replace("car.obj", "car.gltf") + 'up = "y"\n')
    with pytest.raises(cadet.CadetError, match=r"actor 1\.up: glTF files say themselves"):
        cadet.Assets.read(folder)


def test_bad_meshes_are_left_out_where_that_is_asked_for(tmp_path: Path) -> None:
    toml = (
        CAR + CAR.replace("mine", "broken").replace("car.obj", "broken.obj") + CAR.replace("mine", "gone") + "x = 1\n"
    )
    folder = assets_folder(tmp_path / "own", toml)
    (folder / "meshes" / "broken.obj").write_text("v 0 0 0\n")
    with pytest.raises(cadet.CadetError):
        cadet.Assets.read(folder)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assets = cadet.Assets.read(folder, skip_bad=True)
    assert [actor.name for actor in assets.actors] == ["mine"]
    said = [str(warning.message) for warning in caught if issubclass(warning.category, cadet.CadetWarning)]
    assert any("broken.obj: no faces" in line and "actor 2 is left out" in line for line in said)
    assert any("unknown key 'x'" in line and "actor 3 is left out" in line for line in said)
    (folder / "meshes" / "car.obj").write_text("")
    with (
        pytest.warns(cadet.CadetWarning, match="actor 1 is left out"),
        pytest.raises(cadet.CadetError, match="none of its 3 actors can be used"),
    ):
        cadet.Assets.read(folder, skip_bad=True)


def test_the_command_takes_the_switch_with_assets_alone(tmp_path: Path) -> None:
    result = CliRunner().invoke(cadet_gen, [str(tmp_path / "out"), "--skip-bad"])
    assert result.exit_code != 0
    assert "--skip-bad: goes with assets" in str(result.exception or result.output)
