"""Detection: what is written, what is left out, and inputs that hold nothing."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from avod import Detector
from avod.config import Config
from avod.device import resolve_device
from avod.evaluate import Scored, best, score
from avod.geometry.encoding import boxes_4c_from_anchors, boxes_4c_from_boxes
from avod.model.avod.decoding import decode
from avod.model.avod.outputs import FrameOutputs
from avod.model.boxes import Boxes
from avod.results import labels_from_boxes
from avod.train.step import new_network
from cadet.errors import CadetError, NonFiniteError, ShapeError
from cadet.evaluation import evaluate
from cadet.formats.kitti import Calibration, Label
from synthetic import IMAGE_SIZE, make_calib, make_frame, make_labels

CONFIG = Config.named(Path(__file__).parents[1] / "support" / "detector" / "overfit.toml")
PLANE = torch.tensor([0.0, -1.0, 0.0, 1.65])


@pytest.fixture(scope="module")
def detector() -> Detector:
    return Detector(new_network(CONFIG, 0))


def test_decoding_inverts_the_targets_and_keeps_the_best() -> None:
    truth = torch.tensor([[1.0, 1.6, 20.0, 4.0, 1.8, 1.5, 2.9], [8.0, 1.7, 30.0, 0.8, 0.7, 1.8, -0.4]])
    proposals = torch.tensor(
        [[1.1, 1.6, 20.0, 4.1, 1.4, 1.9], [1.2, 1.6, 20.1, 4.0, 1.5, 1.9], [8.0, 1.6, 30.0, 0.8, 1.7, 0.6]]
    )
    goal = boxes_4c_from_boxes(truth, PLANE)[[0, 0, 1]]
    vectors = torch.stack([truth[:, 6].cos(), truth[:, 6].sin()], dim=1)[[0, 0, 1]]
    logits = torch.tensor([[0.0, 2.0, -1.0], [0.0, 3.0, 0.0], [0.0, 0.0, 1.0]])
    outputs = FrameOutputs(
        torch.zeros((0, 2)),
        torch.zeros((0, 6)),
        proposals,
        logits,
        goal - boxes_4c_from_anchors(proposals, PLANE),
        vectors,
    )
    boxes = decode(outputs, PLANE, CONFIG.detection)
    torch.testing.assert_close(boxes.boxes_cam, truth, atol=1e-4, rtol=1e-4)
    assert boxes.classes.tolist() == [1, 2]
    odds = [math.exp(3.0) / (math.exp(3.0) + 2.0), math.exp(1.0) / (math.exp(1.0) + 2.0)]
    assert boxes.scores.tolist() == pytest.approx(odds, rel=1e-5)
    one = dataclasses.replace(CONFIG.detection, max_detections=1)
    assert len(decode(outputs, PLANE, one).scores) == 1


def test_what_is_written_and_what_is_left_out() -> None:
    calib = make_calib()
    truths = make_labels(calib)[:3]
    rows = [label.box_cam for label in truths]
    rows.append(np.array([0.0, 1.65, -20.0, 4.0, 1.7, 1.5, 0.0]))  # behind the camera
    rows.append(np.array([60.0, 1.65, 20.0, 4.0, 1.7, 1.5, 0.0]))  # beside the image
    rows.append(np.array([0.0, 1.65, 2.3, 4.0, 1.7, 1.5, 1.5]))  # too large in the image
    rows.append(truths[0].box_cam)  # too unsure
    boxes = Boxes(
        torch.from_numpy(np.stack(rows)),
        torch.tensor([0.9, 0.8, 0.7, 0.9, 0.9, 0.9, 0.05]),
        torch.tensor([1, 1, 2, 1, 1, 1, 1]),
    )
    avods = dataclasses.replace(CONFIG, detection=dataclasses.replace(CONFIG.detection, max_image_fraction=0.8))
    found = labels_from_boxes(boxes, calib, IMAGE_SIZE, avods)
    assert [label.type for label in found] == ["Car", "Car", "Pedestrian"]
    for label, truth in zip(found, truths, strict=True):
        np.testing.assert_allclose(label.box_cam, truth.box_cam)
        assert label.bbox == pytest.approx(truth.bbox)
        assert label.alpha == pytest.approx(truth.alpha)
    assert [label.score for label in found] == pytest.approx([0.9, 0.8, 0.7])
    assert Label.from_line(found[0].to_line()).score == found[0].score
    assert CONFIG.detection.max_image_fraction == 0.0
    *same, wide = labels_from_boxes(boxes, calib, IMAGE_SIZE, CONFIG)
    assert tuple(same) == found
    assert wide.box_cam.tolist() == pytest.approx(rows[5].tolist())
    assert wide.bbox[0] == 0.0 and wide.bbox[2] == IMAGE_SIZE[0] - 1


def test_a_frame_without_points_has_no_detections(detector: Detector) -> None:
    frame = make_frame()
    assert detector.detect_frame(dataclasses.replace(frame, points_velo=np.zeros((0, 4), np.float32))) == ()
    sky = np.tile(np.array([[20.0, 0.0, 30.0, 0.5]], np.float32), (9, 1))
    assert detector.detect_frame(dataclasses.replace(frame, points_velo=sky)) == ()


def scaled(calib: Calibration, x: float, y: float) -> Calibration:
    """Return the calibration of images that are scaled, each pixel's top left corner staying the grid's origin."""
    return dataclasses.replace(calib, P2=np.diag([x, y, 1.0]) @ calib.P2)


@pytest.mark.parametrize(("x", "y"), [(2, 2), (1, 3), (0.5, 0.5), (0.1, 0.2)])
def test_images_of_any_size_give_the_same_boxes_at_their_own_scale(detector: Detector, x: float, y: float) -> None:
    """An image of one color has no resolution: only the size that it is said to have can change what is found."""
    frame = make_frame()
    width, height = IMAGE_SIZE
    calib = make_calib()

    def detect(x: float, y: float) -> tuple[Label, ...]:
        image = np.full((round(height * y), round(width * x), 3), 90, np.uint8)
        return detector.detect_frame(dataclasses.replace(frame, image=image, calib=scaled(calib, x, y)))

    whole, found = detect(1, 1), detect(x, y)
    assert len(found) == len(whole) > 3
    for label, expected in zip(found, whole, strict=True):
        assert label.type == expected.type
        assert label.score == pytest.approx(expected.score, abs=1e-4)
        np.testing.assert_allclose(label.box_cam, expected.box_cam, atol=1e-3)
        # Boxes end at the middles of the last pixels, which are other ones.
        limits = np.array([width * x - 1, height * y - 1] * 2)
        inside = np.clip(np.array(expected.bbox) * [x, y, x, y], 0.0, limits)
        assert np.abs(inside - label.bbox).max() <= max(x, y, 1.0), (label.bbox, expected.bbox)


def test_a_part_of_an_image_is_a_small_image(detector: Detector) -> None:
    frame = make_frame()
    small = np.full((120, 400, 3), 90, np.uint8)
    found = detector.detect_frame(dataclasses.replace(frame, image=small))
    assert found
    boxes = np.array([label.bbox for label in found])
    assert (boxes[:, :2] >= 0).all() and (boxes[:, 2] <= 399).all() and (boxes[:, 3] <= 119).all()
    # Cut off by the image's own border.
    assert boxes[:, 3].max() == 119


INTRINSICS = np.array([[360.0, 0.0, 309.5], [0.0, 360.0, 90.0], [0.0, 0.0, 1.0]])
POSE = np.vstack([make_calib().cam_from_velo[:3], [0.0, 0.0, 0.0, 1.0]])


def test_a_cloud_and_an_image_are_a_frame(detector: Detector) -> None:
    image = np.full((IMAGE_SIZE[1], IMAGE_SIZE[0], 3), 90, np.uint8)
    frame = dataclasses.replace(make_frame(), image=image, calib=Calibration.from_pinhole(INTRINSICS, POSE))
    expected = detector.detect_frame(frame)
    assert len(expected) > 3
    assert detector.detect(frame.points_velo, frame.image, INTRINSICS, POSE, plane=frame.plane) == expected
    assert detector(frame.image, frame.points_velo, frame.calib, frame.plane) == detector.detect_frame(frame)
    # Intensity counts for nothing, nor does the precision of the numbers.
    points = frame.points_velo[:, :3].astype(np.float64)
    assert detector.detect(points, frame.image, INTRINSICS.tolist(), POSE[:3].tolist(), plane=frame.plane) == expected
    estimated = detector.detect_frame(dataclasses.replace(frame, plane=None))
    assert detector.detect(points, frame.image, INTRINSICS, POSE) == estimated


def test_frames_in_one_pass_are_detected_as_one_by_one(detector: Detector) -> None:
    image = np.full((IMAGE_SIZE[1], IMAGE_SIZE[0], 3), 90, np.uint8)
    frames = [dataclasses.replace(make_frame(seed=seed), image=image) for seed in range(3)]
    frames[1] = dataclasses.replace(frames[1], points_velo=np.zeros((0, 4), np.float32))
    found = detector.detect_frames(frames)
    assert [len(labels) > 3 for labels in found] == [True, False, True]
    for labels, frame in zip(found, frames, strict=True):
        alone = detector.detect_frame(frame)
        assert [label.type for label in labels] == [label.type for label in alone]
        for label, other in zip(labels, alone, strict=True):
            assert label.score == pytest.approx(other.score, abs=1e-4)
            np.testing.assert_allclose(label.box_cam, other.box_cam, atol=1e-3)
    assert found[0] != found[2]
    assert detector.detect_frames([]) == []


def test_the_gpu_that_is_there_is_taken(monkeypatch: pytest.MonkeyPatch, detector: Detector) -> None:
    assert detector.device == resolve_device("cuda" if torch.cuda.is_available() else "cpu")
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch, "zeros", lambda *size, device: torch.ones(*size))
    assert resolve_device(None) == torch.device("cuda")


def test_bad_input_is_one_clear_error(detector: Detector) -> None:
    frame = make_frame()
    nan = np.full((5, 4), np.nan, np.float32)
    with pytest.raises(NonFiniteError, match=r"^points_velo: not finite at \[0, 0\]$"):
        detector.detect(nan, frame.image, INTRINSICS, POSE)
    with pytest.raises(ShapeError, match=r"^points_velo: expected \(N, 3\) or wider, got \(5, 2\)$"):
        detector.detect(np.zeros((5, 2)), frame.image, INTRINSICS, POSE)
    with pytest.raises(CadetError, match=r"^cam_from_velo: expected a rotation"):
        detector.detect(frame.points_velo, frame.image, INTRINSICS, np.diag([2.0, 1.0, 1.0, 1.0]))
    with pytest.raises(CadetError, match="expected at least 2 x 2 pixels"):
        detector.detect_frame(dataclasses.replace(frame, image=frame.image[:1]))


def test_numbers_beyond_single_precision_are_refused(detector: Detector) -> None:
    frame = make_frame()
    with pytest.raises(CadetError, match=r"^plane: expected numbers that single precision holds, got 1e\+300$"):
        detector.detect_frame(dataclasses.replace(frame, plane=np.array([0.0, -1.0, 0.0, 1e300])))
    far = dataclasses.replace(frame.calib, P2=frame.calib.P2 + np.array([[0.0, 0.0, 0.0, 1e300], [0.0] * 4, [0.0] * 4]))
    with pytest.raises(CadetError, match=r"^projection: expected numbers"):
        detector.detect_frame(dataclasses.replace(frame, calib=far))


def test_detection_is_the_same_twice(detector: Detector) -> None:
    frame = make_frame()
    first, second = (detector.detect_frame(frame) for _ in range(2))
    assert first == second


def test_checkpoints_are_scored_by_the_mean_over_classes_of_which_none_may_be_missing() -> None:
    calib = make_calib()
    truths = {"000000": make_labels(calib)}
    found = {"000000": tuple(dataclasses.replace(label, score=0.9) for label in make_labels(calib)[:1])}
    report = evaluate(truths, found, classes=("Car", "Pedestrian"), levels="large_small")
    curve = report.curves["Car"]["3d"]["Small"]
    assert score(report, ("Car", "Pedestrian")) == pytest.approx(curve.r40 / 2)
    scored = [Scored(Path(str(k)), report, value) for k, value in enumerate((3.0, 7.0, 7.0, 1.0))]
    assert best(scored).path == Path("2")


def overlapping(logits: list[list[float]]) -> FrameOutputs:
    """Return outputs of one box for each row, all at the same place."""
    count = len(logits)
    proposals = torch.tensor([[1.0, 1.6, 20.0, 4.0, 1.5, 1.8]]).repeat(count, 1)
    return FrameOutputs(
        torch.zeros((0, 2)),
        torch.zeros((0, 6)),
        proposals,
        torch.tensor(logits),
        torch.zeros((count, 10)),
        torch.tensor([[1.0, 0.0]]).repeat(count, 1),
    )


def test_boxes_of_other_classes_stay_where_each_class_is_suppressed_on_its_own() -> None:
    # A car, a pedestrian at the same place, and a second, less sure car.
    outputs = overlapping([[0.0, 3.0, -1.0], [0.0, -1.0, 2.0], [0.0, 2.5, 0.0]])
    together = decode(outputs, PLANE, CONFIG.detection)
    assert together.classes.tolist() == [1]
    apart = decode(outputs, PLANE, dataclasses.replace(CONFIG.detection, suppression="class"))
    assert apart.classes.tolist() == [1, 2]
    assert apart.scores[0] == together.scores[0]
    one = dataclasses.replace(CONFIG.detection, suppression="class", max_detections=1)
    assert decode(outputs, PLANE, one).classes.tolist() == [1]
    assert Config.named("all_default").detection.suppression == "class"
    assert Config.named("car_default").detection.suppression == Config.named("people_default").detection.suppression


def test_detections_come_best_score_first_though_ranked_by_logits() -> None:
    # The first has the greater logit, and the lower score, since it looks much like background too.
    outputs = overlapping([[4.9, 5.0, -5.0], [-5.0, 3.0, -5.0], [0.0, 1.0, -5.0]])
    outputs.proposals[:, 0] += torch.tensor([0.0, 10.0, -10.0])
    for suppression in ("all", "class"):
        boxes = decode(outputs, PLANE, dataclasses.replace(CONFIG.detection, suppression=suppression))
        assert boxes.scores.tolist() == sorted(boxes.scores.tolist(), reverse=True)
        assert boxes.boxes_cam[:, 0].tolist() == pytest.approx([11.0, -9.0, 1.0], abs=1e-4)


def test_settings_of_detection_can_be_changed_for_a_run() -> None:
    network = new_network(CONFIG, 0)
    detector = Detector(network)
    detector.configure({"rpn": {"proposals": 7}, "detection": {"min_score": 0.0, "nms_iou": 1.0}})
    assert network.config == Detector(network).config == CONFIG
    frame = make_frame()
    assert len(detector.detect_frame(frame)) <= 7
    assert detector.config.rpn == dataclasses.replace(CONFIG.rpn, proposals=7)
    detection = dataclasses.replace(CONFIG.detection, min_score=0.0, nms_iou=1.0)
    assert detector.config.detection == detection and detector.config.training == CONFIG.training
    detector.configure({})
    assert detector.config.detection == detection
    with pytest.raises(CadetError, match=r"DetectionConfig\.nms_iou: expected "):
        detector.configure({"detection": {"nms_iou": 1.5}})
    with pytest.raises(CadetError, match=r"^rpn\.hidden: expected \d+, with which the weights were trained, got 7"):
        detector.configure({"rpn": {"hidden": 7}})
