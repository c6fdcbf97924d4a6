"""The moving average of weights: against a sum, what checkpoints hold of it, and exact resuming."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from avod.config import Config
from avod.model.avod.network import AvodNetwork
from avod.train.checkpoint import read_checkpoint, trained_network
from avod.train.log import Validated
from avod.train.step import WeightAverage, new_network
from cadet.errors import CadetError
from detector.logs import TERMS
from detector.runs import StopAfter, assert_same_training, short_run, small_config, weights, write_set

STEPS = 7


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("average")
    write_set(folder / "set")
    return folder


@pytest.fixture(scope="module")
def config(folder: Path) -> Config:
    return with_decay(small_config(folder), 0.9)


@pytest.fixture(scope="module")
def steps(folder: Path, config: Config) -> list[dict[str, torch.Tensor]]:
    """Train without an average, a checkpoint a step: what is averaged."""
    plain = with_decay(config, 0.0)
    plain = dataclasses.replace(plain, training=dataclasses.replace(plain.training, checkpoint_steps=1))
    short_run(plain, folder / "set", folder / "plain", STEPS)
    return [weights(folder / "plain" / "checkpoints" / f"{step:09d}") for step in range(1, STEPS + 1)]


def with_decay(config: Config, decay: float) -> Config:
    return dataclasses.replace(config, training=dataclasses.replace(config.training, average_decay=decay))


def test_the_average_is_the_weighted_sum_of_all_steps(folder: Path, config: Config) -> None:
    network = new_network(config, 0)
    average = WeightAverage(network, 0.3)
    values = [float(value) for value in np.random.default_rng(0).normal(size=6)]
    first = next(iter(network.state_dict()))
    expected = float(network.state_dict()[first].flatten()[0])
    for step, value in enumerate(values):
        with torch.no_grad():
            network.state_dict()[first].fill_(value)
        average.update(network, step)
        decay = min(0.3, (1 + step) / (10 + step))
        expected = decay * expected + (1.0 - decay) * value
    assert float(average.network.state_dict()[first].flatten()[0]) == pytest.approx(expected, rel=1e-5)


def test_a_checkpoint_holds_the_average_of_the_same_training(
    folder: Path, config: Config, steps: list[dict[str, torch.Tensor]]
) -> None:
    last = short_run(config, folder / "set", folder / "averaged", STEPS)
    start = new_network(config, 0).state_dict()
    found = weights(last)
    assert any(not torch.equal(found[name], steps[-1][name]) for name in found)
    for name, value in found.items():
        expected = start[name].double()
        for step, weight in enumerate(steps):
            decay = min(0.9, (1 + step) / (10 + step))
            expected = decay * expected + (1.0 - decay) * weight[name].double()
        torch.testing.assert_close(value.double(), expected, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("after", [2, 4])
def test_an_averaged_training_goes_on_as_if_it_had_not_stopped(
    folder: Path, config: Config, tmp_path: Path, after: int
) -> None:
    unbroken = folder / f"unbroken{after}"
    short_run(config, folder / "set", unbroken, STEPS)
    last = short_run(config, folder / "set", tmp_path, STEPS, should_stop=StopAfter(after))
    assert last.name == f"{after:09d}"
    short_run(config, folder / "set", tmp_path, STEPS, resume=True)
    assert_same_training(tmp_path, unbroken)


def test_another_training_may_start_or_end_averaging(folder: Path, config: Config, tmp_path: Path) -> None:
    plain = with_decay(config, 0.0)
    data = folder / "set"
    averaged = short_run(config, data, tmp_path / "averaged", 3)
    with pytest.warns(UserWarning, match=r"training\.average_decay = 0\.9, and training goes on with 0\.0"):
        on = short_run(plain, data, tmp_path / "ended", 5, resume_from=averaged)
    unbroken = short_run(plain, data, tmp_path / "unbroken", 5)
    assert (on / "model.safetensors").read_bytes() == (unbroken / "model.safetensors").read_bytes()
    first = short_run(plain, data, tmp_path / "plain", 3)
    with pytest.warns(UserWarning, match=r"training\.average_decay"):
        started = short_run(config, data, tmp_path / "started", 5, resume_from=first)
    assert trained_network(read_checkpoint(started)) is not None


def test_validation_judges_the_average(folder: Path, config: Config, tmp_path: Path) -> None:
    judged: list[dict[str, torch.Tensor]] = []

    def validate(network: AvodNetwork, step: int, processes: Any) -> Validated:
        judged.append({name: value.clone() for name, value in network.state_dict().items()})
        return Validated(dict.fromkeys(TERMS, 1.0), 50.0, dict.fromkeys(config.class_names, 50.0))

    last = short_run(config, folder / "set", tmp_path, 2, val_every=2, validate=validate)
    for path in (last, tmp_path / "best_val"):
        found = weights(path)
        assert all(torch.equal(value, judged[0][name]) for name, value in found.items())


def test_damaged_weights_beside_an_average_are_refused(folder: Path, config: Config, tmp_path: Path) -> None:
    from safetensors.torch import load_file, save_file

    last = short_run(config, folder / "set", tmp_path, 3)
    file = last / "optimizer.safetensors"
    tensors = load_file(file)
    name = next(name for name in tensors if name.startswith("weights."))
    save_file({**tensors, name: tensors[name] * float("nan")}, file)
    with pytest.raises(CadetError, match=f"optimizer.safetensors: {name} holds NaN or infinity"):
        short_run(config, folder / "set", tmp_path, 4, resume=True)
    save_file({key: value for key, value in tensors.items() if key != name}, file)
    with pytest.raises(CadetError, match=f"{name.removeprefix('weights.')} is missing: these are weights of another"):
        short_run(config, folder / "set", tmp_path, 4, resume=True)
