"""Changes of training samples: each against its definition, and that one leaves the draws of the others alone."""

from __future__ import annotations

import colorsys
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from avod.clusters import mean_sizes_of
from avod.config import Config
from avod.config.augmentation import AugmentationConfig
from avod.config.base import config_names
from avod.data.augmentation import OFF, Augmentation
from avod.data.dataset import TrainingData, sample_from_frame
from avod.data.images import shift_colors
from avod.data.object_sizes import resize_objects
from avod.data.sample import Sample
from avod.data.scan_changes import drop_points, shift_ranges
from avod.data.world import WorldChange
from cadet.errors import CadetError
from cadet.formats.kitti import write_frame
from cadet.formats.kitti.boxes import corners_cam, points_in_boxes
from synthetic import make_calib, make_frame, make_label

CONFIG = Config.named(Path(__file__).parents[2] / "support" / "detector" / "overfit.toml")
WORLD: dict[str, Any] = {"rotation_deg": 20.0, "scaling": 0.1, "translation_m": (1.0, 0.3, 2.0)}
EACH: dict[str, dict[str, Any]] = {
    "rotation": {"rotation_deg": 20.0},
    "scaling": {"scaling": 0.1},
    "translation": {"translation_m": (1.0, 0.3, 2.0)},
    "dropout": {"point_dropout": 0.5},
    "noise": {"range_noise_m": 0.05},
    "sizes": {"object_scaling": 0.2},
    "brightness": {"brightness": 0.2},
    "contrast": {"contrast": 0.4},
    "hue": {"hue_deg": 30.0},
}


def augmented(seed: int, **settings: Any) -> Augmentation:
    return Augmentation(seed=(seed,), settings=AugmentationConfig(**settings))


def pixels(projection: NDArray[np.float64], points_cam: NDArray[np.float64]) -> NDArray[np.float64]:
    image = points_cam @ projection[:, :3].T + projection[:, 3]
    return image[:, :2] / image[:, 2:]


@pytest.mark.parametrize("seed", range(8))
def test_every_point_keeps_its_pixel_in_a_changed_world(seed: int) -> None:
    calib, rng = make_calib(), np.random.default_rng(seed)
    change = WorldChange.drawn(augmented(seed, **WORLD))
    assert change is not None and abs(change.scale - 1.0) < 0.1
    points = rng.uniform((-30.0, -3.0, 2.0), (30.0, 2.0, 70.0), (5000, 3))
    found = pixels(change.projection(calib.P2), change.points(points))
    np.testing.assert_allclose(found, pixels(calib.P2, points), atol=1e-6)
    # Distances, and so the depths that crops are cut by, are those of the changed world.
    depths = change.points(points) @ change.projection(calib.P2)[2, :3] + change.projection(calib.P2)[2, 3]
    np.testing.assert_allclose(depths, change.scale * (points @ calib.P2[2, :3] + calib.P2[2, 3]), atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_boxes_and_plane_move_with_the_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    change = WorldChange.drawn(augmented(seed, **WORLD))
    assert change is not None
    boxes = np.column_stack([rng.uniform(-9, 30, (20, 3)), rng.uniform(0.5, 5, (20, 3)), rng.uniform(-3.1, 3.1, 20)])
    moved = change.points(corners_cam(boxes).reshape(-1, 3)).reshape(20, 8, 3)
    np.testing.assert_allclose(corners_cam(change.boxes(boxes)), moved, atol=1e-9)
    points = rng.uniform(-5, 30, (2000, 3))
    np.testing.assert_array_equal(
        points_in_boxes(points, boxes, -1e-6), points_in_boxes(change.points(points), change.boxes(boxes), -1e-6)
    )
    plane = np.array([0.05, -0.99, 0.02, 1.7]) / np.linalg.norm([0.05, -0.99, 0.02])
    changed = change.plane(plane)
    heights = change.points(points) @ changed[:3] + changed[3]
    np.testing.assert_allclose(heights, change.scale * (points @ plane[:3] + plane[3]), atol=1e-9)


def test_a_sample_of_a_changed_world_belongs_together() -> None:
    frame = make_frame(plane=np.array([0.05, -0.99, 0.02, 1.7]))
    plain = sample_from_frame(frame, "000000", CONFIG)
    sample = sample_from_frame(frame, "000000", CONFIG, augmented(3, **WORLD))
    assert torch.equal(sample.image, plain.image) and torch.equal(sample.classes, plain.classes)
    assert not torch.allclose(sample.boxes_cam, plain.boxes_cam, atol=0.1)
    assert len(sample.anchors) and not torch.equal(sample.bev, plain.bev)
    height = sample.anchors @ torch.cat([sample.plane[:3], torch.zeros(3)]) + sample.plane[3]
    assert height.abs().max() < 1e-4, "anchors stand on the changed ground"
    for old, new in zip(plain.boxes_cam, sample.boxes_cam, strict=True):
        first, second = (
            pixels(item.projection.numpy().astype(np.float64), corners_cam(box[None].numpy().astype(np.float64))[0])
            for item, box in ((plain, old), (sample, new))
        )
        np.testing.assert_allclose(first, second, atol=2e-3)


def test_mirrored_and_changed_is_the_mirrored_sample_changed() -> None:
    frame = make_frame()
    both = dataclasses.replace(augmented(1, rotation_deg=20.0), is_mirrored=True)
    sample, mirrored = (
        sample_from_frame(frame, "000000", CONFIG, change) for change in (both, Augmentation(is_mirrored=True))
    )
    change = WorldChange.drawn(both)
    assert change is not None
    expected = change.boxes(mirrored.boxes_cam.numpy().astype(np.float64))
    np.testing.assert_allclose(sample.boxes_cam.numpy(), expected, atol=1e-5)


def test_a_share_of_the_points_is_left_out() -> None:
    points = np.random.default_rng(0).normal(size=(4000, 3))
    left = [len(drop_points(points, augmented(seed, point_dropout=0.6))) / 4000 for seed in range(200)]
    assert min(left) == pytest.approx(0.4, abs=0.05) and max(left) == pytest.approx(1.0, abs=0.05)
    assert np.mean(left) == pytest.approx(0.7, abs=0.04)
    kept = drop_points(points, augmented(1, point_dropout=0.6))
    places = [int(np.flatnonzero((points == point).all(axis=1))[0]) for point in kept]
    assert places == sorted(places)


def test_noise_moves_points_along_their_beams() -> None:
    rng, lidar = np.random.default_rng(0), np.array([0.3, -0.1, 0.2])
    points = rng.uniform(2, 40, (20_000, 3))
    points[0] = lidar
    moved = shift_ranges(points, lidar, augmented(0, range_noise_m=0.05))
    np.testing.assert_array_equal(moved[0], lidar)
    beams, new = (p[1:] - lidar for p in (points, moved))
    assert np.abs(np.cross(beams, new)).max() < 1e-9
    change = np.linalg.norm(new, axis=1) - np.linalg.norm(beams, axis=1)
    assert change.std() == pytest.approx(0.05, rel=0.03) and abs(change.mean()) < 0.002


def test_objects_are_resized_with_the_points_in_them() -> None:
    rng = np.random.default_rng(0)
    boxes = np.array([[-6.0, 1.6, 12.0, 4.0, 1.7, 1.5, 0.7], [5.0, 1.5, 20.0, 0.8, 0.6, 1.8, -2.0]])
    points = rng.uniform((-12, -1, 5), (9, 2, 25), (40_000, 3))
    classes = np.array([1, 2])
    shifts = ((0.4, -0.1, 0.2), (0.0, 0.1, -0.2))
    change = Augmentation(size_shifts_m=shifts)
    moved, resized = resize_objects(points, boxes, classes, change)
    np.testing.assert_allclose(resized[:, 3:6], boxes[:, 3:6] + shifts, atol=1e-12)
    np.testing.assert_array_equal(resized[:, [0, 1, 2, 6]], boxes[:, [0, 1, 2, 6]])
    inside = points_in_boxes(points, boxes)
    assert inside.sum(axis=0).min() > 30
    np.testing.assert_array_equal(moved[~inside.any(axis=1)], points[~inside.any(axis=1)])
    for index in range(2):
        # A point keeps its place between opposite faces.
        old, new = (shares(p[inside[:, index]], box) for p, box in ((points, boxes[index]), (moved, resized[index])))
        np.testing.assert_allclose(old, new, atol=1e-9)
        assert np.abs(new).max() <= 1.0 + 1e-9


def test_a_point_in_two_boxes_follows_the_first() -> None:
    boxes = np.array([[0.0, 1.6, 12.0, 4.0, 2.0, 1.5, 0.0], [1.0, 1.6, 12.0, 4.0, 2.0, 1.5, 0.0]])
    change = Augmentation(size_shifts_m=((2.0, 0.0, 0.0),))
    moved, _ = resize_objects(np.array([[1.0, 1.0, 12.5]]), boxes, np.array([1, 1]), change)
    np.testing.assert_allclose(moved, [[1.5, 1.0, 12.5]], atol=1e-12)
    # What is of no class keeps its size.
    _, resized = resize_objects(np.zeros((0, 3)), boxes, np.array([0, 1]), change)
    np.testing.assert_array_equal(resized[:, 3], [4.0, 6.0])


def shares(points: NDArray[np.float64], box: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where points lie between opposite faces: -1 to 1 along, and across, and up."""
    corners = corners_cam(box[None])[0]
    origin, axes = corners[2], np.stack([corners[1] - corners[2], corners[3] - corners[2], corners[6] - corners[2]])
    return 2.0 * np.linalg.solve(axes.T, (points - origin).T).T - 1.0


def test_random_sizes_are_drawn_for_each_object_and_axis() -> None:
    boxes = np.tile([0.0, 1.6, 12.0, 4.0, 1.7, 1.5, 0.0], (500, 1))
    _, resized = resize_objects(np.zeros((0, 3)), boxes, np.ones(500, np.int64), augmented(0, object_scaling=0.2))
    factors = resized[:, 3:6] / boxes[:, 3:6]
    assert factors.min() == pytest.approx(0.8, abs=0.01) and factors.max() == pytest.approx(1.2, abs=0.01)
    assert np.abs(np.corrcoef(factors.T) - np.eye(3)).max() < 0.15


def test_sizes_are_shifted_to_the_means_that_are_wanted(tmp_path: Path) -> None:
    calib = make_calib()
    for index, length in enumerate((4.0, 4.4)):
        label = make_label("Car", (-2.0, 1.65, 14.0, length, 1.7, 1.5, 1.5), calib)
        write_frame(tmp_path / "set", index, make_frame(labels=(label,)))
        other = make_label("Car", (-2.0, 1.65, 14.0, length - 0.7, 1.6, 1.6, 1.5), calib)
        write_frame(tmp_path / "target", index, make_frame(labels=(other,)))
    config = Config.named("tiny_car")
    wanted = mean_sizes_of(tmp_path / "target", ("Car",))
    assert wanted == ((3.5, 1.6, 1.6),)
    with pytest.raises(CadetError, match="none of 2 frames has a label of Cyclist, whose mean size is wanted"):
        mean_sizes_of(tmp_path / "target", ("Car", "Cyclist"))
    config = dataclasses.replace(
        config,
        training=dataclasses.replace(config.training, min_objects=1),
        augmentation=AugmentationConfig(object_sizes_lwh_m=wanted),
    )
    data = TrainingData(tmp_path / "set", None, config, 0)
    samples = [item for index in range(8) if isinstance(item := data[index], Sample)]
    sizes = {tuple(np.round(sample.boxes_cam[0, 3:6].tolist(), 4)) for sample in samples}
    assert sizes == {(3.3, 1.6, 1.6), (3.7, 1.6, 1.6)}


def test_a_turn_by_120_degrees_changes_the_channels_places() -> None:
    image = np.random.default_rng(0).integers(0, 256, (30, 40, 3), dtype=np.uint8)
    turned = shift_colors(image, 0.0, 1.0, 120.0)
    np.testing.assert_array_equal(turned, image[..., [2, 0, 1]])
    np.testing.assert_array_equal(shift_colors(image, 0.0, 1.0, 0.0), image)


def test_brightness_contrast_and_hue_are_what_they_say() -> None:
    image = np.random.default_rng(0).integers(100, 150, (30, 40, 3), dtype=np.uint8)
    np.testing.assert_allclose(shift_colors(image, 0.1, 1.0, 0.0), image + 25.5, atol=0.51)
    contrasted = shift_colors(image, 0.0, 1.5, 0.0).astype(float)
    np.testing.assert_allclose(contrasted, image.mean() + 1.5 * (image - image.mean()), atol=0.51)
    # Gray keeps its place, and a small turn moves hues as the color wheel does.
    gray = np.repeat(image[..., :1], 3, axis=2)
    np.testing.assert_array_equal(shift_colors(gray, 0.0, 1.0, 30.0), gray)
    reddish = np.full((1, 1, 3), (180, 120, 120), np.uint8)
    found = colorsys.rgb_to_hsv(*(shift_colors(reddish, 0.0, 1.0, 20.0)[0, 0] / 255.0))
    assert 360.0 * found[0] == pytest.approx(20.0, abs=3.0)
    assert shift_colors(np.full((2, 2, 3), 250, np.uint8), 0.5, 1.0, 0.0).min() == 255, "no wrapping around"


@pytest.mark.parametrize("name", EACH)
def test_each_switch_works_alone_and_is_drawn_from_its_own_seed(name: str) -> None:
    frame = make_frame()
    plain = sample_from_frame(frame, "000000", CONFIG)
    first, again, other = (sample_from_frame(frame, "000000", CONFIG, augmented(s, **EACH[name])) for s in (5, 5, 6))
    fields = ("bev", "image", "anchors", "plane", "projection", "boxes_cam")
    assert all(torch.equal(getattr(first, field), getattr(again, field)) for field in fields)
    assert not all(torch.equal(getattr(first, field), getattr(other, field)) for field in fields)
    assert not all(torch.equal(getattr(first, field), getattr(plain, field)) for field in fields)
    is_of_image = name in ("brightness", "contrast", "hue")
    assert torch.equal(first.image, plain.image) != is_of_image
    assert torch.equal(first.bev, plain.bev) == is_of_image


def test_switches_leave_each_others_draws_alone() -> None:
    frame = make_frame()
    one, both = (
        sample_from_frame(frame, "000000", CONFIG, augmented(5, **settings))
        for settings in (WORLD, WORLD | {"point_dropout": 0.5, "range_noise_m": 0.05, "brightness": 0.2})
    )
    assert torch.equal(one.boxes_cam, both.boxes_cam) and torch.equal(one.projection, both.projection)


@pytest.mark.parametrize("name", config_names())
def test_everything_is_off_in_the_papers_configurations(name: str) -> None:
    config = Config.named(name)
    if not name.startswith(("tiny_", "center_")):
        assert config.augmentation == OFF and config.training.average_decay == 0.0


def test_training_draws_what_its_configuration_says(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame())
    config = dataclasses.replace(CONFIG, augmentation=AugmentationConfig(rotation_deg=30.0))
    samples = [TrainingData(tmp_path, None, config, 7)[index] for index in (0, 1, 2, 1)]
    turns = [float(item.boxes_cam[0, 6]) for item in samples if isinstance(item, Sample)]
    assert turns[1] == turns[3] and len(set(turns)) == 3


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"rotation_deg": 50.0}, "AugmentationConfig.rotation_deg: expected a number from 0 to 45, got 50.0"),
        ({"scaling": -0.1}, "AugmentationConfig.scaling: expected a number from 0 to 0.5, got -0.1"),
        ({"translation_m": (0.0, 0.0, 99.0)}, "AugmentationConfig.translation_m: expected a number from 0 to 10"),
        ({"point_dropout": 1.0}, "AugmentationConfig.point_dropout: expected a number from 0 to 0.95, got 1.0"),
        ({"object_sizes_lwh_m": ((4.0, 1.6, 0.0),)}, "AugmentationConfig.object_sizes_lwh_m: expected a number from"),
        ({"pasted_objects": 0.5}, "AugmentationConfig.pasted_objects: expected a whole number from 0 to 64, got 0.5"),
    ],
)
def test_nonsense_is_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(CadetError) as error:
        AugmentationConfig(**settings)
    assert str(error.value).startswith(message)


def test_sizes_are_needed_for_each_class() -> None:
    with pytest.raises(CadetError, match="expected a size for each of 1 classes, got 2"):
        Config(augmentation=AugmentationConfig(object_sizes_lwh_m=((1.0, 1.0, 1.0),) * 2))
