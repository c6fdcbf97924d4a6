"""Training: schedule, clipping, one frame by heart, exact resuming, and what stops it."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import math
import shutil
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch

from avod.config import Config, TrainingConfig
from avod.data.dataset import sample_from_frame
from avod.data.sample import Sample
from avod.detector import Detector
from avod.model.avod.network import AvodNetwork
from avod.model.avod.outputs import FrameOutputs
from avod.model.network import AnyNetwork
from avod.train import train
from avod.train.checkpoint import read_checkpoint, trained_network
from avod.train.log import read_log
from avod.train.run import Run, with_steps
from avod.train.settings import read_record
from avod.train.step import (
    NonFiniteLossError,
    clip_gradients,
    learning_rate,
    make_optimizer,
    new_network,
    training_step,
)
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti import write_frame
from detector.logs import COLUMNS
from detector.runs import Frozen, compared, weights
from synthetic import make_frame

CONFIG = Config.named(Path(__file__).parents[2] / "support" / "detector" / "overfit.toml")


@pytest.fixture(scope="module")
def sample() -> Sample:
    return sample_from_frame(make_frame(), "000003", CONFIG)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("kitti")
    for index in range(3):
        frame = make_frame()
        write_frame(root, index, dataclasses.replace(frame, image=np.roll(frame.image, 40 * index, axis=1)))
    return root


def test_the_learning_rate_falls_in_stairs() -> None:
    rates = [learning_rate(step, TrainingConfig()) for step in (0, 29_999, 30_000, 119_999)]
    assert rates == pytest.approx([1e-4, 1e-4, 8e-5, 5.12e-5], rel=1e-12)


def test_each_gradient_is_clipped_on_its_own() -> None:
    layer = torch.nn.Linear(2, 1)
    layer.weight.grad, layer.bias.grad = torch.tensor([[3.0, 4.0]]), torch.tensor([0.5])
    clip_gradients(layer, 1.0, 0, ["000000"])
    torch.testing.assert_close(layer.weight.grad, torch.tensor([[0.6, 0.8]]))
    torch.testing.assert_close(layer.bias.grad, torch.tensor([0.5]))


def train_by_heart(config: Config, sample: Sample, steps: int) -> tuple[AnyNetwork, list[float]]:
    network = new_network(config, 0).train()
    optimizer = make_optimizer(network, config.training)
    totals = [
        training_step(network, optimizer, [sample], config, step=step, seed=0)["total"].item() for step in range(steps)
    ]
    return network, totals


@pytest.mark.timeout(400)  # some 30 s of one core, more where it is shared
def test_one_frame_is_learnt_by_heart(sample: Sample) -> None:
    # Long enough for any processor: rounding alone makes another training of it.
    longer = dataclasses.replace(CONFIG.training, steps=320, decay_steps=240)
    network, totals = train_by_heart(dataclasses.replace(CONFIG, training=longer), sample, longer.steps)
    assert np.mean(totals[-20:]) < 0.2 * np.mean(totals[:20])
    found, truths, overlap = compared(Detector(network), make_frame())
    for column, truth in enumerate(truths):
        row = int(overlap[:, column].argmax())
        assert overlap[row, column] >= 0.7, truth
        assert found[row].type == truth.type
        assert math.cos(found[row].rotation_y - truth.rotation_y) > 0.9, "the heading is right, not reversed"
        assert (found[row].score or 0.0) > 0.5
        assert found[row].bbox == pytest.approx(truth.bbox, abs=12.0)
    assert all(x.score is None or x.score <= 0.5 for x, row in zip(found, overlap, strict=True) if row.max() < 0.7)


def test_both_ways_of_the_gradient_and_smaller_arithmetic_learn(sample: Sample) -> None:
    through = dataclasses.replace(CONFIG, second_stage=dataclasses.replace(CONFIG.second_stage, gradient="through"))
    _, totals = train_by_heart(through, sample, 40)
    assert totals[-1] < 0.5 * totals[0]
    network = new_network(CONFIG, 0).train()
    network.precision = torch.bfloat16
    optimizer = make_optimizer(network, CONFIG.training)
    halves = [
        training_step(network, optimizer, [sample], CONFIG, step=step, seed=0)["total"].item() for step in range(40)
    ]
    assert halves[-1] < 0.5 * halves[0]
    assert all(parameter.dtype == torch.float32 for parameter in network.parameters())


@pytest.mark.parametrize(("gradient", "reaches"), [("through", True), ("stopped", False)])
def test_the_second_stages_losses_reach_the_first_only_where_asked(
    sample: Sample, gradient: Any, reaches: bool
) -> None:
    config = dataclasses.replace(CONFIG, second_stage=dataclasses.replace(CONFIG.second_stage, gradient=gradient))
    network = new_network(config, 0).train()
    outputs = network([sample], torch.Generator().manual_seed(0))[0]
    (outputs.class_logits.sum() + outputs.box_offsets.sum()).backward()
    gradients = [parameter.grad for parameter in cast("AvodNetwork", network).anchor_regressor.parameters()]
    assert any(g is not None and bool((g != 0).any()) for g in gradients) == reaches


def all_taken(config: Config) -> Config:
    """Return the configuration with mini-batches that hold everything, so that nothing depends on draws."""
    rpn = dataclasses.replace(config.rpn, batch_size=65_536, dropout_keep=1.0)
    return dataclasses.replace(config, rpn=rpn, second_stage=dataclasses.replace(config.second_stage, batch_size=4096))


def test_several_frames_a_step_give_the_mean_of_their_losses_and_gradients(sample: Sample) -> None:
    config = all_taken(CONFIG)
    torch.manual_seed(0)
    network = Frozen(config).train()
    other = sample_from_frame(make_frame(labels=make_frame().labels[:1]), "000004", config)
    weights = {name: tensor.clone() for name, tensor in network.state_dict().items()}

    def step(samples: list[Sample]) -> tuple[dict[str, float], dict[str, torch.Tensor]]:
        network.load_state_dict(weights)
        training = dataclasses.replace(config, training=dataclasses.replace(config.training, max_gradient_norm=1e9))
        losses = training_step(network, make_optimizer(network, config.training), samples, training, step=0, seed=0)
        gradients = {name: p.grad.clone() for name, p in network.named_parameters() if p.grad is not None}
        return {name: value.item() for name, value in losses.items()}, gradients

    (first, of_first), (second, of_second), (both, of_both) = (
        step(samples) for samples in ([sample], [other], [sample, other])
    )
    assert abs(first["total"] - second["total"]) > 0.1 * first["total"], "two frames that can be told apart"
    assert set(both) == {"objectness", "anchor", "classification", "box", "orientation", "total"}
    for name, value in both.items():
        assert value == pytest.approx((first[name] + second[name]) / 2, rel=1e-4), name
    assert both["total"] == pytest.approx(sum(value for name, value in both.items() if name != "total"), rel=1e-5)
    assert len(of_both) == len(dict(network.named_parameters()))
    for name, gradient in of_both.items():
        mean = (of_first[name] + of_second[name]) / 2
        assert (gradient - mean).norm() <= 1e-3 * mean.norm() + 1e-6, name


def test_true_boxes_join_the_proposals_in_the_first_steps_alone(sample: Sample) -> None:
    seen: list[tuple[int, int]] = []

    class Counting(AvodNetwork):
        def forward(self, *args: Any, **kwargs: Any) -> list[FrameOutputs]:
            outputs = super().forward(*args, **kwargs)
            targets = outputs[0].targets
            assert targets is not None
            seen.append((len(targets.labels), int((targets.labels > 0).sum())))
            return outputs

    second = dataclasses.replace(CONFIG.second_stage, truth_proposals=6, truth_steps=2)
    config = dataclasses.replace(CONFIG, second_stage=second)
    torch.manual_seed(0)
    network = Counting(config).train()
    optimizer = make_optimizer(network, config.training)
    for step in range(4):
        training_step(network, optimizer, [sample], config, step=step, seed=0)
    # An untrained first stage finds next to nothing; of six copies of each object most overlap it enough.
    num_objects = len(sample.boxes_cam)
    assert all(positive >= 3 * num_objects for _, positive in seen[:2]), seen
    assert all(positive < 3 * num_objects for _, positive in seen[2:]), seen


def test_a_loss_that_is_no_number_stops_training_and_names_the_frame(sample: Sample) -> None:
    network = new_network(CONFIG, 0).train()
    optimizer = make_optimizer(network, CONFIG.training)
    with torch.no_grad():
        cast("torch.nn.Linear", cast("AvodNetwork", network).anchor_regressor.outputs[0]).bias[3] = math.nan
    with pytest.raises(NonFiniteLossError, match=r"^step 5: the anchor loss of frame 000003 is nan$"):
        training_step(network, optimizer, [sample], CONFIG, step=5, seed=0)


def test_a_gradient_that_is_no_number_is_named() -> None:
    layer = torch.nn.Linear(2, 1)
    layer.weight.grad = torch.tensor([[math.nan, 0.0]])
    with pytest.raises(NonFiniteLossError, match="step 7: the gradient of weight is not finite on frame 000001"):
        clip_gradients(layer, 1.0, 7, ["000001"])


def run(dataset: Path, out: Path, steps: int, **changes: Any) -> Path:
    training = dataclasses.replace(CONFIG.training, flip=True, pca_jitter=True, checkpoint_steps=3)
    second = dataclasses.replace(CONFIG.second_stage, dropout_keep=0.5)
    config = with_steps(dataclasses.replace(CONFIG, training=training, second_stage=second), steps)
    return train(config, Run(data=dataset, out=out, split=None, **changes))


def test_a_device_is_a_name_or_what_pytorch_calls_one(dataset: Path, tmp_path: Path) -> None:
    named, given = (run(dataset, tmp_path / str(n), 1, device=d) for n, d in enumerate(("cpu", torch.device("cpu"))))
    assert (tmp_path / "0" / "run.json").read_text() == (tmp_path / "1" / "run.json").read_text()
    assert (named / "model.safetensors").read_bytes() == (given / "model.safetensors").read_bytes()
    with pytest.raises(CadetError, match=r"^device: 'cuda:99' cannot be used: "):
        run(dataset, tmp_path / "none", 1, device="cuda:99")


def test_workers_change_nothing(dataset: Path, tmp_path: Path) -> None:
    alone, helped = (run(dataset, tmp_path / str(n), 2, workers=n) for n in (0, 1))
    for name, tensor in weights(alone).items():
        assert torch.equal(tensor, weights(helped)[name]), name


def test_another_training_begins_with_the_weights_alone(dataset: Path, tmp_path: Path) -> None:
    first = run(dataset, tmp_path / "first", 3)
    rates: list[int] = []
    config = dataclasses.replace(CONFIG, training=dataclasses.replace(CONFIG.training, steps=1, learning_rate=1e-12))
    settings = Run(data=dataset, out=tmp_path / "second", split=None, init=first)
    second = train(config, settings, on_step=lambda step, _: rates.append(step))
    assert rates == [1] and second.name == "000000001"
    for name, parameter in AvodNetwork(CONFIG).named_parameters():
        del parameter
        torch.testing.assert_close(weights(second)[name], weights(first)[name], atol=1e-9, rtol=0)


def test_a_last_stage_may_come_from_another_network(dataset: Path, tmp_path: Path) -> None:
    training = dataclasses.replace(CONFIG.training, steps=1, learning_rate=1e-12)
    refinement = Config.named("center_all").refinement
    config = dataclasses.replace(CONFIG, training=training, refinement=refinement)
    without = run(dataset, tmp_path / "without", 1)
    settings = Run(data=dataset, out=tmp_path / "run", split=None, seed=5, init_refinement="center_all")
    trained = weights(train(config, settings))
    packaged = trained_network(read_checkpoint("center_all")).state_dict()
    for name, parameter in new_network(config, 5).named_parameters():
        begun = packaged[name] if name.startswith("refinement.") else parameter.detach()
        torch.testing.assert_close(trained[name], begun, atol=1e-9, rtol=0)
    assert any(name.startswith("refinement.") for name in trained)
    with pytest.raises(CadetError, match=r"^--init-refinement: the configuration has no last stage"):
        train(CONFIG, dataclasses.replace(settings, out=tmp_path / "none"))
    with pytest.raises(CadetError, match=r"refinement\.points\.before\.0\.weight is missing"):
        train(config, dataclasses.replace(settings, init_refinement=without))


def test_what_does_not_learn_stays_as_it_is(dataset: Path, tmp_path: Path) -> None:
    first = run(dataset, tmp_path / "first", 2)
    training = dataclasses.replace(CONFIG.training, steps=4, learns="second_stage.")
    config = dataclasses.replace(CONFIG, training=training)
    train(config, Run(data=dataset, out=tmp_path / "second", split=None, init=first))
    before, after = weights(first), weights(tmp_path / "second")
    changed = {name for name, value in before.items() if not torch.equal(value, after[name])}
    assert changed == {name for name, _ in AvodNetwork(CONFIG).named_parameters() if name.startswith("second_stage.")}
    third = Run(data=dataset, out=tmp_path / "third", split=None, init=first)
    train(with_steps(config, 2), third)
    train(config, dataclasses.replace(third, init=None, resume_from=tmp_path / "third"))
    assert all(torch.equal(value, after[name]) for name, value in weights(tmp_path / "third").items())
    record = read_record(tmp_path / "third")
    assert record.init == str(first) and record.resume_from is None
    nothing = dataclasses.replace(config, training=dataclasses.replace(training, learns="third_stage"))
    with pytest.raises(CadetError, match=r"^Config\.training\.learns: no parameter's name begins with 'third_stage'$"):
        train(nothing, Run(data=dataset, out=tmp_path / "fourth", split=None, init=first))


def test_the_log_goes_on_where_training_does(dataset: Path, tmp_path: Path) -> None:
    config = dataclasses.replace(CONFIG, training=dataclasses.replace(CONFIG.training, steps=10, checkpoint_steps=10))
    train(config, Run(data=dataset, out=tmp_path, split=None))
    rows = read_log(tmp_path / "log.csv")
    assert [row["step"] for row in rows] == [10]
    assert all(math.isfinite(row[name]) for row in rows for name in COLUMNS)
    with (tmp_path / "log.csv").open("a") as file:
        file.write(",".join(["20", *["1"] * (len(COLUMNS) - 1)]) + "\n")  # of steps that will be done again
    train(with_steps(config, 20), Run(data=dataset, out=tmp_path, split=None, resume_from=tmp_path))
    again = read_log(tmp_path / "log.csv")
    assert [row["step"] for row in again] == [10, 20]
    assert again[0] == rows[0] and again[1]["seconds_per_step"] != 1.0
    train(with_steps(config, 23), Run(data=dataset, out=tmp_path, split=None, resume_from=tmp_path))
    assert [row["step"] for row in read_log(tmp_path / "log.csv")] == [10, 20, 23]


def test_tensorboard_is_named_where_it_is_asked_for_and_missing(
    dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(CadetError, match=r"^--tensorboard needs tensorboard: pip install tensorboard$"):
        run(dataset, tmp_path, 1, tensorboard=True)


def test_what_cannot_go_on_is_said(dataset: Path, tmp_path: Path) -> None:
    last = run(dataset, tmp_path, 1)
    with pytest.raises(CadetError, match="1 steps are done, and training ends at 1"):
        run(dataset, tmp_path, 1, resume_from=last)
    with pytest.raises(CadetError, match="not both"):
        run(dataset, tmp_path, 2, resume_from=last, init=last)
    with pytest.raises(MissingFileError, match="not a checkpoint"):
        run(dataset, tmp_path, 2, init=tmp_path / "nothing")
    wider = dataclasses.replace(CONFIG, rpn=dataclasses.replace(CONFIG.rpn, hidden=65))
    with pytest.raises(CadetError, match=r"anchor_classifier\.layers\.0\.weight is \(64, 36\), expected \(65, 36\)"):
        train(wider, Run(data=dataset, out=tmp_path, split=None, init=last))
    others = (CONFIG.classes[1], CONFIG.classes[0])
    with pytest.raises(CadetError, match="its configuration has another 'classes'; take its weights alone with --init"):
        train(
            dataclasses.replace(CONFIG, classes=others),
            Run(data=dataset, out=tmp_path, split=None, resume_from=last),
        )
    (last / "optimizer.safetensors").unlink()
    with pytest.raises(MissingFileError, match="take this checkpoint's weights with --init instead"):
        run(dataset, tmp_path, 2, resume_from=last)


@pytest.mark.parametrize(
    ("file", "content", "message"),
    [
        ("checkpoint.json", b"{", "invalid JSON"),
        ("checkpoint.json", b"[]", "not an avod checkpoint"),
        ("checkpoint.json", b'{"format": "avod-checkpoint", "version": 9}', "version 9, expected 1"),
        ("model.safetensors", b"1234", "damaged"),
        ("model.safetensors", b"\xff" * 64, "damaged"),
    ],
)
def test_a_damaged_checkpoint_is_refused(
    dataset: Path, tmp_path: Path, file: str, content: bytes, message: str
) -> None:
    last = run(dataset, tmp_path, 1)
    (last / file).write_bytes(content)
    with pytest.raises(CadetError, match=message):
        Detector(last)


def test_a_checkpoint_is_read_by_its_keys(dataset: Path, tmp_path: Path) -> None:
    last = run(dataset, tmp_path, 1, seed=11)
    checkpoint = read_checkpoint(tmp_path)
    assert (checkpoint.path, checkpoint.step, checkpoint.seed) == (last, 1, 11)
    assert checkpoint.config.rpn == CONFIG.rpn
    text = (last / "checkpoint.json").read_text()
    (last / "checkpoint.json").write_text(text.replace('"hidden"', '"hiden"', 1))
    with pytest.raises(CadetError, match=r"checkpoint\.json: config: rpn\.hiden: unknown key"):
        read_checkpoint(last)


def test_a_checkpoint_from_before_ground_could_be_estimated_takes_planes_from_files(
    dataset: Path, tmp_path: Path
) -> None:
    last = run(dataset, tmp_path, 1)
    settings = json.loads((last / "checkpoint.json").read_text())
    assert settings["config"].pop("ground") == "file"
    (last / "checkpoint.json").write_text(json.dumps(settings))
    assert read_checkpoint(last).config.ground == Detector(last).config.ground == "file"


@pytest.mark.filterwarnings("ignore:frame .* is left out")
def test_frames_that_are_all_broken_stop_training_by_name(dataset: Path, tmp_path: Path) -> None:
    root = tmp_path / "broken"
    shutil.copytree(dataset, root)
    for path in (root / "training" / "velodyne").iterdir():
        path.write_bytes(path.read_bytes()[:-3])
    for workers in (0, 1):
        with pytest.raises(CadetError, match=r"velodyne/00000[012]\.bin: truncated"):
            run(root, tmp_path / "out", 8, workers=workers)
