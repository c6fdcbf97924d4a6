"""Folders of assets: what is read, what is refused, and what a dataset records of them."""

from __future__ import annotations

import json
import pickle
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from cadet import ActorMesh, Assets, CadetError, Environment, MissingFileError, ResetPolicy, Scene
from gen_process import FAILED, FINE, SIZE, run
from mesh_files.obj_meshes import CAR, MTL, assets_folder, car_mesh, car_obj


def test_a_folder_is_read_with_all_its_texts(tmp_path: Path) -> None:
    toml = f'share = 0.25\n{CAR}scale = 2\nyaw_deg = 180.0\nup = "y"\nsize_lwh = [4, 1.7, 1.4]\nmaterials.lamp = ["B*"]'
    assets = Assets.read(assets_folder(tmp_path / "own", toml))
    assert assets.share == 0.25
    (mine,) = assets.actors
    assert (mine.name, mine.type, mine.file) == ("mine", "Car", "meshes/car.obj")
    assert len(mine.mesh.corners) == 2 * car_obj().count("\nf ")
    assert {m.name: m.albedo for m in mine.mesh.materials} == {
        "Body": (0.1, 0.2, 0.5),
        "Glass": (0.2, 0.2, 0.2),
        "Tyre": (0.0, 0.0, 0.0),
    }, "a library lies beside its mesh, wherever it was written"
    assert (mine.scale, mine.yaw_deg, mine.up, mine.size_lwh) == (2, 180.0, "y", (4, 1.7, 1.4))
    assert mine.materials == (("lamp", ("B*",)),)


def test_the_hash_is_of_the_contents_and_not_of_the_place(tmp_path: Path) -> None:
    one = Assets.read(assets_folder(tmp_path / "one"))
    two = Assets.read(assets_folder(tmp_path / "two"))
    assert one == two
    assert one.to_dict() == two.to_dict()
    assert pickle.loads(pickle.dumps(one)) == one
    (mesh,) = one.actors

    def changed(name: str) -> Path:
        root = assets_folder(tmp_path / name)
        with (root / "meshes" / name).open("a") as file:
            file.write("# changed\n")
        return root

    assert replace(mesh, file="elsewhere.obj").sha256 == mesh.sha256
    others = [
        *(Assets.read(changed(name)).actors[0] for name in ("car.obj", "car.mtl")),
        replace(mesh, scale=1.5),
        replace(mesh, yaw_deg=1.0),
        replace(mesh, type="Van"),
        replace(mesh, materials=(("glass", ("Body",)),)),
    ]
    assert len({mesh.sha256, *(other.sha256 for other in others)}) == 7


def test_a_policy_without_assets_says_nothing_of_them(tmp_path: Path) -> None:
    policy = ResetPolicy.kitti()
    assert "assets" not in policy.to_dict()
    assets = Assets.read(assets_folder(tmp_path / "own"))
    own = replace(policy, assets=assets)
    assert own.to_dict()["assets"] == {
        "share": 0.5,
        "actors": [{"name": "mine", "sha256": assets.actors[0].sha256}],
    }
    assert own.draw(1, 2).assets is assets
    assert replace(own.draw(1, 2), assets=None) == policy.draw(1, 2)


def test_scenes_and_environments_take_a_folder_or_what_was_read(tmp_path: Path) -> None:
    folder = assets_folder(tmp_path / "own")
    for assets in (folder, str(folder), Assets.read(folder)):
        assert Environment(assets=assets).policy.assets == Assets.read(folder)
        scene = Scene.empty(assets=assets)
        scene.add("car", x_m=9.0, y_m=1.0, yaw_rad=0.5, model="mine")
        assert [(agent.model, tuple(agent.position_world)) for agent in scene.agents] == [("mine", (9.0, 1.0, 0.0))]
    with pytest.raises(CadetError, match=r"^assets: expected a folder or cadet.Assets, got 3$"):
        Scene.empty(assets=3)  # type: ignore[arg-type]
    with pytest.raises(CadetError, match=r"^ResetPolicy.assets: expected cadet.Assets, got 'x'$"):
        replace(ResetPolicy.kitti(), assets="x")  # type: ignore[arg-type]


def _remove(name: str) -> Callable[[Path], None]:
    return lambda root: (root / name).unlink()


def _write(name: str, text: str) -> Callable[[Path], None]:
    def write(root: Path) -> None:
        (root / name).write_bytes(text.encode("latin-1"))

    return write


def _toml(old: str, new: str) -> Callable[[Path], None]:
    return _write("assets.toml", CAR.replace(old, new))


BAD: list[tuple[Callable[[Path], None], str]] = [
    (_remove("assets.toml"), "'ROOT': no assets.toml in it"),
    (shutil.rmtree, "'ROOT': no assets.toml in it"),
    (_write("assets.toml", "share = \n"), "assets.toml: invalid TOML: Invalid value (at line 1, column 9)"),
    (_write("assets.toml", "name = '\xe4'"), "assets.toml: invalid TOML: 'utf-8' codec can't decode byte"),
    (_write("assets.toml", "share = 0.5\n"), "assets.toml: missing key 'actor'"),
    (_write("assets.toml", "actor = 3\n"), "assets.toml: actor: expected [[actor]] tables, got 3"),
    (_write("assets.toml", "actor = []\n"), "assets: expected at least one actor, got none"),
    (_write("assets.toml", f"shares = 1\n{CAR}"), "assets.toml: unknown key 'shares'; known: actor, share"),
    (_write("assets.toml", f"share = 1.5\n{CAR}"), "assets.share: expected a number from 0 to 1, got 1.5"),
    (_write("assets.toml", CAR + CAR), "assets: two actors are named 'mine'"),
    (
        _write("assets.toml", f"{CAR}color = 'red'\n"),
        "assets.toml: actor 1: unknown key 'color'; known: name",
    ),
    (_toml('name = "mine"\n', ""), "assets.toml: actor 1: missing key 'name'"),
    (_toml('"mine"', '"a b"'), "assets.toml: actor 'a b'.name: expected 1 to 64 letters, digits, '_', '.' or '-'"),
    (_toml('"mine"', "[1]"), "assets.toml: actor [1].name: expected"),
    (
        _toml('"Car"', '"Tank"'),
        "assets.toml: actor 'mine'.class: expected one of Car, Van, Truck, Tram, Misc, Pedestrian, Person_sitting, Cyc",
    ),
    (_toml('"meshes/car.obj"', "7"), "assets.toml: actor 1.mesh: expected the path of an OBJ or glTF file, got 7"),
    (_toml("meshes/car", "c" * 300), f"assets.toml: actor 1: no mesh '{'c' * 300}.obj'"),
    (_toml("meshes/car", "car"), "assets.toml: actor 1: no mesh 'car.obj'"),
    (_toml("meshes/car.obj", "meshes"), "assets.toml: actor 1: no mesh 'meshes', got a folder"),
    (_toml("meshes", "../meshes"), "assets.toml: actor 1.mesh: '../meshes/car.obj' leads out of the folder"),
    (_toml("meshes/car.obj", "/etc/passwd"), "assets.toml: actor 1.mesh: '/etc/passwd' leads out of the folder"),
    (_remove("meshes/car.obj"), "assets.toml: actor 1: no mesh 'meshes/car.obj'"),
    (_write("meshes/car.obj", "\x89PNG\n"), "meshes/car.obj: no faces: is it a Wavefront OBJ file?"),
    (_write("assets.toml", f"{CAR}scale = nan\n"), "assets.toml: actor 'mine'.scale: expected a number from 1e-09"),
    (_write("assets.toml", f"{CAR}up = 'x'\n"), "assets.toml: actor 'mine'.up: expected 'z' or 'y', got 'x'"),
    (_write("assets.toml", f"{CAR}size_lwh = 4\n"), "assets.toml: actor 'mine'.size_lwh: expected [length, width"),
    (_write("assets.toml", f"{CAR}materials = 4\n"), "assets.toml: actor 1.materials: expected a table, got 4"),
    (
        _write("assets.toml", f"{CAR}materials.gold = []\n"),
        "assets.toml: actor 'mine'.materials: unknown key 'gold'; known: glass, tyre, plate, lamp, interior, leave_",
    ),
    (
        _write("assets.toml", f"{CAR}materials.glass = 'x'\n"),
        "assets.toml: actor 'mine'.materials.glass: expected a list of names, got 'x'",
    ),
]


@pytest.mark.parametrize(("spoil", "message"), BAD)
def test_a_bad_folder_is_refused_in_one_line(spoil: Callable[[Path], None], message: str, tmp_path: Path) -> None:
    root = assets_folder(tmp_path / "own")
    spoil(root)
    with pytest.raises(CadetError) as caught:
        Assets.read(root)
    assert str(caught.value).startswith(message.replace("ROOT", str(root)))
    assert "\n" not in str(caught.value)
    is_missing = re.search("no (assets|mesh)", message) is not None
    assert isinstance(caught.value, MissingFileError) == is_missing


def test_a_link_out_of_the_folder_is_refused(tmp_path: Path) -> None:
    root = assets_folder(tmp_path / "own")
    shutil.move(root / "meshes", tmp_path / "meshes")
    (root / "meshes").symlink_to(tmp_path / "meshes")
    with pytest.raises(CadetError, match=r"leads out of the folder$"):
        Assets.read(root)


def test_a_mesh_needs_a_sensible_name_and_type() -> None:
    with pytest.raises(CadetError, match=r"^actor 'a/b'.name: expected 1 to 64 letters"):
        ActorMesh(name="a/b", type="Car", mesh=car_mesh())


def test_a_dataset_records_its_assets_and_goes_on_with_no_others(tmp_path: Path) -> None:
    own, out = assets_folder(tmp_path / "own"), tmp_path / "out"
    arguments = (out, "-n", 2, *SIZE, "--seed", 3, "--workers", 1)
    assert run(*arguments, "--assets", own).returncode == FINE
    recorded = Assets.read(own).to_dict()
    for name in ("run.json", "manifest.json"):
        text = (out / name).read_text()
        assert json.loads(text)["policy"]["assets"] == recorded
        assert str(tmp_path) not in text
    moved = tmp_path / "moved"
    shutil.move(own, moved)
    assert run(*arguments, "--resume", "--assets", moved).returncode == FINE, "where they lie does not matter"
    without = run(*arguments, "--resume")
    assert without.returncode == FAILED
    assert without.stderr.startswith(f"cadet-gen: {out} was begun with other settings: policy.assets was ")
    (moved / "meshes" / "car.mtl").write_text(MTL.replace("0.5", "0.6"))
    changed = run(*arguments, "--resume", "--assets", moved)
    assert changed.returncode == FAILED
    assert "policy.assets.actors was" in changed.stderr


def test_cadet_gen_refuses_bad_assets_before_it_writes(tmp_path: Path) -> None:
    done = run(tmp_path / "out", "-n", 2, "--assets", tmp_path / "none")
    assert (done.returncode, done.stderr) == (
        FAILED,
        f"cadet-gen: --assets: '{tmp_path / 'none'}': no assets.toml in it\n",
    )
    assert not (tmp_path / "out").exists()
