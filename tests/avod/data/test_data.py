"""Samples: images against loops, mirrored worlds, the seams for what is missing."""

from __future__ import annotations

import math
import pickle
import shutil
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import torch

from avod.config import Config, TrainingConfig
from avod.data import mirror
from avod.data.augmentation import Augmentation
from avod.data.build import _points_cam_in_image, build_sample, normal_plane
from avod.data.dataset import TrainingData, sample_from_frame
from avod.data.images import jitter_colors, resize_bilinear
from avod.data.order import Order, StepSampler
from avod.data.packing import packed
from avod.data.sample import Sample
from avod.geometry.anchors import anchors_over
from avod.geometry.encoding import anchors_from_boxes, offsets_from_anchors
from avod.model.avod.network import AvodNetwork
from cadet.errors import CadetError, CadetWarning, NonFiniteError, ShapeError
from cadet.formats.kitti import Calibration, estimate_plane, points_in_image, write_frame
from cadet.formats.kitti.boxes import project_boxes
from synthetic import IMAGE_SIZE, make_calib, make_frame, make_labels

CONFIG = Config.named(Path(__file__).parents[2] / "support" / "detector" / "overfit.toml")
PLANE = normal_plane(np.array([0.05, -0.99, 0.02, 1.7]))
MIRRORED = np.array([-1.0, 1.0, 1.0, 1.0, 1.0, 1.0])


@pytest.mark.parametrize("size", [(7, 5), (23, 31), (40, 30), (3, 2)])
def test_resizing_agrees_with_a_loop(size: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    # Smooth, as OpenCV 4 rounds positions to 1/32 of a pixel.
    image = cv2.GaussianBlur(rng.integers(0, 256, (15, 20, 3), dtype=np.uint8), (0, 0), 2.0)
    found = resize_bilinear(np.asarray(image, np.uint8), size)
    assert found.shape == (size[1], size[0], 3) and found.dtype == np.uint8
    steepest = max(np.abs(np.diff(image.astype(int), axis=axis)).max() for axis in (0, 1))
    for row in range(size[1]):
        for column in range(size[0]):
            y, x = row * 15 / size[1], column * 20 / size[0]
            top, left = math.floor(y), math.floor(x)
            bottom, right = min(top + 1, 14), min(left + 1, 19)
            above = image[top, left] * (1 - (x - left)) + image[top, right] * (x - left)
            below = image[bottom, left] * (1 - (x - left)) + image[bottom, right] * (x - left)
            expected = above * (1 - (y - top)) + below * (y - top)
            np.testing.assert_allclose(found[row, column], expected, atol=0.501 + steepest / 32)


def test_the_network_takes_the_mean_off_each_channel() -> None:
    config = replace(CONFIG, image=replace(CONFIG.image, mean_rgb=(1.0, 2.0, 3.0)))
    seen: list[torch.Tensor] = []
    network = AvodNetwork(config).eval()
    network.image_pyramid.register_forward_pre_hook(lambda module, inputs: seen.append(inputs[0]))
    frame = make_frame()
    image = np.full_like(frame.image, (10, 20, 30))
    network([sample_from_frame(replace(frame, image=image), "000000", config)])
    assert seen[0].dtype == torch.float32
    assert seen[0].amax(dim=(0, 2, 3)).tolist() == seen[0].amin(dim=(0, 2, 3)).tolist() == [9.0, 18.0, 27.0]


def test_no_point_that_the_image_sees_is_lost() -> None:
    calib, rng = make_calib(), np.random.default_rng(0)
    for spread in (1.0, 60.0, 1e4, 1e30):
        points = np.hstack([rng.normal(0, spread, (20_000, 3)), np.zeros((20_000, 1))]).astype(np.float32)
        points_cam = calib.points_cam_from_velo(points)
        expected = points_cam[points_in_image(points_cam, calib, IMAGE_SIZE)]
        np.testing.assert_array_equal(_points_cam_in_image(points, calib, IMAGE_SIZE), expected)
    # Points on the image's borders, and a hair to either side of them.
    edges = np.array([[u, v] for u in (0.0, IMAGE_SIZE[0]) for v in np.linspace(0, IMAGE_SIZE[1], 200)])
    depths = rng.uniform(0.5, 120.0, (len(edges), 1))
    rays = np.linalg.solve(calib.P2[:, :3], (np.hstack([edges, np.ones((len(edges), 1))]) * depths - calib.P2[:, 3]).T)
    velo = calib.points_velo_from_cam(rays.T)
    points = np.hstack([velo, np.zeros((len(velo), 1))]).astype(np.float32)
    points = np.concatenate([points, np.nextafter(points, np.float32(1e9)), np.nextafter(points, np.float32(-1e9))])
    points_cam = calib.points_cam_from_velo(points)
    is_seen = points_in_image(points_cam, calib, IMAGE_SIZE)
    assert 0.1 < is_seen.mean() < 0.9
    np.testing.assert_array_equal(_points_cam_in_image(points, calib, IMAGE_SIZE), points_cam[is_seen])


def test_packed_samples_are_the_samples() -> None:
    sample = sample_from_frame(make_frame(), "000003", CONFIG)
    packed_sample = packed(sample)
    again = pickle.loads(pickle.dumps(packed_sample)).unpacked(torch.device("cpu"))
    assert sample.frame_id == again.frame_id and sample.image_size == again.image_size
    for name in ("bev", "image", "anchors", "plane", "projection", "boxes_cam", "classes"):
        assert torch.equal(getattr(sample, name), getattr(again, name)), name
    assert packed_sample.values.numel() < 0.1 * sample.bev.numel()
    odd = replace(sample, bev=torch.rand(2, 3, 5))
    assert torch.equal(packed(odd).unpacked(torch.device("cpu")).bev, odd.bev)


def test_the_ground_of_a_frame_is_estimated_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_frame(tmp_path, 0, make_frame(plane=None, points_velo=flat_ground_points()))
    calls: list[int] = []

    def estimate(points_velo: Any, calib: Calibration) -> Any:
        calls.append(len(points_velo))
        return estimate_plane(points_velo, calib)

    monkeypatch.setattr("avod.data.build.estimate_plane", estimate)
    data = TrainingData(tmp_path, None, replace(CONFIG, ground="estimated"), 0)
    samples = [data[index] for index in range(8)]
    assert calls == [4000]
    expected = estimate_plane(flat_ground_points(), make_calib())
    planes = {tuple(np.abs(sample.plane.numpy()).round(5)) for sample in samples if isinstance(sample, Sample)}
    assert planes == {tuple(np.abs(expected).astype(np.float32).round(5))}, "mirrored or not"


def test_jitter_shifts_all_pixels_alike_along_the_colors_axes() -> None:
    rng = np.random.default_rng(1)
    image = np.clip(rng.normal(128, 20, (60, 80, 1)) + rng.normal(0, 2, (60, 80, 3)), 60, 200).astype(np.uint8)
    shifts = []
    for seed in range(200):
        shifted = jitter_colors(image, np.random.default_rng(seed))
        change = shifted.astype(int) - image
        assert np.ptp(change, axis=(0, 1)).max() <= 1, "one shift for all, but for rounding"
        shifts.append(change.mean(axis=(0, 1)))
    colors = image.reshape(-1, 3) / 255.0
    variances, axes = np.linalg.eigh(np.cov(colors, rowvar=False))
    shift = axes @ (np.sqrt(variances) * np.random.default_rng(7).normal(0.0, 0.1, 3))
    expected = np.clip(image / 255.0 + shift, 0.0, 1.0) * 255.0
    assert np.abs(jitter_colors(image, np.random.default_rng(7)) - (expected - 0.5)).max() <= 0.51, "truncated"
    # These colors vary along gray with a deviation of 20, so the shift along gray has a tenth of that.
    along_gray = np.array(shifts) @ np.ones(3) / math.sqrt(3)
    assert along_gray.std() == pytest.approx(0.1 * 20 * math.sqrt(3), rel=0.15)
    np.testing.assert_array_equal(
        jitter_colors(image, np.random.default_rng(3)), jitter_colors(image, np.random.default_rng(3))
    )


def test_mirroring_twice_changes_nothing() -> None:
    calib, rng = make_calib(), np.random.default_rng(0)
    projection = calib.P2.copy()
    twice = mirror.mirror_projection(mirror.mirror_projection(projection, 620), 620)
    np.testing.assert_allclose(twice, projection, atol=1e-9)
    boxes = np.column_stack([rng.uniform(-9, 9, (40, 6)), np.linspace(-math.pi, math.pi, 40)])
    boxes[0, 6] = -3.14159
    cases: list[tuple[Callable[[Any], Any], Any]] = [
        (mirror.mirror_image, rng.integers(0, 255, (4, 5, 3), dtype=np.uint8)),
        (mirror.mirror_points, rng.normal(size=(9, 3))),
        (mirror.mirror_plane, PLANE),
        (mirror.mirror_boxes, boxes[1:]),
    ]
    for function, value in cases:
        np.testing.assert_allclose(function(function(value)), value, atol=1e-12)
        assert not np.array_equal(function(value), value)


def test_the_mirrored_camera_sees_the_mirrored_world_as_the_mirrored_image() -> None:
    calib = make_calib()
    width = IMAGE_SIZE[0]
    boxes = np.stack([label.box_cam for label in make_labels(calib)[:3]])
    left, top, right, bottom = project_boxes(boxes, calib).T
    mirrored = Calibration(**{**vars_of(calib), "P2": mirror.mirror_projection(calib.P2, width)})
    found = project_boxes(mirror.mirror_boxes(boxes), mirrored)
    np.testing.assert_allclose(found, np.stack([width - 1 - right, top, width - 1 - left, bottom], axis=1), atol=1e-9)


def vars_of(calib: Calibration) -> dict[str, Any]:
    names = ("P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo")
    return {name: getattr(calib, name) for name in names}


def test_anchors_of_the_mirrored_plane_are_the_mirrored_anchors_heights_too() -> None:
    config = Config.named("car_default")
    every = replace(config.anchors, min_occupied_cells=0)
    cells = np.zeros(config.bev.shape[:0:-1], np.bool_)
    grid, mirrored = (
        anchors_over(cells, plane, config.classes, every, config.bev) for plane in (PLANE, mirror.mirror_plane(PLANE))
    )
    expected = grid * MIRRORED
    order = [np.lexsort(anchors.round(6).T) for anchors in (mirrored, expected)]
    np.testing.assert_allclose(mirrored[order[0]], expected[order[1]], atol=1e-12)
    assert np.ptp(mirrored[:, 1] - grid[:, 1]) > 0.5, "the plane is tilted enough to tell"


def test_offsets_of_a_mirrored_sample_are_the_mirrored_offsets() -> None:
    rng = np.random.default_rng(0)
    anchors = rng.uniform(1, 4, (30, 6))
    boxes = np.column_stack([rng.uniform(1, 4, (30, 6)), rng.uniform(-math.pi, math.pi, 30)])
    offsets, mirrored = (
        offsets_from_anchors(torch.from_numpy(a), anchors_from_boxes(torch.from_numpy(b))).numpy()
        for a, b in ((anchors, boxes), (anchors * MIRRORED, mirror.mirror_boxes(boxes)))
    )
    np.testing.assert_allclose(mirrored, offsets * MIRRORED, atol=1e-12)


def test_a_mirrored_sample_is_the_sample_mirrored() -> None:
    frame = make_frame(plane=PLANE)
    plain = sample_from_frame(frame, "000000", CONFIG)
    mirrored = sample_from_frame(frame, "000000", CONFIG, Augmentation(is_mirrored=True))
    # Points on the border between two cells may change sides, and the image's resizing is not symmetric.
    assert (plain.bev.flip(2) != mirrored.bev).float().mean() < 0.002
    assert abs(len(plain.anchors) - len(mirrored.anchors)) < 0.03 * len(plain.anchors)
    height = mirrored.anchors @ torch.cat([mirrored.plane[:3], torch.zeros(3)]) + mirrored.plane[3]
    assert height.abs().max() < 1e-4, "anchors stand on the mirrored ground"
    torch.testing.assert_close(mirrored.boxes_cam[:, 0], -plain.boxes_cam[:, 0])
    assert torch.equal(mirrored.classes, plain.classes)
    turned = mirror.mirror_sample(plain)
    assert torch.equal(turned.bev, plain.bev.flip(2)) and torch.equal(turned.image, plain.image.flip(2))
    height = turned.anchors @ torch.cat([turned.plane[:3], torch.zeros(3)]) + turned.plane[3]
    assert len(turned.anchors) == len(plain.anchors) and height.abs().max() < 1e-4
    for name in ("points_cam", "plane", "projection", "boxes_cam", "ignored_cam"):
        torch.testing.assert_close(getattr(turned, name), getattr(mirrored, name), rtol=1e-5, atol=1e-4)


def test_a_sample_holds_the_objects_of_the_classes_alone() -> None:
    sample = sample_from_frame(make_frame(), "000000", CONFIG)
    assert sample.classes.tolist() == [1, 1, 2]
    cars = sample_from_frame(make_frame(), "000000", Config.named("tiny_car"))
    assert cars.classes.tolist() == [1, 1]
    assert sample.bev.shape == CONFIG.bev.shape and sample.image.shape == (3, 96, 304)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_planes_come_to_one_form(sign: float) -> None:
    np.testing.assert_allclose(normal_plane(PLANE * 3.0 * sign), PLANE, atol=1e-12)


@pytest.mark.parametrize("plane", [[0.0, 0.0, 1.0, 5.0], [0.0, 0.0, 0.0, 0.0]])
def test_a_wall_is_no_ground(plane: list[float]) -> None:
    with pytest.raises(CadetError, match="expected a ground plane"):
        normal_plane(np.array(plane))


def test_bad_input_is_named() -> None:
    frame = make_frame()
    arguments = (frame.image, frame.calib, PLANE, CONFIG)
    points = frame.points_velo.copy()
    points[7, 1] = np.nan
    with pytest.raises(NonFiniteError, match=r"points_velo: not finite at \[7, 1\]"):
        build_sample(points, *arguments)
    with pytest.raises(ShapeError, match="points_velo: expected"):
        build_sample(frame.points_velo[:, :3], *arguments)
    with pytest.raises(ShapeError, match="image: expected"):
        build_sample(frame.points_velo, frame.image[..., 0], *arguments[1:])
    with pytest.raises(NonFiniteError, match="plane: not finite"):
        build_sample(frame.points_velo, frame.image, frame.calib, PLANE * np.nan, CONFIG)


def flat_ground_points(num: int = 4000) -> np.ndarray[Any, np.dtype[np.float32]]:
    rng = np.random.default_rng(0)
    columns = (rng.uniform(3, 25, num), rng.uniform(-7, 7, num), np.full(num, -1.73), np.full(num, 0.3))
    return np.column_stack(columns).astype(np.float32)


def test_a_missing_plane_is_estimated() -> None:
    frame = make_frame(plane=None)
    sample = build_sample(flat_ground_points(), frame.image, frame.calib, None, CONFIG)
    expected = estimate_plane(flat_ground_points(), frame.calib)
    np.testing.assert_allclose(sample.plane.numpy(), expected, atol=1e-6)
    with pytest.warns(CadetWarning, match=r"^frame nine points: no ground is found in the scan .* level 1\.65 m below"):
        sample = build_sample(flat_ground_points(9), frame.image, frame.calib, None, CONFIG, frame_id="nine points")
    assert sample.plane.tolist() == pytest.approx([0.0, -1.0, 0.0, 1.65])
    assert not len(build_sample(flat_ground_points(0), frame.image, frame.calib, None, CONFIG).anchors)


def test_estimated_ground_ignores_the_plane_that_a_frame_has() -> None:
    points_velo = flat_ground_points()
    points_velo[:300, 2] += 0.7  # of objects
    frame = make_frame(plane=PLANE, points_velo=points_velo)
    estimated = replace(CONFIG, ground="estimated")
    expected = estimate_plane(frame.points_velo, frame.calib)
    assert abs(expected[3] - PLANE[3]) > 0.03
    np.testing.assert_allclose(sample_from_frame(frame, "000000", CONFIG).plane.numpy(), PLANE, atol=1e-6)
    sample = sample_from_frame(frame, "000000", estimated)
    np.testing.assert_allclose(sample.plane.numpy(), expected, atol=1e-6)
    height = sample.anchors @ torch.cat([sample.plane[:3], torch.zeros(3)]) + sample.plane[3]
    assert len(sample.anchors) and height.abs().max() < 1e-4, "anchors stand on the estimated ground"
    mirrored = sample_from_frame(frame, "000000", estimated, Augmentation(is_mirrored=True))
    np.testing.assert_allclose(mirrored.plane.numpy(), mirror.mirror_plane(expected), atol=1e-6)
    # In memory as from a folder: the plane that is handed over is checked and then left aside.
    arguments = (frame.points_velo, frame.image, frame.calib)
    np.testing.assert_allclose(build_sample(*arguments, PLANE, estimated).plane.numpy(), expected, atol=1e-6)
    with pytest.raises(CadetError, match="expected a ground plane"):
        build_sample(*arguments, np.array([0.0, 0.0, 1.0, 5.0]), estimated)
    sample = build_sample(flat_ground_points(9), frame.image, frame.calib, PLANE, estimated)
    np.testing.assert_allclose(sample.plane.numpy(), PLANE, atol=1e-6, err_msg="nine points show no ground")


def test_each_epoch_holds_every_frame_in_every_change_once() -> None:
    order = Order(5, TrainingConfig(), seed=3)
    epochs = [[order.entry(index) for index in range(20 * epoch, 20 * (epoch + 1))] for epoch in range(2)]
    for entries in epochs:
        keys = {(e.frame, e.augmentation.is_mirrored, e.augmentation.has_jitter) for e in entries}
        assert len(keys) == 20 and {frame for frame, _, _ in keys} == set(range(5))
    assert [e.frame for e in epochs[0]] != [e.frame for e in epochs[1]]
    plain = Order(5, TrainingConfig(flip=False, pca_jitter=False), seed=3)
    assert sorted(plain.entry(index).frame for index in range(5)) == list(range(5))
    assert not any(plain.entry(index).augmentation.is_mirrored for index in range(50))


def test_processes_share_the_steps_out_without_overlap() -> None:
    shares = [list(StepSampler(3, 6, 2, rank, 2)) for rank in range(2)]
    flat = sorted(index for share in shares for step in share for index in step)
    assert flat == list(range(12, 24))
    assert shares[1][0] == [14, 15]


def test_training_data_leaves_frames_without_enough_objects_out(tmp_path: Path) -> None:
    labels = tuple(label for label in make_frame().labels if label.type in CONFIG.class_names)
    assert len(labels) >= 2
    for index, count in enumerate((0, 1, 2)):
        write_frame(tmp_path, index, make_frame(labels=labels[:count]))
    for least, expected in ((1, ("000001", "000002")), (2, ("000002",))):
        config = replace(CONFIG, training=replace(CONFIG.training, min_objects=least))
        assert TrainingData(tmp_path, None, config, 0).ids == expected
    for least, wanted in ((1, "a Car or Pedestrian"), (3, "3 of Car or Pedestrian")):
        config = replace(CONFIG, training=replace(CONFIG.training, min_objects=least))
        write_frame(tmp_path, 1, make_frame(labels=()), overwrite=True)
        write_frame(tmp_path, 2, make_frame(labels=()), overwrite=True)
        with pytest.raises(CadetError, match=f"none of the 3 frames holds {wanted} to learn from"):
            TrainingData(tmp_path, None, config, 0)


def test_other_frames_take_the_turn_of_one_that_cannot_be_read(tmp_path: Path) -> None:
    for frame_id in ("a1", "b2", "c3", "d4"):
        write_frame(tmp_path, frame_id, make_frame())
    whole = [sample.frame_id for sample in _samples(TrainingData(tmp_path, None, CONFIG, 0), range(16))]
    (tmp_path / "training" / "velodyne" / "b2.bin").write_bytes(bytes(5))
    with pytest.warns(
        CadetWarning, match=r"^frame b2 is left out, others take its turn: velodyne/b2\.bin: truncated"
    ) as said:
        damaged = [sample.frame_id for sample in _samples(TrainingData(tmp_path, None, CONFIG, 0), range(16))]
    assert len(said) == 1 and "b2" in whole
    assert all(new == old if old != "b2" else new != "b2" for old, new in zip(whole, damaged, strict=True))
    again = TrainingData(tmp_path, None, CONFIG, 0)
    assert [sample.frame_id for sample in _samples(again, reversed(range(16)))] == damaged[::-1], "whoever reads it"


def test_frames_whose_files_or_labels_are_missing_are_left_out_before_the_first_step(tmp_path: Path) -> None:
    for number in range(6):
        write_frame(tmp_path, number, make_frame())
    folder = tmp_path / "training"
    (folder / "image_2" / "000001.png").unlink()
    (folder / "label_2" / "000004.txt").write_text("Car 0\n")
    with pytest.warns(CadetWarning, match=r"2 of 6 frames cannot be read \(000001: image_2/.* 000004: label_2/"):
        data = TrainingData(tmp_path, None, CONFIG, 0)
    assert data.ids == ("000000", "000002", "000003", "000005")
    for number in (0, 2):
        (folder / "calib" / f"{number:06d}.txt").unlink()
    with pytest.raises(CadetError, match=r"4 of 6 frames cannot be read .*; and 1 more\): more than half"):
        TrainingData(tmp_path, None, CONFIG, 0)
    shutil.rmtree(folder / "velodyne")
    with pytest.raises(CadetError, match=r"none of 6 frames has a file in velodyne, which is needed$"):
        TrainingData(tmp_path, None, CONFIG, 0)


def test_a_set_of_frames_that_cannot_be_read_ends_in_their_error(tmp_path: Path) -> None:
    write_frame(tmp_path, 1, make_frame())
    data = TrainingData(tmp_path, None, CONFIG, 0)
    (tmp_path / "training" / "velodyne" / "000001.bin").write_bytes(bytes(5))
    with pytest.warns(CadetWarning, match="000001"):
        item = data[0]
    assert isinstance(item, CadetError) and "velodyne/000001.bin: truncated" in str(item)
    assert isinstance(data[1], CadetError) and "1 of 1 frames cannot be read" in str(data[1])


def _samples(data: TrainingData, indices: Iterable[int]) -> list[Sample]:
    items = [data[index] for index in indices]
    assert all(isinstance(item, Sample) for item in items)
    return [item for item in items if isinstance(item, Sample)]
