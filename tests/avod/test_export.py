"""Networks as ONNX files: onnxruntime computes what PyTorch does, for any number of rows."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from click.testing import CliRunner

from avod import Detector
from avod.cli.commands import avod
from avod.config import Config
from avod.export import export_onnx
from avod.model.parts import Part
from avod.train.checkpoint import save_checkpoint
from avod.train.step import new_network
from cadet.errors import CadetError

SUPPORT = Path(__file__).parents[1] / "support" / "detector"


def drawn(part: Part, rows: int) -> dict[str, torch.Tensor]:
    """Draw inputs of a part, of so many rows where their number is free."""
    generator = torch.Generator().manual_seed(rows)
    found = {}
    for name, example in part.inputs.items():
        shape = (rows, *example.shape[1:]) if part.has_rows else example.shape
        values = torch.rand(shape, generator=generator)
        # Whole numbers tell whose row a row is.
        found[name] = values if example.dtype.is_floating_point else (values * rows).long()
    return found


@pytest.mark.parametrize("name", ["center", "overfit"])
def test_onnxruntime_computes_the_same(tmp_path: Path, name: str) -> None:
    runtime = pytest.importorskip("onnxruntime", reason="needs onnxruntime")
    pytest.importorskip("onnxscript", reason="needs onnxscript")
    network = new_network(Config.named(SUPPORT / f"{name}.toml"), 0).eval()
    for parameter in network.parameters():
        if not parameter.any():  # Else what comes before layers that begin at zero would not be seen.
            torch.nn.init.normal_(parameter, std=0.1)
    checkpoint = save_checkpoint(tmp_path / "run", network, None, network.config, step=1, seed=0)
    out = tmp_path / "onnx"
    result = CliRunner().invoke(avod, ["export", "--checkpoint", str(checkpoint), "--out", str(out)])
    assert result.exit_code == 0, result.output
    parts = network.parts()
    assert {path.name for path in out.iterdir()} == {f"{part.name}.onnx" for part in parts}
    for part in parts:
        session = runtime.InferenceSession(str(out / f"{part.name}.onnx"), providers=["CPUExecutionProvider"])
        for rows in (2, 7):
            inputs = drawn(part, rows)
            found = session.run(list(part.outputs), {key: value.numpy() for key, value in inputs.items()})
            with torch.no_grad():
                wanted = part.run(*inputs.values())
            for one, other in zip(found, wanted, strict=True):
                np.testing.assert_allclose(one, other.numpy(), atol=1e-3, rtol=1e-3)


def test_parts_take_what_their_examples_are_like() -> None:
    for name in ("center", "overfit"):
        network = new_network(Config.named(SUPPORT / f"{name}.toml"), 0).eval()
        for part in network.parts():
            with torch.no_grad():
                assert len(part.run(*part.inputs.values())) == len(part.outputs)


def test_without_onnx_there_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "onnx", None)
    with pytest.raises(CadetError, match="export needs onnx: pip install"):
        export_onnx(Detector(new_network(Config.named(SUPPORT / "center.toml"), 0)), tmp_path)
