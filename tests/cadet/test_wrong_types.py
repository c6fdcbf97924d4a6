"""What is of the wrong type is refused by name: a CadetError in one line, whatever it is and wherever it is given."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import CadetError, kitti
from cadet.formats.kitti import boxes
from cadet.formats.kitti.drawing.bev import bev_figure
from cadet.formats.kitti.files import images
from cadet.formats.kitti.files.planes import plane_from_text
from cadet.generate import Settings
from cadet.worlds import weather
from mesh_files.obj_meshes import car_mesh
from synthetic import make_frame

ODD: list[Any] = [
    None,
    True,
    -1,
    2,
    10**30,
    10**400,
    10**5000,
    0.5,
    float("nan"),
    -float("inf"),
    "",
    "1",
    "\0",
    "\ud800",
    "x" * 10_000,
    b"1",
    [],
    {},
    (),
    (1, 2),
    (2, 1),
    (None, None),
    (1, "a"),
    ("a", "b"),
    [1, 2, 3],
    ((1, 2),),
    ("Car", 1.0),
    (("clear_noon", "x"),),
    (("clear_noon",),),
    object(),
    1 + 2j,
    Decimal("1.5"),
    Fraction(1, 3),
    np.float32(1.5),
    np.int64(5),
    np.array(1.0),
    np.array([1.0, 2.0]),
    print,
    int,
]

TINY = cadet.Rig(camera=cadet.Camera.kitti().resized(124, 38), lidar=cadet.Lidar.vlp16())
KITTI = cadet.Camera.kitti()
LASER = cadet.Laser(elevation_deg=0.0)
FIRING = cadet.UniformFiring(columns=10)
DISTRICT = {"name": "x", "parking_occupancy": (0.1, 0.2), "num_cars": (1, 2), "num_pedestrians": (1, 2)}
LABEL = {
    "type": "Car",
    "truncated": 0.0,
    "occluded": 0,
    "alpha": 0.0,
    "bbox": (1.0, 2.0, 3.0, 4.0),
    "dimensions_hwl": (1.0, 2.0, 3.0),
    "location_cam": (1.0, 2.0, 3.0),
    "rotation_y": 0.0,
}
BOXES = np.array([[0.0, 1.7, 10.0, 4.0, 1.6, 1.5, 0.1], [9.0, 1.7, 12.0, 4.0, 1.6, 1.5, 0.2]])


@functools.cache
def frame() -> cadet.Frame:
    return make_frame()


@functools.cache
def truth() -> cadet.GroundTruth:
    return cadet.GroundTruth.from_labels([label for label in frame().labels if not label.is_dont_care])


def results() -> cadet.Detections:
    labels = [dataclasses.replace(label, score=0.5) for label in frame().labels if not label.is_dont_care]
    return cadet.Detections.from_labels(labels)


def fields(cls: type[Any]) -> list[str]:
    return [field.name for field in dataclasses.fields(cls)]


def what_is_wrong(use: Callable[[], Any]) -> str | None:
    """Return what a call raises that is no CadetError of one short line."""
    try:
        use()
    except CadetError as error:
        text = str(error)
        return None if "\n" not in text and len(text) < 500 else f"a long message: {text[:300]!r}"
    except Exception as error:  # noqa: BLE001 - the very thing that is looked for
        # No file can have a name of 10,000 letters: the operating system's own errors stay what they are.
        return None if isinstance(error, OSError) else repr(error)[:300]
    return None


CALLS: dict[str, tuple[Callable[..., Any], list[str]]] = {
    "Camera": (
        lambda **k: cadet.Rig(camera=dataclasses.replace(KITTI, **k))._to_native(),
        fields(cadet.Camera),
    ),
    "Camera.resized": (
        lambda **k: KITTI.resized(**{"width": 100, "height": 50, **k}),
        ["width", "height"],
    ),
    "Extrinsics": (cadet.Extrinsics, fields(cadet.Extrinsics)),
    "Extrinsics.aligned": (cadet.Extrinsics.aligned, ["cam0_in_velo_m"]),
    "Rig": (lambda **k: cadet.Rig(**k).to_dict(), fields(cadet.Rig)),
    "Rig.kitti": (cadet.Rig.kitti, ["calibration"]),
    "Rig.named": (cadet.Rig.named, ["name_or_file"]),
    "Lidar": (lambda **k: cadet.Lidar(**k)._to_native(), fields(cadet.Lidar)),
    "Lidar.custom": (cadet.Lidar.custom, ["table"]),
    "Lidar.named": (cadet.Lidar.named, ["name_or_file"]),
    "Laser": (lambda **k: cadet.Laser(**{"elevation_deg": 0.0, **k}), fields(cadet.Laser)),
    "UniformFiring": (cadet.UniformFiring, ["columns"]),
    "ListedFiring": (cadet.ListedFiring, ["azimuths_deg"]),
    "RasterFiring": (
        lambda **k: cadet.RasterFiring(
            **{"lines": 2, "columns": 2, "azimuth_span_deg": (1.0, 2.0), "elevation_span_deg": (1.0, 2.0), **k}
        ),
        fields(cadet.RasterFiring),
    ),
    "RosetteFiring": (
        lambda **k: cadet.RosetteFiring(
            **{"firings": 2, "deflections_deg": (1.0, 2.0), "prism_rates_hz": (1.0, 2.0), **k}
        ),
        fields(cadet.RosetteFiring),
    ),
    "TableFiring": (
        cadet.TableFiring,
        fields(cadet.TableFiring),
    ),
    "TableFiring.read": (cadet.TableFiring.read, ["path"]),
    "EncoderFiring": (
        lambda **k: cadet.EncoderFiring(**{"ticks_per_turn": 4000, "ticks_per_firing": 2.0, "firings": 100, **k}),
        fields(cadet.EncoderFiring),
    ),
    "BeamTable": (
        lambda **k: cadet.Lidar.custom(cadet.BeamTable(**{"name": "x", "rings": (LASER,), "firing": FIRING, **k})),
        fields(cadet.BeamTable),
    ),
    "BeamTable.read": (cadet.BeamTable.read, ["path"]),
    "LabelConfig": (cadet.LabelConfig, fields(cadet.LabelConfig)),
    "SceneConfig": (lambda **k: cadet.SceneConfig(**k)._to_native(), fields(cadet.SceneConfig)),
    "BevConfig": (lambda **k: cadet.BevConfig(**k).shape, fields(cadet.BevConfig)),
    "bev.maps": (
        lambda **k: cadet.bev.maps(**{"points_cam": np.ones((2, 3)), "plane": np.array([0, -1, 0, 1.7]), **k}),
        ["points_cam", "plane", "config", "out"],
    ),
    "District": (lambda **k: cadet.District(**{**DISTRICT, **k}), list(DISTRICT)),
    "ResetPolicy": (
        lambda **k: dataclasses.replace(cadet.ResetPolicy.kitti(), **k).draw(0, 0),
        fields(cadet.ResetPolicy),
    ),
    "ResetPolicy.draw": (
        lambda **k: cadet.ResetPolicy.kitti().draw(**{"seed": 0, "episode": 0, **k}),
        ["seed", "episode", "attempt"],
    ),
    "ResetPolicy.named": (cadet.ResetPolicy.named, ["name_or_file"]),
    "Settings": (lambda **k: Settings(**{"policy": "kitti", **k}), fields(Settings)),
    "RoadMap": (lambda **k: cadet.RoadMap(**{"name": "x", "xodr": "", **k}), ["name", "xodr"]),
    "RoadMap.read": (cadet.RoadMap.read, ["path"]),
    "Assets": (lambda **k: cadet.Assets(**{"actors": (), **k}), ["actors", "share"]),
    "Assets.read": (cadet.Assets.read, ["folder"]),
    "ActorMesh": (
        lambda **k: cadet.ActorMesh(**{"name": "a", "type": "Car", "mesh": car_mesh(), **k}).sha256,
        fields(cadet.ActorMesh),
    ),
    "Environment": (cadet.Environment, ["policy", "rig", "map", "weather", "config", "assets"]),
    "Environment.reset": (lambda **k: cadet.Environment().reset(**{"seed": 0, **k}), ["seed", "episode"]),
    "Scene.random": (lambda **k: cadet.Scene.random(**{"seed": -1, **k}), ["policy", "rig", "config"]),
    "Level": (
        lambda **k: cadet.Level(**{"name": "x", "min_height_px": 25.0, **k}).limits(),
        fields(cadet.Level),
    ),
    "Label": (lambda **k: kitti.Label(**{**LABEL, **k}).to_line(), fields(kitti.Label)),
    "Frame": (
        lambda **k: kitti.encode_frame(dataclasses.replace(frame(), **k)),
        ["labels", "calib", "plane", "depth", "instance", "semantic", "meta"],
    ),
    "evaluate": (
        lambda **k: cadet.evaluate(**{"gt": [truth()], "det": [results()], **k}),
        ["gt", "det", "classes", "recall", "min_overlap", "levels", "split", "frames"],
    ),
    "analyze": (
        lambda **k: cadet.analyze(**{"gt": [truth()], "det": [results()], "bootstrap": 2, **k}),
        ["gt", "det", "det_b", "parts", "by", "bootstrap", "groups", "seed", "classes", "levels"],
    ),
    "EvalClass": (
        lambda **k: cadet.EvalClass(**{"name": "Car", "types": ("Car",), "min_overlap": 0.5, **k}),
        ["name", "types", "min_overlap", "neighbors"],
    ),
    "Rules.read": (cadet.Rules.read, ["path"]),
    "nms_bev": (lambda **k: cadet.nms_bev(BOXES, np.array([0.1, 0.2]), **k), ["threshold"]),
    "weather.apply": (
        lambda **k: weather.apply(frame().points_velo[:9], **k),
        ["fog", "rain", "snow", "wetness", "seed", "sensor_height_m"],
    ),
    "weather.air_of": (weather.air_of, ["name"]),
    "estimate_plane": (
        lambda **k: kitti.estimate_plane(**{"points_velo": frame().points_velo, "calib": frame().calib, **k}),
        ["points_velo", "calib", "seed"],
    ),
    "points_in_image": (
        lambda **k: kitti.points_in_image(
            **{"points_cam": np.ones((2, 3)), "calib": frame().calib, "image_size": (9, 9), **k}
        ),
        ["points_cam", "calib", "image_size"],
    ),
    "truncation": (
        lambda **k: boxes.truncation(**{"boxes_cam": BOXES, "calib": frame().calib, "image_size": (1242, 375), **k}),
        ["boxes_cam", "calib", "image_size"],
    ),
    "clip_segments": (
        lambda **k: boxes.clip_segments(**{"starts_cam": np.ones((2, 3)), "ends_cam": np.ones((2, 3)), **k}),
        ["starts_cam", "ends_cam"],
    ),
    "clip_boxes_img": (
        lambda **k: boxes.clip_boxes_img(**{"boxes_img": np.ones((2, 4)), "image_size": (9, 9), **k}),
        ["boxes_img", "image_size"],
    ),
    "areas_img": (boxes.areas_img, ["boxes_img"]),
    "iou_img": (
        lambda **k: boxes.iou_img(**{"boxes_img": np.ones((2, 4)), "others_img": np.ones((2, 4)), **k}),
        ["boxes_img", "others_img"],
    ),
    "labels_from_text": (kitti.labels_from_text, ["text"]),
    "Label.from_line": (kitti.Label.from_line, ["line"]),
    "Calibration.from_text": (kitti.Calibration.from_text, ["text"]),
    "plane_from_text": (plane_from_text, ["text"]),
    "boxes_2d": (lambda **k: cadet.evaluate([[]], [[]], **k), ["boxes_2d"]),
    "points_in_boxes": (lambda **k: boxes.points_in_boxes(BOXES, BOXES, **k), ["margin_m"]),
    "boxes_velo_from_cam": (lambda **k: boxes.boxes_velo_from_cam(BOXES, **k), ["calib"]),
    "pixels_from_depth": (images.pixels_from_depth, ["depth"]),
    "pixels_from_instance": (images.pixels_from_instance, ["instance"]),
    "bev_figure": (lambda **k: bev_figure(frame(), **k), ["width"]),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")
def test_a_wrong_type_is_refused_in_one_line(call: str) -> None:
    use, names = CALLS[call]
    for name in names:
        for value in ODD:
            wrong = what_is_wrong(functools.partial(use, **{name: value}))
            if wrong is not None:
                pytest.fail(f"{call}({name}={str(value)[:40]!r}): {wrong}")


def test_a_scene_refuses_what_is_no_place_configuration_or_kind() -> None:
    scene = cadet.Scene.empty(rig=TINY)
    for value in ODD:
        if value is not None:
            with pytest.raises(CadetError):
                cadet.Scene.empty(rig=TINY, config=value)
            with pytest.raises((CadetError, OSError)):
                cadet.Scene.empty(rig=TINY, map=value)
        with pytest.raises(CadetError):
            scene.add(value, x_m=0.0, y_m=0.0, yaw_rad=0.0)
        if not isinstance(value, bool):
            with pytest.raises(CadetError):
                scene.scan(ideal=value)
        for wrong in (value, [[value, 0.0, 0.0]]):
            what = what_is_wrong(lambda wrong=wrong: scene.cast_rays(wrong, [[0.0, 0.0, 1.0]]))  # type: ignore[misc]
            assert what is None, what
    for half in ("\ud800", "car\udfff"):
        for given in ({"kind": half}, {"kind": "car", "model": half}):
            with pytest.raises(CadetError, match=r"^add\.(kind|model): expected a string, got half of a surrogate"):
                scene.add(**given, x_m=0.0, y_m=0.0, yaw_rad=0.0)  # type: ignore[arg-type]
    assert scene.num_actors == 0


def test_numpy_numbers_are_numbers_everywhere() -> None:
    three, half = np.int64(3), np.float32(0.5)
    drawn = cadet.ResetPolicy.kitti().draw(three, np.uint8(1), np.int32(0))  # type: ignore[arg-type]
    assert drawn == cadet.ResetPolicy.kitti().draw(3, 1, 0) and type(drawn.seed) is int
    env = cadet.Environment()
    env.reset(seed=three, episode=np.int16(2))  # type: ignore[arg-type]
    assert env.episode == 2
    config = cadet.SceneConfig(num_cars=three, parking_occupancy=half)  # type: ignore[arg-type]
    assert config == cadet.SceneConfig(num_cars=3, parking_occupancy=0.5) and type(config.num_cars) is int
    camera = dataclasses.replace(KITTI, width=np.int64(640), fx=np.float64(500.0))  # type: ignore[arg-type]
    plain = dataclasses.replace(KITTI, width=640, fx=500.0)
    assert cadet.Rig(camera=camera).sha256() == cadet.Rig(camera=plain).sha256()
    assert kitti.files.folder.check_id(np.int64(12)) == "000012"  # type: ignore[arg-type]
    settings = Settings(policy=cadet.ResetPolicy.kitti(), seed=three, num_frames=np.int64(40))  # type: ignore[arg-type]
    assert settings == Settings(policy=cadet.ResetPolicy.kitti(), seed=3, num_frames=40)
    assert type(settings.seed) is int and type(settings.num_frames) is int
    points, calib = frame().points_velo, frame().calib
    np.testing.assert_array_equal(
        kitti.estimate_plane(points, calib, three),  # type: ignore[arg-type]
        kitti.estimate_plane(points, calib, 3),
    )


def test_numpys_small_numbers_are_not_confined_to_their_bits() -> None:
    small: dict[str, Any] = {"width": np.uint8(200), "height": np.uint8(100), "fx": np.float16(700.0)}
    assert dataclasses.replace(KITTI, **small) == dataclasses.replace(KITTI, width=200, height=100, fx=700.0)
    assert cadet.BevConfig(num_slices=np.uint8(200), x_m=(0.0, 8.0)).shape[0] == 201  # type: ignore[arg-type]
    half: Any = np.float16(0.5)
    assert dataclasses.replace(frame().labels[0], truncated=half).truncated == 0.5
    points = frame().points_velo
    np.testing.assert_array_equal(weather.apply(points, rain=half), weather.apply(points, rain=0.5))


@pytest.mark.parametrize("occluded", [0.5, 1.0, True, "0", None])
def test_a_level_of_occlusion_is_a_whole_number(occluded: Any) -> None:
    with pytest.raises(CadetError, match=r"^occluded: expected a whole number -1\.\.3, got "):
        kitti.Label(**{**LABEL, "occluded": occluded})


@pytest.mark.parametrize("path", ["x" * 256, "a/" + "x" * 300 + "/b", "a/" * 2_500, "\ud800"])
def test_a_path_that_no_file_can_have_is_refused_wherever_one_is_read(path: str) -> None:
    readers = (cadet.RoadMap.read, cadet.Assets.read, cadet.Rig.read, lambda text: kitti.read_image_set(".", text))
    for read in readers:
        with pytest.raises(CadetError, match=r"^\w+: (a path of \d+ bytes|expected a (path|string), got )"):
            read(path)
