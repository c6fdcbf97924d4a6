"""Faster arithmetic gives the same network: compiled, in bfloat16, channels last, folded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import torch

from avod.config import Config
from avod.data.dataset import sample_from_frame
from avod.data.sample import Sample
from avod.model.avod.outputs import FrameOutputs
from avod.model.layers import Convolution, ShiftBatchNorm, UpConvolution
from avod.model.network import AnyNetwork
from avod.train.log import read_log
from avod.train.step import new_network
from detector.logs import TERMS
from detector.runs import short_run, small_config, write_set
from synthetic import make_frame


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Config:
    return small_config(tmp_path_factory.mktemp("config"))


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_set(tmp_path_factory.mktemp("set"))


@pytest.fixture(scope="module")
def sample(config: Config) -> Sample:
    return sample_from_frame(make_frame(), "000000", config)


def trained(config: Config) -> AnyNetwork:
    """Return a network with averages and shifts that are not those it was made with."""
    network = new_network(config, 0)
    generator = torch.Generator().manual_seed(1)
    for module in network.modules():
        if isinstance(module, ShiftBatchNorm):
            module.running_mean.normal_(0.0, 0.2, generator=generator)
            module.running_var.uniform_(0.5, 2.0, generator=generator)
            module.bias.data.normal_(0.0, 0.2, generator=generator)
    return network.eval()


def run(network: AnyNetwork, sample: Sample) -> FrameOutputs:
    with torch.inference_mode():
        (outputs,) = network([sample])
    assert isinstance(outputs, FrameOutputs)
    return outputs


def assert_close(found: FrameOutputs, expected: FrameOutputs, tolerance: float) -> None:
    for name in ("anchor_logits", "anchor_offsets", "class_logits", "box_offsets", "vectors"):
        one, other = getattr(found, name), getattr(expected, name)
        assert one.shape == other.shape and one.dtype == torch.float32
        assert (one - other).abs().max() <= tolerance * max(1.0, float(other.abs().max())), name


def test_folded_normalization_gives_the_outputs_of_unfolded_layers(
    config: Config, sample: Sample, monkeypatch: pytest.MonkeyPatch
) -> None:
    network = trained(config)
    folded = run(network, sample)

    def plain(self: Any, *features: torch.Tensor) -> torch.Tensor:
        grown = self.convolution(torch.cat(features, dim=1))
        if isinstance(self, UpConvolution):
            grown = grown[:, :, :-1, :-1]
        return torch.relu(self.norm(grown))

    for kind in (Convolution, UpConvolution):
        monkeypatch.setattr(kind, "forward", plain)
    assert_close(folded, run(network, sample), 1e-4)


def test_memory_formats_change_nothing(config: Config, sample: Sample) -> None:
    network = trained(config)
    kernels = [p for p in network.parameters() if p.dim() == 4 and min(p.shape[:2]) > 1 and p.shape[2] > 1]
    assert kernels and all(p.is_contiguous(memory_format=torch.channels_last) for p in kernels)
    last = run(network, sample)
    assert_close(run(network.to(memory_format=torch.contiguous_format), sample), last, 1e-5)


def test_bfloat16_comes_near_float32(config: Config, sample: Sample) -> None:
    network = trained(config)
    expected = run(network, sample)
    network.precision = torch.bfloat16
    found = run(network, sample)
    # Proposals may change places: only what is made of anchors can be compared one by one.
    for name in ("anchor_logits", "anchor_offsets"):
        one, other = getattr(found, name), getattr(expected, name)
        assert one.dtype == torch.float32 and not torch.equal(one, other)
        assert (one - other).abs().max() <= 0.05 * max(1.0, float(other.abs().max())), name


def test_compiled_pyramids_train_as_the_others(
    config: Config, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Traced and differentiated ahead of time; the last stage, a C++ compiler's, takes minutes."""
    compiled: list[str] = []

    def compile_quickly(self: torch.nn.Module, **options: Any) -> None:
        compiled.append(type(self).__name__)
        self._compiled_call_impl = torch.compile(self._call_impl, backend="aot_eager", fullgraph=True, **options)

    monkeypatch.setattr(torch.nn.Module, "compile", compile_quickly)
    short_run(config, data, tmp_path / "compiled", 3, compile=True)
    assert compiled == ["FeaturePyramid", "FeaturePyramid"]
    short_run(config, data, tmp_path / "plain", 3)
    (one,), (other,) = (read_log(tmp_path / name / "log.csv") for name in ("compiled", "plain"))
    for name in TERMS:
        assert one[name] == pytest.approx(other[name], rel=0.02), name
