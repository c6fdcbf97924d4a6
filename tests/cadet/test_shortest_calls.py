"""Every public class, function, and method of `cadet` in its shortest form, and what their objects' `repr` names."""

from __future__ import annotations

import inspect
import pickle
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import generate, kitti
from cadet._util.toml_file import TomlFile
from evaluation_helpers import detected
from foreign_results import openpcdet_frames, write_tables
from mesh_files.obj_meshes import assets_folder
from synthetic import make_frame

NAMESPACES = (cadet, kitti, generate)
BOXES = np.array([[0.0, 1.7, 10.0, 4.0, 1.6, 1.5, 0.1], [9.0, 1.7, 12.0, 4.0, 1.6, 1.5, 0.2]])
POINTS = np.array([[0.0, 1.0, 10.0], [2.0, 1.0, 20.0]])


class World:
    """A folder of inputs, and one object of each kind to call methods of."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.frame = make_frame(has_maps=True)
        kitti.write_frame(root, 0, self.frame)
        assets_folder(root)
        (root / "town.xodr").write_text("<OpenDRIVE/>")
        (root / "aims.csv").write_text("time_s,azimuth_deg,elevation_deg\n0,1,2\n")
        (root / "result.pkl").write_bytes(pickle.dumps(openpcdet_frames()))
        (root / "tables").mkdir()
        write_tables(root / "tables")
        (root / "props").mkdir()
        (root / "props" / "bin.toml").write_text(
            'levels_m = [20, 40, 90]\nparts = [{ of = "steel", block = "1, 1, 1" }]\n'
            'place = [{ where = "yard", weight = 1 }]\n'
        )
        self.labels = [label for label in self.frame.labels if not label.is_dont_care]
        self.truth = cadet.GroundTruth.from_labels(self.labels)
        self.found = cadet.Detections.from_labels([detected(label, 0.5) for label in self.labels])
        self.rig = cadet.Rig(camera=cadet.Camera.kitti().resized(124, 38), lidar=cadet.Lidar.vlp16())
        self.scene = cadet.Scene.empty(rig=self.rig)
        self.scene.add("car", x_m=12.0, y_m=0.0, yaw_rad=0.0)
        sample = self.scene.capture().sample
        assert sample is not None
        self.sample = sample
        self.environment = cadet.Environment(rig=self.rig)
        self.environment.reset()
        self.policy = cadet.ResetPolicy.kitti()
        self.settings = generate.Settings(policy=self.policy, num_frames=1, rig=self.rig)

    def generated(self) -> Path:
        """Return a dataset's folder."""
        if not (self.root / "made").exists():
            generate.generate(self.root / "made", self.settings, workers=1)
        return self.root / "made"


# What is needed to make an object, or to call a function or method; all else is called without arguments.
OBJECTS: dict[str, Callable[[World], Any]] = {
    "Agent": lambda w: w.scene.agents[0],
    "Analysis": lambda w: cadet.analyze([w.truth], [w.found]),
    "Assets": lambda w: cadet.Assets.read(w.root),
    "BeamTable": lambda w: cadet.BeamTable(
        name="x", rings=(cadet.Laser(elevation_deg=0.0),), firing=cadet.UniformFiring(columns=9)
    ),
    "Calibration": lambda w: w.frame.calib,
    "Comparison": lambda w: cadet.analyze([w.truth] * 3, [w.found] * 3, [w.found] * 3, bootstrap=2).comparison,
    "Dataset": lambda w: kitti.Dataset(w.root),
    "Detections": lambda w: w.found,
    "District": lambda w: cadet.District.named("parked_rows"),
    "Draws": lambda w: cadet.Draws(0, 0, 0, "name"),
    "EpisodeSpec": lambda w: w.policy.draw(0, 0),
    "EncoderFiring": lambda w: cadet.EncoderFiring(ticks_per_turn=4000, ticks_per_firing=2.0, firings=100),
    "Environment": lambda w: w.environment,
    "EvalClass": lambda w: cadet.EvalClass("Car", ("Car",), (0.5, 0.5, 0.5)),
    "Finding": lambda w: kitti.Finding("label_2/000000.txt", None, "rule", "message"),
    "Frame": lambda w: w.frame,
    "FrameStream": lambda w: cadet.stream(rig=w.rig, workers=0),
    "GroundTruth": lambda w: w.truth,
    "ImageSet": lambda w: kitti.ImageSet(("000000",)),
    "KittiFormatError": lambda w: cadet.KittiFormatError("no number"),
    "Label": lambda w: w.labels[0],
    "Laser": lambda w: cadet.Laser(elevation_deg=0.0),
    "Level": lambda w: cadet.Level("Easy", 40.0),
    "ListedFiring": lambda w: cadet.ListedFiring(azimuths_deg=(0.0, 1.0)),
    "RasterFiring": lambda w: cadet.RasterFiring(
        lines=2, columns=3, azimuth_span_deg=(9, 0), elevation_span_deg=(1, 0)
    ),
    "RosetteFiring": lambda w: cadet.RosetteFiring(firings=9, deflections_deg=(9, 9), prism_rates_hz=(100, -70)),
    "TableFiring": lambda w: cadet.TableFiring(aims=((0, 0, 0),)),
    "MountedCamera": lambda w: cadet.MountedCamera(
        name="a", camera=cadet.Camera.from_fov(99, 99, horizontal_deg=53.0), pose=cadet.Pose()
    ),
    "MountedLidar": lambda w: cadet.MountedLidar(name="b", lidar=cadet.Lidar(), pose=cadet.Pose()),
    "RayHits": lambda w: w.scene.cast_rays([[0.0, 0.0, 9.0]], [[0.0, 0.0, -1.0]]),
    "Recipe": lambda w: generate.Recipe(w.settings),
    "Report": lambda w: cadet.evaluate([w.truth], [w.found]),
    "ResetPolicy": lambda w: w.policy,
    "RoadMap": lambda w: cadet.RoadMap("town", "<OpenDRIVE/>"),
    "Camera": lambda w: cadet.Camera.kitti(),
    "FrameObject": lambda w: w.frame.objects[0],
    "Sample": lambda w: w.sample,
    "Scan": lambda w: w.scene.scan(),
    "ScanSurfaces": lambda w: w.scene.scan(surfaces=True).surfaces,
    "Scene": lambda w: w.scene,
    "Semantic": lambda w: cadet.Semantic.CAR,
    "Settings": lambda w: w.settings,
    "Simulation": lambda w: cadet.Simulation(w.policy),
    "Summary": lambda w: generate.generate(w.generated(), w.settings, workers=1, resume=True),
    "Rules": lambda w: cadet.Rules(classes=(cadet.EvalClass("Car", ("Car",), (0.5, 0.5, 0.5)),)),
    "UniformFiring": lambda w: cadet.UniformFiring(columns=9),
    "Props": lambda w: cadet.Props.read(w.root / "props"),
    "ActorMesh": lambda w: cadet.Assets.read(w.root).actors[0],
}
CALLS: dict[str, Callable[[World], Any]] = {
    "Draws.between": lambda w: cadet.Draws(0, 0, 0, "name").between(1.0, 2.0),
    "Draws.count": lambda w: cadet.Draws(0, 0, 0, "name").count(1, 2),
    "Draws.weighted": lambda w: cadet.Draws(0, 0, 0, "name").weighted([("a", 1.0)]),
    "Calibration.from_pinhole": lambda w: cadet.Calibration.from_pinhole(w.frame.calib.P2[:, :3], np.eye(4)),
    "ResetPolicy.with_each_district": lambda w: w.policy.with_each_district(lambda district: district),
    "read_detections": lambda w: cadet.read_detections(w.root / "result.pkl"),
    "read_ground_truth": lambda w: cadet.read_ground_truth(w.root / "tables"),
    "view": lambda w: cadet.view(w.frame, w.root / "frame.png"),
    "Assets.read": lambda w: cadet.Assets.read(w.root),
    "Props.read": lambda w: cadet.Props.read(w.root / "props"),
    "Calibration.from_text": lambda w: cadet.Calibration.from_text(w.frame.calib.to_text()),
    "Calibration.points_cam_from_velo": lambda w: w.frame.calib.points_cam_from_velo(w.frame.points_velo[:, :3]),
    "Calibration.points_velo_from_cam": lambda w: w.frame.calib.points_velo_from_cam(POINTS),
    "Calibration.project": lambda w: w.frame.calib.project(POINTS),
    "Camera.projection": lambda w: cadet.Camera.kitti().projection((0.0, 0.0, 0.0)),
    "Camera.resized": lambda w: cadet.Camera.kitti().resized(124, 38),
    "Camera.from_fov": lambda w: cadet.Camera.from_fov(99, 99, horizontal_deg=53.0),
    "Camera.fisheye": lambda w: cadet.Camera.fisheye(99, 99),
    "Detections.from_labels": lambda w: cadet.Detections.from_labels(()),
    "District.named": lambda w: cadet.District.named("parked_rows"),
    "GroundTruth.from_labels": lambda w: cadet.GroundTruth.from_labels(()),
    "ImageSet.from_text": lambda w: kitti.ImageSet.from_text("000000\n"),
    "Label.from_line": lambda w: cadet.Label.from_line(w.labels[0].to_line()),
    "Label.in_image": lambda w: cadet.Label.in_image("DontCare", (1.0, 2.0, 3.0, 4.0)),
    "LabelConfig.scaled": lambda w: cadet.LabelConfig().scaled((0.5, 0.5)),
    "LabelConfig.over": lambda w: cadet.LabelConfig().over(cadet.LabelConfig()),
    "Lidar.custom": lambda w: cadet.Lidar.custom(cadet.Lidar.vlp16().beam_table()),
    "Lidar.named": lambda w: cadet.Lidar.named("vlp16"),
    "Pose.carried_by": lambda w: cadet.Pose().carried_by(np.eye(4)),
    "Pose.from_matrix": lambda w: cadet.Pose.from_matrix(np.eye(4)),
    "Pose.of_angles": lambda w: cadet.Pose.of_angles((0.0, 0.0, 0.0)),
    "Pose.of_camera": lambda w: cadet.Pose.of_camera((0.0, 0.0, 0.0)),
    "PropConfig.over": lambda w: cadet.PropConfig().over(cadet.PropConfig()),
    "Report.plot": lambda w: cadet.evaluate([w.truth], [w.found]).plot(w.root / "curves.png"),
    "ResetPolicy.as_sequence": lambda w: w.policy.as_sequence(hz=2, length_s=1),
    "ResetPolicy.draw": lambda w: w.policy.draw(0, 0),
    "ResetPolicy.named": lambda w: cadet.ResetPolicy.named("paper"),
    "ResetPolicy.with_districts": lambda w: w.policy.with_districts(cadet.District.named("parked_rows")),
    "ResetPolicy.with_each_rig": lambda w: w.policy.with_each_rig(lambda rig: rig),
    "ResetPolicy.with_props": lambda w: w.policy.with_props(cadet.Props.read(w.root / "props")),
    "ResetPolicy.with_rig": lambda w: w.policy.with_rig(w.rig),
    "ResetPolicy.with_weathers": lambda w: w.policy.with_weathers("snow"),
    "Weather.preset": lambda w: cadet.Weather.preset("snow"),
    "Rig.ego_from_sensor": lambda w: w.rig.ego_from_sensor("image_2"),
    "Rig.named": lambda w: cadet.Rig.named("kitti"),
    "Rig.pitched": lambda w: w.rig.pitched(0.5),
    "Rig.sensor": lambda w: w.rig.sensor("image_2"),
    "Rig.wanted": lambda w: w.rig.wanted(None),
    "Rig.with_each_lidar": lambda w: w.rig.with_each_lidar(lambda lidar: lidar),
    "Rig.with_image_size": lambda w: w.rig.with_image_size(62, 19),
    "Rig.with_lidar": lambda w: w.rig.with_lidar(cadet.Lidar()),
    "TableFiring.read": lambda w: cadet.TableFiring.read(w.root / "aims.csv"),
    "RoadMap.read": lambda w: cadet.RoadMap.read(w.root / "town.xodr"),
    "Scene.add": lambda w: w.scene.add("van", x_m=20.0, y_m=5.0, yaw_rad=0.0),
    "Scene.cast_rays": lambda w: w.scene.cast_rays([], []),
    "Scene.command_ego": lambda w: w.scene.command_ego(speed_mps=None),
    "Scene.move_ego": lambda w: w.scene.move_ego(x_m=-20.0, y_m=0.0, yaw_rad=0.0),
    "Scene.step": lambda w: w.scene.step(0.1),
    "SceneConfig.over": lambda w: cadet.SceneConfig().over(cadet.SceneConfig()),
    "SceneConfig.scaled": lambda w: cadet.SceneConfig().scaled((0.5, 0.5)),
    "Settings.num_samples": lambda w: w.settings.num_samples(0),
    "Settings.open": lambda w: w.settings.open(w.root / "new"),
    "Settings.place": lambda w: w.settings.place(0),
    "Settings.places_of": lambda w: w.settings.places_of(0),
    "Settings.split": lambda w: w.settings.split(0),
    "SuburbConfig.over": lambda w: cadet.SuburbConfig().over(cadet.SuburbConfig()),
    "Dataset.has": lambda w: kitti.Dataset(w.root).has("calib", "000000"),
    "Dataset.read_frame": lambda w: kitti.Dataset(w.root).read_frame("000000"),
    "Dataset.read_labels": lambda w: kitti.Dataset(w.root).read_labels("000000"),
    "analyze": lambda w: cadet.analyze([w.truth], [w.found]),
    "boxes_cam_from_labels": lambda w: kitti.boxes_cam_from_labels(w.labels),
    "box_iou_3d": lambda w: cadet.box_iou_3d(BOXES, BOXES),
    "box_iou_bev": lambda w: cadet.box_iou_bev(BOXES, BOXES),
    "compare": lambda w: generate.compare(w.generated(), generate.Recipe(w.settings)),
    "encode_frame": lambda w: kitti.encode_frame(w.frame),
    "encode_meta": lambda w: kitti.encode_meta({}),
    "estimate_plane": lambda w: kitti.estimate_plane(w.frame.points_velo, w.frame.calib),
    "evaluate": lambda w: cadet.evaluate([w.truth], [w.found]),
    "frame_from_sample": lambda w: kitti.frame_from_sample(w.sample),
    "generate": lambda w: generate.generate(w.root / "out", w.settings),
    "generate_frame": lambda w: generate.generate_frame(w.root / "alone", w.settings, 0),
    "labels_from_text": lambda w: kitti.labels_from_text(""),
    "lint": lambda w: kitti.lint(w.root),
    "lint_frame": lambda w: kitti.lint_frame(w.root, 0, strict=True),
    "nms_bev": lambda w: cadet.nms_bev(BOXES, np.array([0.1, 0.2]), 0.5),
    "points_in_image": lambda w: kitti.points_in_image(POINTS, w.frame.calib, w.frame.image_size),
    "read_calib": lambda w: kitti.read_calib(w.root / "training", "000000"),
    "read_frame": lambda w: kitti.read_frame(w.root, 0),
    "read_image_set": lambda w: kitti.read_image_set(w.root, "trainval"),
    "read_labels": lambda w: kitti.read_labels(w.root, 0),
    "read_meta": lambda w: kitti.read_meta(w.root, 0),
    "text_from_labels": lambda w: kitti.text_from_labels(()),
    "write_frame": lambda w: kitti.write_frame(w.root, 7, w.frame),
    "write_image_set": lambda w: kitti.write_image_set(w.root, "test", kitti.ImageSet(())),
}


def public() -> Iterator[tuple[str, Any]]:
    """Yield each public function and class by name."""
    seen = set()
    for namespace in NAMESPACES:
        names = getattr(namespace, "__all__", [name for name in vars(namespace) if not name.startswith("_")])
        for name in names:
            one = getattr(namespace, name)
            if callable(one) and one.__module__.startswith("cadet") and one not in seen:
                seen.add(one)
                yield name, one


def methods(cls: type[Any]) -> Iterator[str]:
    """Yield the public methods that a class has of ours."""
    for base in cls.__mro__:
        for name, one in vars(base).items() if base.__module__.startswith("cadet") else ():
            is_method = inspect.isroutine(one) or isinstance(one, (classmethod, staticmethod))
            if is_method and callable(getattr(cls, name)) and not name.startswith("_"):
                yield name


CLASSES = {name: one for name, one in public() if inspect.isclass(one)}
FUNCTIONS = [name for name, one in public() if not inspect.isclass(one)]
METHODS = sorted({f"{name}.{method}" for name, cls in CLASSES.items() for method in methods(cls)})


def _toml_file(name: str) -> type[TomlFile]:
    cls = CLASSES[name]
    assert issubclass(cls, TomlFile)
    return cls


def _from_toml(name: str) -> Callable[[World], Any]:
    return lambda w: _toml_file(name).from_toml(made(w, name).to_toml())


def _read(name: str) -> Callable[[World], Any]:
    def read(w: World) -> Any:
        (w.root / f"{name}.toml").write_text(made(w, name).to_toml())
        return _toml_file(name).read(w.root / f"{name}.toml")

    return read


for _name in [name for name, cls in CLASSES.items() if issubclass(cls, TomlFile)]:
    CALLS |= {f"{_name}.from_toml": _from_toml(_name), f"{_name}.read": _read(_name)}


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("shortest"))


def made(world: World, name: str) -> Any:
    """Make an object of a class; what takes no argument, or a message, is not in the table."""
    cls = CLASSES[name]
    if name in OBJECTS:
        return OBJECTS[name](world)
    return cls("a.txt: wrong") if issubclass(cls, BaseException) else cls()


@pytest.mark.parametrize("name", CLASSES)
def test_each_class_has_an_object_whose_repr_names_its_attributes(name: str, world: World) -> None:
    check_repr(made(world, name))


@pytest.mark.parametrize("name", [*FUNCTIONS, *METHODS])
def test_each_function_and_method_has_a_shortest_form(name: str, world: World) -> None:
    owner, _, method = name.rpartition(".")
    if name in CALLS:
        result = CALLS[name](world)
    elif owner:
        result = getattr(made(world, owner), method)()
    else:
        result = getattr(next(space for space in NAMESPACES if hasattr(space, name)), name)()
    check_repr(result)


def test_no_table_holds_what_is_gone() -> None:
    assert set(OBJECTS) <= set(CLASSES) and set(CALLS) <= {*FUNCTIONS, *METHODS}


def check_repr(one: object) -> None:
    if type(one).__module__.startswith("cadet"):
        for name in named_in(repr(one)):
            assert hasattr(one, name), f"{type(one).__name__}'s repr names {name}, which it has not: {one!r}"


def named_in(text: str) -> Iterator[str]:
    """Yield the names before `=` that stand in the outermost parentheses."""
    depth, quote, word = 0, "", ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in "([{":
            depth += 1
        elif letter in ")]}":
            depth -= 1
        elif letter == "=" and depth == 1:
            yield word
        word = word + letter if letter.isidentifier() or letter.isdigit() else ""
