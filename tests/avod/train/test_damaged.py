"""Checkpoints, logs and devices that cannot be used: one line, and no memory for what a file merely claims."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
from safetensors.torch import load_file, save_file

from avod.config import Config
from avod.config.tables import config_from_table
from avod.detector import Detector
from avod.device import resolve_device
from avod.model.avod.network import AvodNetwork
from avod.model.making import abstract_network
from avod.model.network import AnyNetwork
from avod.train import checkpoint as checkpoints
from avod.train.checkpoint import load_optimizer, read_checkpoint, save_checkpoint
from avod.train.log import read_log
from avod.train.step import MAX_WEIGHTS, new_network
from cadet.errors import CadetError, MissingFileError
from detector.logs import COLUMNS

CONFIG = Config.named(Path(__file__).parents[2] / "support" / "detector" / "overfit.toml")
HEADER = ",".join(COLUMNS) + "\n"
ROW = "10,0.0001,0.5,0.4,0.3,0.2,0.1,1.5,0.9\n"


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """Return a checkpoint after one step of Adam on made-up gradients."""
    network = new_network(CONFIG, 0)
    optimizer = torch.optim.Adam(network.parameters())
    for parameter in network.parameters():
        parameter.grad = torch.ones_like(parameter)
    optimizer.step()
    return save_checkpoint(tmp_path, network, optimizer, CONFIG, step=1, seed=0)


def change_config(folder: Path, *keys: str | int, value: object) -> None:
    file = folder / "checkpoint.json"
    settings = json.loads(file.read_text())
    table = settings["config"]
    for key in keys[:-1]:
        table = table[key]
    table[keys[-1]] = value
    file.write_text(json.dumps(settings))


def test_shapes_are_those_of_the_network_without_its_memory() -> None:
    real, abstract = AvodNetwork(CONFIG).state_dict(), abstract_network(CONFIG).state_dict()
    assert {name: tensor.shape for name, tensor in abstract.items()} == {n: t.shape for n, t in real.items()}
    assert {tensor.device.type for tensor in abstract.values()} == {"meta"}


def test_claimed_layers_are_compared_with_the_weights_before_they_take_memory(
    saved: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    change_config(saved, "second_stage", "hidden", value=[65_536, 65_536])

    def refuse(config: Config) -> AnyNetwork:
        raise AssertionError("the network was made")

    monkeypatch.setattr(checkpoints, "make_network", refuse)
    with pytest.raises(CadetError, match=r"second_stage\.layers\.0\.weight is \(256, 784\), expected \(65536, 784\)"):
        Detector(saved)


@pytest.mark.parametrize(
    ("keys", "value", "message"),
    [
        (("bev", "cell_m"), 0.001, "BevConfig: expected maps of at most 134,217,728 values, got 6 channels of 28800 x"),
        (("bev", "z_m"), [0.0, 1000.0], None),
        (("bev", "cell_m"), 0.008, "Config.bev: expected at most 8,388,608 cells, got 3600 x 3200"),
        (("image", "size"), [8192, 8192], "ImageConfig.size: expected at most 8,388,608 pixels, got (8192, 8192)"),
        (("anchors", "stride_m"), 0.05, None),
        (("second_stage", "hidden"), [8] * 9, "SecondStageConfig.hidden: expected at most 8 layers, got 9"),
        (("extractor", "convolutions"), [1, 1, 1, 33], "ExtractorConfig.convolutions: expected a whole number from 1"),
    ],
)
def test_claimed_sizes_have_limits(saved: Path, keys: tuple[str, str], value: object, message: str | None) -> None:
    change_config(saved, *keys, value=value)
    if message is None:
        assert read_checkpoint(saved).step == 1
        return
    with pytest.raises(CadetError) as error:
        read_checkpoint(saved)
    assert message in str(error.value) and str(saved / "checkpoint.json") in str(error.value)


def test_anchors_have_a_limit() -> None:
    table = {"anchors": {"stride_m": 0.05}, "classes": [{"name": "Car"}, {"name": "Van"}, {"name": "Tram"}]}
    with pytest.raises(CadetError, match=r"stride_m: expected at most 4,194,304 anchors, got about 26,9\d\d,\d\d\d"):
        config_from_table(table, "mine.toml")


def test_a_network_to_train_has_a_limit() -> None:
    second = dataclasses.replace(CONFIG.second_stage, hidden=(65_536, 65_536))
    with pytest.raises(CadetError, match=rf"has 4,3\d\d,\d\d\d,\d\d\d weights, expected at most {MAX_WEIGHTS:,}"):
        new_network(dataclasses.replace(CONFIG, second_stage=second), 0)


def test_weights_of_another_type_are_refused(saved: Path) -> None:
    file = saved / "model.safetensors"
    tensors = load_file(file)
    name = "second_stage.layers.0.weight"
    for dtype, kind in ((torch.int32, "I32"), (torch.bfloat16, "BF16")):
        save_file(tensors | {name: tensors[name].to(dtype)}, file)
        with pytest.raises(CadetError, match=rf"{name} is of type {kind}, expected F32$"):
            Detector(saved)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("exp_avg.bev_bottleneck.norm.bias", math.nan, "holds NaN or infinity"),
        ("exp_avg_sq.bev_bottleneck.norm.bias", math.inf, "holds NaN or infinity"),
        ("exp_avg_sq.bev_bottleneck.norm.bias", -1.0, "holds a negative number"),
        ("step", math.nan, "holds NaN or infinity"),
        ("step", -1.0, "holds a negative number"),
        ("step", None, "does not fit"),
        ("exp_avg.bev_bottleneck.norm.bias", None, "does not fit"),
        ("step", torch.int32, "does not fit"),
        ("exp_avg.bev_bottleneck.norm.bias", torch.int32, "does not fit"),
    ],
)
def test_averages_that_adam_cannot_have_left_are_refused(saved: Path, name: str, value: Any, message: str) -> None:
    file = saved / "optimizer.safetensors"
    tensors = load_file(file)
    network = AvodNetwork(CONFIG)
    load_optimizer(read_checkpoint(saved), network, torch.optim.Adam(network.parameters()))
    if value is None:
        del tensors[name]
    elif isinstance(value, float):
        tensors[name].view(-1)[:1] = value
    else:
        tensors[name] = tensors[name].to(value)
    save_file(tensors, file)
    optimizer = torch.optim.Adam(network.parameters())
    with pytest.raises(CadetError, match=rf"optimizer\.safetensors: {name} {message}"):
        load_optimizer(read_checkpoint(saved), network, optimizer)
    assert not optimizer.state


def test_a_negative_mean_is_no_mistake(saved: Path) -> None:
    file = saved / "optimizer.safetensors"
    save_file({n: -t if n.startswith("exp_avg.") else t for n, t in load_file(file).items()}, file)
    network = AvodNetwork(CONFIG)
    load_optimizer(read_checkpoint(saved), network, torch.optim.Adam(network.parameters()))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEADER + ROW + ROW.replace("0.4", "nan"), r"log\.csv:3: anchor: expected a finite number, got 'nan'$"),
        (HEADER + ROW.replace("1.5", "inf"), r"log\.csv:2: total: expected a finite number, got 'inf'$"),
        (HEADER + ROW.replace("1.5", "1e99"), r"log\.csv:2: total: expected a finite number, got '1e99'$"),
        (HEADER + ROW.replace("0.5", "0_5"), r"log\.csv:2: objectness: expected a finite number, got '0_5'$"),
        (HEADER + ROW.replace("10,", "10.5,", 1), r"log\.csv:2: step: expected a whole number, got '10\.5'$"),
        (HEADER + ROW[:-1] + ",1\n", r"log\.csv:2: expected 9 fields, got 10$"),
        (HEADER + "\n", r"log\.csv:2: expected 9 fields, got 1$"),
        (HEADER.replace("total", "totem") + ROW, r"log\.csv:1: expected the columns step, learning_rate, "),
        ("", r"log\.csv:1: expected the columns "),
        (HEADER + ROW.replace("0.3", "\0"), r"log\.csv:2: classification: expected a finite number, got '\\x00'$"),
    ],
)
def test_rows_that_are_no_numbers_are_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "log.csv"
    file.write_text(text)
    with pytest.raises(CadetError, match=message):
        read_log(file)


def test_a_row_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(HEADER + ROW + ROW[:20])
    assert [row["step"] for row in read_log(tmp_path / "log.csv")] == [10]
    (tmp_path / "log.csv").write_bytes((HEADER + ROW).replace("\n", "\r\n").encode())
    assert [row["total"] for row in read_log(tmp_path / "log.csv")] == [1.5]
    with pytest.raises(MissingFileError, match="no such file"):
        read_log(tmp_path / "none.csv")


@pytest.mark.parametrize("use", [resolve_device, lambda name: Detector("tiny_car", device=name)])
@pytest.mark.parametrize("name", ["meta", "gpu", "hpu", "lazy", "cuda:-1", "cpu:x", ""])
def test_devices_that_cannot_be_used_are_named(use: Callable[[str], object], name: str) -> None:
    with pytest.raises(CadetError, match=f"^device: {name!r} cannot be used: ") as error:
        use(name)
    assert "\n" not in str(error.value)
