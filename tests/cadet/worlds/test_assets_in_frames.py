"""A user's meshes in generated frames: labeled, seen by both sensors, inside their boxes, the same for any workers."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from unittest.mock import ANY

import numpy as np
import pytest

import cadet
from cadet.cli import run_cadet_gen
from cadet.formats.kitti.boxes import points_in_boxes
from cadet.formats.kitti.lint import lint
from mesh_files.obj_meshes import CAR, Block, assets_folder, obj_of
from scans.sensed import sense

MESHES = Path(__file__).resolve().parents[4] / "shared" / "meshes"
needs_meshes = pytest.mark.skipif(not MESHES.is_dir(), reason="needs the vehicle meshes in ../shared/meshes")

# Folder, OBJ file, type, where the front looks where the model's own file does not turn the mesh: all along -y.
REAL = (
    ("prius_hybrid", "Hybrid.obj", "Car", 90.0),
    ("hatchback", "hatchback.obj", "Car", None),
    ("suv", "suv.obj", "Car", None),
    ("bus", "bus.obj", "Truck", 90.0),
)


def real_assets(root: Path) -> Path:
    """Write an `assets.toml` for the four meshes: scale and turn as their model.sdf says."""
    root.mkdir()
    lines = ["share = 0.8"]
    for name, mesh, kind, yaw_deg in REAL:
        (root / name).mkdir()
        for path in [*MESHES.joinpath(name).glob("*.obj"), *MESHES.joinpath(name).glob("*.mtl")]:
            (root / name / path.name).write_bytes(path.read_bytes())
        sdf = (MESHES / name / "model.sdf").read_text()
        scale = re.search(r"<scale>(\S+) ", sdf)
        assert scale is not None
        if yaw_deg is None:
            pose = re.search(r"<visual.*?<pose>0 0 0 0 0 (\S+)</pose>", sdf, re.DOTALL)
            assert pose is not None
            yaw_deg = np.degrees(float(pose[1]))
        lines += ["[[actor]]", f'name = "{name}"', f'class = "{kind}"', f'mesh = "{name}/{mesh}"']
        lines += [f"scale = {scale[1]}", f"yaw_deg = {yaw_deg:.6f}"]
    (root / "assets.toml").write_text("\n".join(lines))
    return root


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> cadet.Assets:
    with warnings.catch_warnings():
        # Three of them name no panes.
        warnings.simplefilter("ignore", cadet.CadetWarning)
        return cadet.Assets.read(real_assets(tmp_path_factory.mktemp("real") / "own"))


def gen(*arguments: object) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["cadet-gen", *map(str, arguments)])
        with pytest.raises(SystemExit) as done:
            run_cadet_gen()
    assert done.value.code == 0


def tree(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def share_inside(frame: cadet.Frame, scan: cadet.Scan, names: Sequence[str]) -> tuple[int, int, set[str]]:
    """Count a frame's points on labeled actors of some models: those in their boxes, all, and the models met."""
    assert frame.meta is not None
    cam_from_velo = frame.calib.cam_from_velo
    points_cam = scan.points_velo[:, :3].astype(float) @ cam_from_velo[:3, :3].T + cam_from_velo[:3, 3]
    inside = total = 0
    met = set()
    for label, meta in zip(frame.labels, frame.meta["objects"], strict=True):
        if meta["model"] in names and label.type != "DontCare":
            own = points_cam[scan.actor_id == meta["actor_id"]]
            h, w, l = label.dimensions_hwl
            box = np.array([[*label.location_cam, l, w, h, label.rotation_y]])
            # Lasers measure up to 6 cm too short or too long, and with 2 cm of noise.
            inside, total = inside + int(points_in_boxes(own, box, 0.1).sum()), total + len(own)
            met.add(meta["model"])
    return inside, total, met


def test_every_actor_of_a_mesh_is_annotated_apart(tmp_path: Path) -> None:
    own = assets_folder(tmp_path / "own", f"share = 1.0\n{CAR}")
    scene = cadet.Scene.random(seed=2, weather="clear_noon", assets=own)
    boxes: dict[int, tuple[float, ...]] = {}
    for _ in range(3):
        frame = scene.capture()
        assert frame.meta is not None and frame.meta["boxes"] == "kitti"
        for o in frame.meta["objects"]:
            if o["model"] == "mine":
                box = tuple(o["dimensions_hwl"])
                assert boxes.setdefault(o["actor_id"], box) == box, "the box of an actor stays"
        scene.step(1.0)
    assert len(set(boxes.values())) == len(boxes) > 5
    lengths = np.array([length for _, _, length in boxes.values()])
    # Each end bulges by 5.5 cm in the mean, and by 7 cm more or less.
    assert 3.6 < lengths.min() < lengths.max() < 4.25
    assert lengths.std() > 0.03


def test_a_mesh_drives_parks_and_is_labeled(tmp_path: Path) -> None:
    own = assets_folder(tmp_path / "own", f"share = 1.0\n{CAR}")
    policy = replace(cadet.ResetPolicy.kitti(), label=cadet.LabelConfig(boxes="exact"))
    scene = cadet.Scene.random(seed=2, weather="clear_noon", policy=policy, assets=own)
    inside = total = 0
    for _ in range(6):
        sensed = sense(scene)
        assert sensed.frame.meta is not None
        objects = sensed.frame.meta["objects"]
        assert {o["model"] for o in objects if o["type"] in ("Car", "Van", "Truck")} <= {"mine"}
        for o in objects:
            if o["model"] == "mine":
                assert o["dimensions_hwl"] == [1.4, 1.7, 4.0]
        one_inside, one_total, _ = share_inside(sensed.frame, sensed.scan, ["mine"])
        inside, total = inside + one_inside, total + one_total
        scene.step(2.0)
    assert total > 500
    assert inside >= 0.98 * total


@pytest.mark.parametrize(
    ("materials", "is_clear"), [("", True), ("materials.interior = ['Glass']\nmaterials.glass = []", False)]
)
def test_panes_let_both_sensors_through(materials: str, is_clear: bool, tmp_path: Path) -> None:
    own = assets_folder(tmp_path / "own", CAR + materials)
    images = []
    for with_person in (False, True):
        scene = cadet.Scene.empty(weather="clear_noon", assets=own)
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        # Across the view: the cabin is all panes, and somebody stands behind it.
        car = scene.add("car", x_m=8.0, y_m=0.0, yaw_rad=np.pi / 2, model="mine")
        person = scene.add("pedestrian", x_m=11.0, y_m=-0.3, yaw_rad=0.0, model_seed=3) if with_person else 0
        sensed = sense(scene)
        images.append(sensed.frame.image.astype(int))
    ids = sensed.scan.actor_id
    assert (ids == car).sum() > 300
    height_m = sensed.scan.points_velo[ids == person, 2] + 1.73
    num_behind = int(((height_m > 0.85) & (height_m < 1.35)).sum())
    assert (num_behind > 5) == is_clear, "returns from behind the panes"
    assert sensed.frame.semantic is not None
    changed = np.abs(images[1] - images[0]).max(axis=2) > 25
    num_changed = int(((sensed.frame.semantic == cadet.Semantic.CAR) & changed).sum())
    assert (num_changed > 100) == is_clear, "the person shows through the panes"


def test_a_mesh_may_be_of_any_class_of_vehicles(tmp_path: Path) -> None:
    semantic = {"Van": "VAN", "Truck": "TRUCK", "Tram": "TRAM", "Misc": "OTHER_VEHICLE"}
    text = "".join(CAR.replace("mine", kind).replace('"Car"', f'"{kind}"') for kind in semantic)
    scene = cadet.Scene.empty(assets=assets_folder(tmp_path / "own", text))
    ids = {kind: scene.add(kind, model=kind, x_m=14.0, y_m=5.0 - 3.5 * k) for k, kind in enumerate(semantic)}
    frame = scene.capture()
    assert frame.instance is not None and frame.semantic is not None
    for seen in frame.objects:
        assert (seen.model, seen.id) == (seen.type, ids[seen.type])
        values = frame.semantic[frame.instance == seen.id]
        assert (values == cadet.Semantic[semantic[seen.type]]).all()
    assert {label.type for label in frame.labels} == set(semantic)


def test_models_are_asked_for_by_name_and_class(tmp_path: Path) -> None:
    own = assets_folder(tmp_path / "own")
    scene = cadet.Scene.empty(assets=own)
    for kind, model, message in [
        ("van", "mine", "scene: model 'mine' is a Car, not a Van"),
        ("car", "other", 'unknown model "other"; known: mine'),
        ("pedestrian", "mine", "is a Car, not a Pedestrian"),
    ]:
        with pytest.raises(cadet.CadetError, match=re.escape(message).replace("'mine'", ".mine.")):
            scene.add(kind, x_m=9.0, y_m=0.0, yaw_rad=0.0, model=model)
    with pytest.raises(cadet.CadetError, match=r'unknown model "mine"; known: none, the scene has no assets'):
        cadet.Scene.empty().add("car", x_m=9.0, y_m=0.0, yaw_rad=0.0, model="mine")


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        (f"{CAR}scale = 100", "meshes/car.obj: 400.000 m long, expected 1 to 30 m for a Car: check scale"),
        (f"{CAR}yaw_deg = 90", "meshes/car.obj: wider (4.00 m) than long (1.70 m): turn its front to +x with yaw_deg"),
        (f"{CAR}materials.glass = ['Pane*']", 'meshes/car.obj: materials.glass: no material is named "Pane*"; known: '),
    ],
)
def test_a_mesh_that_makes_no_vehicle_is_refused_when_read(toml: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(cadet.CadetError) as caught:
        cadet.Assets.read(assets_folder(tmp_path / "own", toml))
    assert str(caught.value).startswith(message)


@needs_meshes
def test_real_meshes_have_the_size_of_vehicles(real: cadet.Assets) -> None:
    sizes = {name: size for name, _, size in real._to_native().models()}
    # A Prius of 2009 is 4.46 m long without bumpers' trim, a coach 12 m; mirrors count.
    for name, (low, high) in {"prius_hybrid": (4.4, 4.7), "hatchback": (3.7, 4.2), "suv": (4.5, 5.2)}.items():
        assert low < sizes[name][0] < high
    assert 12.0 < sizes["bus"][0] < 13.0


@needs_meshes
@pytest.mark.parametrize("number", range(4))
def test_a_real_mesh_looks_ahead_and_stands_on_its_wheels(real: cadet.Assets, number: int) -> None:
    name, _, kind, _ = REAL[number]
    scene = cadet.Scene.empty(weather="clear_noon", assets=real)
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    actor = scene.add(kind, x_m=18.0, y_m=0.0, yaw_rad=0.0, model=name)
    vertices, faces, actor_ids = scene.triangles()
    own = vertices[np.unique(faces[actor_ids == actor])] - [18.0, 0.0, 0.0]
    length_m = np.ptp(own[:, 0])
    assert abs(own[:, 2].min()) < 0.03
    assert np.allclose([own[:, 0].min(), own[:, 1].min()], -np.ptp(own, axis=0)[:2] / 2, atol=0.02)
    # Tires touch the ground in all four corners.
    feet = own[own[:, 2] < 0.06]
    corners = {(x > 0, y > 0) for x, y, _ in feet}
    assert len(corners) == 4
    assert np.abs(feet[:, 0]).min() > 0.12 * length_m
    # All four have their mirrors, the widest part of them, ahead of the middle.
    widest = own[np.abs(own[:, 1]) > 0.97 * np.abs(own[:, 1]).max()]
    assert (widest[:, 0] > 0).all()


@needs_meshes
def test_a_dataset_with_real_meshes_is_clean_and_the_same_for_any_workers(tmp_path: Path) -> None:
    own = real_assets(tmp_path / "own")
    arguments = ("-n", 3, "--seed", 6, "--weathers", "clear_noon", "--assets", own)
    gen(tmp_path / "one", *arguments, "--workers", 1)
    gen(tmp_path / "two", *arguments, "--workers", 2)
    assert tree(tmp_path / "one") == tree(tmp_path / "two")
    assert [f for f in lint(tmp_path / "one") if f.severity == "error"] == []
    policy = json.loads((tmp_path / "one" / "manifest.json").read_text())["policy"]
    assert [actor["name"] for actor in policy["assets"]["actors"]] == [name for name, *_ in REAL]
    metas = [json.loads(path.read_text()) for path in (tmp_path / "one" / "training" / "meta").iterdir()]
    models = [o["model"] for meta in metas for o in meta["objects"]]
    assert len([model for model in models if model in {name for name, *_ in REAL}]) >= 3


@needs_meshes
def test_boxes_of_real_meshes_contain_their_points(real: cadet.Assets) -> None:
    names = [name for name, *_ in REAL]
    inside = total = 0
    met: set[str] = set()
    policy = replace(cadet.ResetPolicy.kitti(), label=cadet.LabelConfig(boxes="exact"))
    for seed in range(8):
        scene = cadet.Scene.random(seed=seed, weather="clear_noon", policy=policy, assets=real)
        for _ in range(2):
            sensed = sense(scene)
            one_inside, one_total, one_met = share_inside(sensed.frame, sensed.scan, names)
            inside, total, met = inside + one_inside, total + one_total, met | one_met
            scene.step(3.0)
    assert len(met) >= 3, met
    assert total > 1500
    assert inside >= 0.98 * total


def test_beams_and_the_camera_look_through_panes_that_are_assumed(tmp_path: Path) -> None:
    blocks: list[Block] = [("Body", (-2.0, -0.85, 0.2), (2.0, 0.85, 0.9)), ("Body", (-1.6, -0.8, 0.9), (0.9, 0.8, 1.5))]
    deep, inner = {}, {}
    for name, glass in (("closed", "materials.glass = []\n"), ("open", "")):
        own = assets_folder(tmp_path / name, CAR + glass)
        (own / "meshes" / "car.obj").write_text(obj_of(blocks))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            scene = cadet.Scene.empty(assets=own)
        said = [str(warning.message) for warning in caught]
        assert [text.split(": ")[:2] for text in said] == ([["meshes/car.obj", ANY]] if name == "open" else [])
        car = scene.add("car", x_m=10.0, y_m=0.0, yaw_rad=1.5, model="mine")
        lidar = cadet.Lidar.hdl64e_kitti()
        scan, ideal = scene.scan(lidar), scene.scan(lidar, ideal=True)
        columns = lidar.beam_table().num_columns
        range_m = np.full(len(ideal.range_m), np.nan)
        range_m[scan.ring * columns + scan.column] = scan.range_m
        deep[name] = int((range_m - ideal.range_m > 0.15)[ideal.actor_id == car].sum())
        inner[name] = scene.capture().image.astype(float)
    assert deep["closed"] == 0 and deep["open"] > 30, deep
    changed = np.abs(inner["open"] - inner["closed"]).max(axis=2) > 15
    assert changed.sum() > 500, "panes show what is behind them"
