"""Objects pasted into frames: there and back, what they hide, where they may stand, and trainings with them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from avod.config import Config
from avod.config.augmentation import AugmentationConfig
from avod.data.augmentation import Augmentation
from avod.data.dataset import TrainingData, sample_from_frame
from avod.data.paste import paste_crop, paste_objects
from avod.data.placement import Scene, place
from cadet.datasets.object_bank import BankObject, ObjectBank, cut_objects, write_bank
from cadet.errors import CadetError
from cadet.evaluation import box_iou_bev
from cadet.formats.kitti import Calibration
from cadet.formats.kitti.boxes import alpha_from_boxes, corners_cam, points_in_boxes, project_boxes
from detector.runs import StopAfter, assert_same_training, short_run, small_config, write_set
from synthetic import IMAGE_SIZE, make_calib, make_frame

CALIB = make_calib()
LIDAR = CALIB.cam_from_velo[:3, 3]
PLANE = np.array([0.0, -1.0, 0.0, 1.65])
NO_BOXES = np.zeros((0, 7))
NO_POINTS = np.zeros((0, 3))


def on_faces(box_cam: NDArray[np.float64], step_m: float = 0.1) -> NDArray[np.float64]:
    """Return points on all faces of a box: dense enough for any ray that meets it."""
    corners = corners_cam(box_cam[None])[0]
    origin, *edges = corners[2], corners[1] - corners[2], corners[3] - corners[2], corners[6] - corners[2]
    points = []
    for axis in range(3):
        first, second = (edges[k] for k in range(3) if k != axis)
        counts = (int(np.linalg.norm(edge) / step_m) + 1 for edge in (first, second))
        a, b = np.meshgrid(*(np.linspace(0, 1, count) for count in counts))
        face = origin + a.reshape(-1, 1) * first + b.reshape(-1, 1) * second
        points += [face, face + edges[axis]]
    return np.concatenate(points)


def make_object(box_cam: tuple[float, ...], kind: str = "Car", color: int = 255) -> BankObject:
    """Make an object whose crop is a board of one color, as wide as its box is long."""
    box = np.array(box_cam)
    points = on_faces(box) - LIDAR
    x, y, z, length, _, height, _ = box
    half = length / 2
    board = np.array([[x - half, y - height, z], [x + half, y - height, z], [x + half, y, z], [x - half, y, z]])
    box[:3] -= LIDAR
    crop = np.full((30, 60, 4), color, np.uint8)
    crop[..., 3] = 255
    scan = np.column_stack([points, np.full(len(points), 0.5)]).astype(np.float32)
    return BankObject(kind, box, scan, crop, board - LIDAR, "made by hand")


def scene(points_cam: NDArray[np.float64] = NO_POINTS, boxes_cam: NDArray[np.float64] = NO_BOXES) -> Scene:
    return Scene.of(points_cam, boxes_cam, PLANE, CALIB, IMAGE_SIZE)


def wall(z: float, low: tuple[float, float], high: tuple[float, float]) -> NDArray[np.float64]:
    x, y = np.meshgrid(np.arange(low[0], high[0], 0.02), np.arange(low[1], high[1], 0.02))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])


CAR = (0.0, 1.65, 15.0, 4.0, 1.7, 1.5, 0.4)


def test_an_object_pasted_where_it_was_cut_gives_the_frame_back() -> None:
    frame = make_frame(has_maps=True)
    (car,) = cut_objects(frame, ("Car",), "frame")
    points_cam = CALIB.points_cam_from_velo(frame.points_velo)
    is_its = points_in_boxes(points_cam, frame.labels[0].box_cam[None])[:, 0]
    placement = place(car, 0.0, scene(points_cam[~is_its], frame.labels[1].box_cam[None]))
    assert placement is not None and placement.hidden == 0.0
    # The ground's points are written down to the millimeter.
    np.testing.assert_allclose(placement.box_cam, frame.labels[0].box_cam, atol=1e-3)
    np.testing.assert_allclose(placement.points_cam[:, :3], points_cam[is_its], atol=1e-3)
    assert frame.instance is not None
    blank = np.where((frame.instance == 1)[..., None], 0, frame.image).astype(np.uint8)
    paste_crop(blank, car.crop, placement.corners_cam, CALIB, NO_BOXES)
    assert np.abs(blank.astype(int) - frame.image).max() <= 1


@pytest.mark.parametrize("turn_rad", [-0.4, -0.1, 0.25])
def test_a_turned_object_shows_the_lidar_the_same_side_from_as_far(turn_rad: float) -> None:
    item = make_object(CAR)
    placement = place(item, turn_rad, scene())
    assert placement is not None
    found, before = (p[:, :3] for p in (placement.points_cam[:, :3] - LIDAR, item.points_scan))
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), np.linalg.norm(before, axis=1), atol=1e-4)
    azimuths = [np.arctan2(p[:, 0], p[:, 2]) for p in (before, found)]
    np.testing.assert_allclose(azimuths[1] - azimuths[0], turn_rad, atol=1e-4)
    assert points_in_boxes(placement.points_cam, placement.box_cam[None], 1e-3).all()
    seen = [box - [*LIDAR, 0, 0, 0, 0] for box in (np.array(CAR), placement.box_cam)]
    first, second = alpha_from_boxes(np.stack(seen))
    assert first == pytest.approx(second, abs=1e-9)


def test_an_object_stands_on_the_ground_that_it_finds() -> None:
    lower = dataclasses.replace(make_object(CAR), box_scan=make_object(CAR).box_scan - [0, 0.3, 0, 0, 0, 0, 0])
    placement = place(lower, 0.1, scene())
    assert placement is not None and placement.box_cam[1] == pytest.approx(1.65)
    # A ramp that the plane misses by 20 cm.
    x, z = np.meshgrid(np.arange(-8, 8, 0.3), np.arange(8, 24, 0.3))
    ramp = np.column_stack([x.ravel(), np.full(x.size, 1.45), z.ravel()])
    placement = place(make_object(CAR), 0.1, scene(ramp))
    assert placement is not None and placement.box_cam[1] == pytest.approx(1.45)
    assert placement.points_cam[:, 1].max() == pytest.approx(1.45, abs=1e-4)


def hits(points_cam: NDArray[np.float64], box_cam: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell which rays from the LIDAR pass through a box before they end: slabs, in the box's frame."""
    corners = corners_cam(box_cam[None])[0]
    origin, axes = corners[2], np.stack([corners[1] - corners[2], corners[3] - corners[2], corners[6] - corners[2]])
    start, ends = (np.linalg.solve(axes.T, (p - origin).T).T for p in (LIDAR[None], points_cam))
    along = ends - start
    with np.errstate(divide="ignore"):
        times = np.sort(np.stack([-start / along, (1.0 - start) / along]), axis=0)
    enter, leave = times[0].max(axis=1), times[1].min(axis=1)
    result: NDArray[np.bool_] = (enter < leave) & (enter > 0.0) & (enter < 1.0)
    return result


def test_points_behind_an_object_are_hidden_and_no_others() -> None:
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-20, 20, 60_000), rng.uniform(-1.5, 1.6, 60_000), np.full(60_000, 30.0)])
    placement = place(make_object(CAR), 0.1, scene(points))
    assert placement is not None
    grown = placement.box_cam + [0, 0.15, 0, 0.3, 0.3, 0.3, 0]
    behind, near = (hits(points, box) for box in (placement.box_cam, grown))
    assert np.count_nonzero(behind) > 1000
    is_behind = np.isin(np.arange(len(points)), placement.behind)
    assert is_behind[behind].all(), "no ray goes through the object"
    assert not is_behind[~near].any(), "no ray that passes beside it is lost"


def test_what_is_nearer_hides_the_object() -> None:
    item = make_object(CAR)
    assert place(item, 0.0, scene(wall(5.0, (-3, -1.5), (3, 1.5)))) is None, "behind a wall"
    assert place(item, 0.0, scene(wall(30.0, (-9, -1.5), (9, 1.5)))) is not None, "before it"
    # A thin pole at 8 m takes out some points, and those alone that are behind it.
    pole, back = wall(8.0, (0.3, -1.0), (0.35, 1.6)), wall(30.0, (-9, -3), (9, 1.6))
    placement = place(item, 0.0, scene(np.concatenate([pole, back])))
    assert placement is not None and 0.0 < placement.hidden < 0.1
    assert placement.behind.min() >= len(pole)
    kept = {tuple(point) for point in placement.points_cam[:, :3].round(4)}
    whole = item.points_scan[:, :3].astype(np.float64) + LIDAR
    hidden = np.array([tuple(point) not in kept for point in whole.round(4)])
    slopes = (whole - LIDAR)[:, 0] / (whole - LIDAR)[:, 2]
    low, high = ((x - LIDAR[0]) / (8.0 - LIDAR[2]) for x in (0.3, 0.35))
    assert hidden.any() and (slopes[hidden] > low - 0.004).all() and (slopes[hidden] < high + 0.004).all()


def test_objects_need_room() -> None:
    item = make_object(CAR)
    assert place(item, 0.0, scene()) is not None
    # Another object there; a hedge there; outside the image; hiding another object.
    assert place(item, 0.0, scene(boxes_cam=np.array([[2.0, 1.65, 15.5, 4.0, 1.7, 1.5, 0.0]]))) is None
    assert place(item, 0.0, scene(wall(15.0, (-0.5, 0.5), (0.5, 1.0)))) is None
    assert place(item, 0.8, scene()) is None
    other = np.array([0.0, 1.65, 25.0, 4.0, 1.7, 1.5, 0.4])
    assert place(item, 0.0, scene(on_faces(other), other[None])) is None
    beside = np.array([4.0, 1.65, 25.0, 4.0, 1.7, 1.5, 0.4])
    placement = place(item, 0.0, scene(on_faces(beside), beside[None]))
    assert placement is not None and 0.0 < placement.covered[0] < 0.5


def drawn(calib: Calibration, nearer: NDArray[np.float64] = NO_BOXES, width: int = 620) -> NDArray[np.bool_]:
    item, image = make_object(CAR), np.zeros((190, width, 3), np.uint8)
    paste_crop(image, item.crop, item.corners_scan + LIDAR, calib, nearer)
    return np.asarray((image > 127).all(axis=2))


def test_a_crop_has_the_size_that_the_camera_gives_it() -> None:
    found = drawn(CALIB)
    focal_px = 360.0
    rows, columns = found.any(axis=1).sum(), found.any(axis=0).sum()
    assert (columns, rows) == pytest.approx((focal_px * 4.0 / 15.0, focal_px * 1.5 / 15.0), abs=1.5)
    names = ("P0", "P1", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo")
    half = CALIB.P2 * np.array([[0.5], [0.5], [1.0]])
    smaller = drawn(Calibration(P2=half, **{name: getattr(CALIB, name) for name in names}))
    assert smaller.any(axis=0).sum() == pytest.approx(columns / 2, abs=1.5)


def test_nearer_objects_stay_in_front_of_a_crop() -> None:
    nearer = np.array([[1.0, 1.65, 8.0, 1.0, 1.0, 1.8, 0.3]])
    left, top, right, bottom = project_boxes(nearer, CALIB)[0]
    alone, behind = drawn(CALIB), drawn(CALIB, nearer)
    hidden = np.argwhere(alone & ~behind)
    assert len(hidden) > 200
    assert hidden.min(axis=0)[1] >= left - 1 and hidden.max(axis=0)[1] <= right + 1
    middle = round((left + right) / 2)
    assert not behind[:, middle].any() and alone[:, middle].any()


@pytest.fixture
def bank(tmp_path: Path) -> ObjectBank:
    boxes = [CAR, (0.0, 1.65, 9.0, 3.6, 1.6, 1.4, 1.5), (0.0, 1.65, 25.0, 4.2, 1.7, 1.6, -2.0)]
    people = [(0.0, 1.65, z, 0.8, 0.6, 1.8, 0.0) for z in (7.0, 18.0)]
    objects = [make_object(box) for box in boxes] + [make_object(box, "Pedestrian") for box in people]
    write_bank(tmp_path / "bank", objects)
    return ObjectBank(tmp_path / "bank")


def augmented(seed: int, count: int = 8) -> Augmentation:
    return Augmentation(seed=(seed,), settings=AugmentationConfig(pasted_objects=count))


def test_pasted_frames_are_what_labels_say(bank: ObjectBank) -> None:
    frame = make_frame()
    counts = []
    for seed in range(12):
        pasted = paste_objects(frame, PLANE, bank, ("Car", "Pedestrian"), augmented(seed))
        new = pasted.labels[len(frame.labels) :]
        counts.append(len(new))
        assert [label.box_cam.tolist() for label in pasted.labels[:4]] == [b.box_cam.tolist() for b in frame.labels]
        boxes = np.stack([label.box_cam for label in pasted.labels if not label.is_dont_care])
        assert np.triu(box_iou_bev(boxes, boxes), 1).max() == 0.0
        points_cam = pasted.calib.points_cam_from_velo(pasted.points_velo)
        for label in new:
            left, top, right, bottom = label.bbox
            assert left >= 0 and top >= 0 and right <= 619 and bottom <= 189 and label.truncated == 0.0
            assert label.alpha == pytest.approx(float(alpha_from_boxes(label.box_cam[None])[0]))
            inside = points_cam[points_in_boxes(points_cam, label.box_cam[None], 1e-3)[:, 0]]
            assert len(inside) > 100
            # No point is left on a ray that the middle of the object stops, but those of objects before it.
            core = label.box_cam * [1, 1, 1, 0.8, 0.8, 0.8, 1]
            through = points_cam[hits(points_cam, core)]
            assert points_in_boxes(through, boxes, 1e-3).any(axis=1).all()
    assert min(counts) == 0 < 3 < max(counts) <= 8


def test_pasting_follows_from_its_seed(bank: ObjectBank) -> None:
    frame = make_frame()
    first, again, other = (paste_objects(frame, PLANE, bank, ("Car",), augmented(s)) for s in (1, 1, 2))
    assert first.labels == again.labels and np.array_equal(first.image, again.image)
    assert np.array_equal(first.points_velo, again.points_velo)
    assert first.labels != other.labels and len(first.labels) > len(frame.labels)
    assert {label.type for label in first.labels[4:]} == {"Car"}
    assert paste_objects(frame, PLANE, bank, ("Cyclist",), augmented(1)) is frame
    assert paste_objects(frame, PLANE, bank, ("Car",), Augmentation()) is frame


def test_points_that_are_far_from_the_image_stay(bank: ObjectBank) -> None:
    frame = make_frame()
    back = frame.points_velo * np.array([-1, 1, 1, 1], np.float32)
    both = dataclasses.replace(frame, points_velo=np.concatenate([frame.points_velo, back]))
    pasted = paste_objects(both, PLANE, bank, ("Car",), augmented(1))
    assert len(pasted.labels) > len(frame.labels)
    rear = {tuple(p) for p in back[back[:, 0] < -1]}
    assert rear <= {tuple(p) for p in pasted.points_velo}


def with_pasting(config: Config, count: int) -> Config:
    return dataclasses.replace(config, augmentation=AugmentationConfig(pasted_objects=count))


def test_samples_get_the_objects_that_their_frames_got(bank: ObjectBank, tmp_path: Path) -> None:
    config = with_pasting(small_config(tmp_path), 8)
    frame = make_frame()
    sample = sample_from_frame(frame, "000000", config, augmented(1), bank=bank)
    pasted = paste_objects(frame, PLANE, bank, config.class_names, augmented(1))
    assert len(sample.boxes_cam) == len(pasted.labels) - 1 > 3
    mirrored = sample_from_frame(
        frame, "000000", config, dataclasses.replace(augmented(1), is_mirrored=True), bank=bank
    )
    np.testing.assert_allclose(mirrored.boxes_cam[:, 0], -sample.boxes_cam[:, 0])


def test_a_training_with_a_bank_goes_on_as_if_it_had_not_stopped(bank: ObjectBank, tmp_path: Path) -> None:
    config = with_pasting(small_config(tmp_path), 3)
    data = write_set(tmp_path / "set")
    short_run(config, data, tmp_path / "unbroken", 5, bank=bank.root)
    out = tmp_path / "run"
    short_run(config, data, out, 5, bank=bank.root, workers=2, should_stop=StopAfter(2))
    short_run(config, data, out, 5, bank=bank.root, resume=True)
    assert_same_training(out, tmp_path / "unbroken")
    write_bank(tmp_path / "other", [bank[0]])
    with pytest.raises(CadetError, match="its training has a checksum of its bank's objects = "):
        short_run(config, data, out, 6, bank=tmp_path / "other", resume=True)


def test_a_bank_and_its_switch_go_together(bank: ObjectBank, tmp_path: Path) -> None:
    config, data = small_config(tmp_path), write_set(tmp_path / "set")
    with pytest.raises(CadetError, match=r"augmentation\.pasted_objects is 3, which needs --bank"):
        TrainingData(data, None, with_pasting(config, 3), 0)
    with pytest.raises(CadetError, match=r"augmentation\.pasted_objects is 0: say in the configuration how many"):
        TrainingData(data, None, config, 0, bank)
    write_bank(tmp_path / "people", [make_object(CAR, "Cyclist")])
    with pytest.raises(CadetError, match="none of its 1 objects is a Car or Pedestrian"):
        TrainingData(data, None, with_pasting(config, 3), 0, ObjectBank(tmp_path / "people"))


def test_a_damaged_bank_comes_back_as_an_error(bank: ObjectBank, tmp_path: Path) -> None:
    data = TrainingData(write_set(tmp_path / "set"), None, with_pasting(small_config(tmp_path), 8), 0, bank)
    for number in range(len(bank)):
        (bank.root / "objects" / f"{number:06d}.png").write_bytes(b"")
    errors: list[Any] = [item for index in range(8) if isinstance(item := data[index], CadetError)]
    assert errors and "png" in str(errors[0])
