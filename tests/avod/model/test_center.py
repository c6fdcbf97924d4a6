"""The center detector: targets and decoding in closed form, and a frame learned by heart."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from avod import Detector
from avod.config import Config
from avod.data.dataset import sample_from_frame
from avod.data.sample import Sample
from avod.evaluate import without
from avod.model.boxes import Boxes
from avod.model.center.network import CenterNetwork, CenterOutputs, mark_loss
from avod.model.center.targets import boxes_from_cells, center_targets, output_size
from avod.train.step import learning_rate, make_optimizer, new_network, train_mode, training_step
from cadet.errors import CadetError
from cadet.evaluation import box_iou_3d
from detector.runs import assert_same_training, compared, short_run, write_set
from synthetic import make_frame

CONFIG = Config.named(Path(__file__).parents[2] / "support" / "detector" / "center.toml")


@pytest.fixture(scope="module")
def sample() -> Sample:
    return sample_from_frame(make_frame(), "000003", CONFIG)


def test_a_sample_holds_nothing_that_this_network_does_not_look_at(sample: Sample) -> None:
    assert sample.image.numel() == 0 and len(sample.anchors) == 0 and len(sample.points_cam) > 1000


def test_decoding_inverts_the_targets(sample: Sample) -> None:
    targets = center_targets(sample, CONFIG)
    assert len(targets.cells) == len(sample.boxes_cam) == 3
    found = boxes_from_cells(targets.cells, targets.boxes, sample.classes - 1, sample.plane, CONFIG)
    torch.testing.assert_close(found, sample.boxes_cam, atol=1e-4, rtol=0)


def test_marks_are_one_at_centers_and_fade_by_the_objects_width(sample: Sample) -> None:
    marks = center_targets(sample, CONFIG).marks
    assert marks.shape == (2, *output_size(CONFIG))
    assert [(marks[kind] == 1.0).sum().item() for kind in (0, 1)] == [2, 1]
    cell_m = 2 * CONFIG.bev.cell_m
    for box, kind in zip(sample.boxes_cam.tolist(), (sample.classes - 1).tolist(), strict=True):
        row, column = int((25.6 - box[2]) / cell_m), int((box[0] + 12.8) / cell_m)
        spread = max(0.8, 0.27 * box[4] / cell_m)
        assert marks[kind, row, column] == 1.0
        assert marks[kind, row - 1, column].item() == pytest.approx(math.exp(-0.5 / spread**2), rel=1e-5)
    assert marks.amin() == 0.0


def test_objects_outside_the_maps_have_no_mark(sample: Sample) -> None:
    far = sample.boxes_cam.clone()
    far[:, 2] += 100.0
    targets = center_targets(Sample(**{**vars(sample), "boxes_cam": far}), CONFIG)
    assert len(targets.cells) == 0 and targets.boxes.shape == (0, 10) and not targets.marks.any()


def test_the_mark_loss_is_the_published_one() -> None:
    generator = torch.Generator().manual_seed(0)
    logits = torch.randn((2, 3, 4), generator=generator)
    marks = torch.rand((2, 3, 4), generator=generator)
    marks[0, 1, 2] = marks[1, 0, 0] = 1.0
    expected = 0.0
    is_ignored = torch.zeros((3, 4), dtype=torch.bool)
    is_ignored[1] = True
    values = (logits, marks, is_ignored.expand(2, 3, 4))
    for logit, mark, ignored in zip(*(value.flatten().tolist() for value in values), strict=True):
        p = 1.0 / (1.0 + math.exp(-logit))
        loss = (1 - p) ** 2 * math.log(p) if mark == 1.0 else (1 - mark) ** 4 * p**2 * math.log(1 - p)
        expected -= 0.0 if ignored and mark != 1.0 else loss
    assert mark_loss(logits, marks, is_ignored).item() == pytest.approx(expected, rel=1e-5)


def test_ignored_objects_are_neither_marked_nor_background() -> None:
    frame = make_frame()
    labels = tuple(dataclasses.replace(label, type="Van") if k == 0 else label for k, label in enumerate(frame.labels))
    ignoring = sample_from_frame(dataclasses.replace(frame, labels=labels), "000003", CONFIG)
    assert len(ignoring.boxes_cam) == 2 and len(ignoring.ignored_cam) == 1
    is_ignored = center_targets(ignoring, CONFIG).is_ignored
    cell_m, box = 2 * CONFIG.bev.cell_m, frame.labels[0].box_cam
    row, column = int((25.6 - box[2]) / cell_m), int((box[0] + 12.8) / cell_m)
    assert is_ignored[row, column] and is_ignored[row - 4, column] and not is_ignored[row - 8, column]
    assert is_ignored.sum().item() == pytest.approx(math.pi * (4.1 / 2 / cell_m) ** 2, rel=0.15)
    network = new_network(CONFIG, 0)
    assert network.refinement is not None
    found = torch.stack([ignoring.ignored_cam[0], ignoring.boxes_cam[0]])
    outputs = network.refinement.learned(ignoring, found, torch.Generator())
    assert outputs.has_object.all() and len(outputs.has_object) == 2 * CONFIG.refinement.copies + 1


def test_a_last_stage_that_learns_alone_learns_the_same_without_the_network_before_it(sample: Sample) -> None:
    def losses(learns: str) -> dict[str, torch.Tensor]:
        training = dataclasses.replace(CONFIG.training, learns=learns)
        refinement = dataclasses.replace(CONFIG.refinement, found_boxes=0)
        network = new_network(dataclasses.replace(CONFIG, training=training, refinement=refinement), 0)
        train_mode(network, training)
        if learns:
            network.extract = None  # type: ignore[method-assign, assignment]
        generator = torch.Generator().manual_seed(1)
        (outputs,) = network([sample], generator)
        return network.losses(outputs, sample, generator)

    alone, every = losses("refinement."), losses("")
    assert list(alone) == list(every) and alone["refinement"] == every["refinement"] == alone["total"] > 0.0
    assert alone["mark"] == alone["box"] == 0.0


def test_what_is_found_as_two_classes_is_one_object_of_the_class_of_its_length(
    sample: Sample, monkeypatch: pytest.MonkeyPatch
) -> None:
    detection = dataclasses.replace(CONFIG.detection, suppression="class", classes_by_length=True)
    by_length = dataclasses.replace(CONFIG, detection=detection)
    network = new_network(by_length, 0).eval()
    true_boxes, num = sample.boxes_cam, len(sample.boxes_cam)
    twice = Boxes(true_boxes.repeat(2, 1), torch.ones(2 * num), torch.tensor([1, 2]).repeat_interleave(num))
    monkeypatch.setattr(network, "decode", lambda *_: twice)

    def classes_found(config: Config) -> list[int]:
        boxes = network.boxes(None, sample, config)
        assert torch.cdist(boxes.boxes_cam[:, [0, 2]], true_boxes[:, [0, 2]]).amin(dim=1).max() < 0.3
        return sorted(boxes.classes.tolist())

    either_way = dataclasses.replace(by_length, detection=dataclasses.replace(detection, classes_by_length=False))
    assert classes_found(by_length) == sorted(sample.classes.tolist()) == [1, 1, 2]
    assert classes_found(either_way) == [1, 1, 1, 2, 2, 2]


def test_perfect_outputs_are_decoded_into_the_true_boxes(sample: Sample) -> None:
    network = CenterNetwork(CONFIG)
    targets = center_targets(sample, CONFIG)
    numbers = torch.zeros((10, *output_size(CONFIG)))
    numbers.flatten(1)[:, targets.cells] = targets.boxes.T
    logits = torch.logit(targets.marks.clamp(1e-3, 0.99))
    boxes = network.decode(CenterOutputs(logits, numbers), sample, CONFIG.detection)
    sure = boxes.scores > 0.9
    assert sorted(boxes.classes[sure].tolist()) == [1, 1, 2]
    overlap = box_iou_3d(boxes.boxes_cam[sure].double().numpy(), sample.boxes_cam.double().numpy())
    assert (overlap.max(axis=0) > 0.999).all()
    # Beside a center marks are high, too, but lower.
    every = network.decode(CenterOutputs(logits, numbers), sample, dataclasses.replace(CONFIG.detection, nms_iou=1.0))
    assert (every.scores > 0.5).sum() == 3


@pytest.mark.timeout(400)  # some 20 s of one core, more where it is shared
def test_one_frame_is_learned_by_heart(sample: Sample) -> None:
    network = new_network(CONFIG, 0).train()
    optimizer = make_optimizer(network, CONFIG.training)
    steps = range(CONFIG.training.steps)
    losses = [training_step(network, optimizer, [sample], CONFIG, step=step, seed=0) for step in steps]
    assert list(losses[0]) == ["mark", "box", "refinement", "total"]
    # Points that are scattered in boxes, not over their surfaces, teach the last stage little.
    assert all(losses[-1][name] < 0.05 * losses[0][name] for name in ("mark", "box"))
    detector = Detector(network)
    found, truths, overlap = compared(detector, make_frame())
    for column, truth in enumerate(truths):
        best = found[int(overlap[:, column].argmax())]
        assert overlap[:, column].max() > 0.6 and best.type == truth.type and (best.score or 0.0) > 0.5
        assert math.cos(best.rotation_y - truth.rotation_y) > 0.9
    empty = make_frame(points_velo=np.zeros((0, 4), np.float32))
    assert all((label.score or 0.0) < 0.5 for label in detector.detect_frame(empty))


def test_a_training_that_was_stopped_goes_on_as_if_it_was_not(tmp_path: Path) -> None:
    data = write_set(tmp_path / "set")
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    short_run(CONFIG, data, whole, 5, seed=3)
    with pytest.raises(KeyboardInterrupt):
        short_run(CONFIG, data, parts, 5, seed=3, on_step=interrupt_after(4))
    short_run(CONFIG, data, parts, 5, resume=True)
    assert_same_training(parts, whole)


def interrupt_after(step: int):  # type: ignore[no-untyped-def]
    def on_step(done: int, losses: object) -> None:
        if done == step:
            raise KeyboardInterrupt

    return on_step


def test_the_cycle_rises_to_the_learning_rate_and_falls_to_nothing() -> None:
    training = CONFIG.training
    rates = [learning_rate(step, training) for step in range(training.steps)]
    assert rates[0] == pytest.approx(0.1 * training.learning_rate)
    assert rates[training.steps // 4] == max(rates) == training.learning_rate
    middle = training.steps // 4 + (training.steps - training.steps // 4) // 2
    assert rates[middle] == pytest.approx(training.learning_rate / 2)
    assert 0.0 < rates[-1] < 1e-3 * training.learning_rate


def test_maps_that_the_strides_do_not_divide_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "odd.toml"
    file.write_text('base = "center_car"\n[bev]\nz_m = [0.0, 50.56]\n')
    with pytest.raises(CadetError, match=r"bev\.z_m: cells: expected a multiple of 8, got 316"):
        Config.named(str(file))


def test_settings_and_ablations_that_mean_nothing_to_this_network_are_refused() -> None:
    detector = Detector(new_network(CONFIG, 0))
    with pytest.raises(CadetError, match=r"^rpn\.proposals: a center detector has no proposals"):
        detector.configure({"rpn": {"proposals": 10}})
    with pytest.raises(CadetError, match="no sensor to leave out"):
        without(detector, has_image=False, has_lidar=True)
    detector.configure({"refinement": {"passes": 0}})
    assert detector.config.refinement.passes == 0
