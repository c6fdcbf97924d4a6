"""Networks as ONNX files, a file for each part that has one arithmetic for all frames.

What lies between the parts is geometry: maps, anchors, crops, and the points of boxes. A program that runs the files
does it itself; `avod.data.build`, `avod.ops`, `avod.model.refinement`, and `avod.model.heading` say how.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path

import torch
from torch import Tensor, nn

from avod.detector import Detector
from avod.model.network import AnyNetwork
from avod.model.parts import Part
from cadet._util.extras import load_extra


def export_onnx(detector: Detector, folder: str | Path) -> tuple[Path, ...]:
    """Write a detector's parts as ONNX files.

    Args:
        detector: the detector.
        folder: of the files; made if there is none.

    Returns:
        The files.

    Raises:
        CadetError: onnx or onnxscript is not installed.
    """
    load_extra("onnx", "onnx", "export")
    load_extra("onnxscript", "onnx", "export")
    network = copy.deepcopy(detector.network).to("cpu")
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    return tuple(_write(network, part, out / f"{part.name}.onnx") for part in network.parts())


class _Traced(nn.Module):
    """A function of a network as a module, which is what can be exported."""

    def __init__(self, network: nn.Module, run: Callable[..., tuple[Tensor, ...]]) -> None:
        super().__init__()
        self.network = network
        self.run = run

    def forward(self, *inputs: Tensor) -> tuple[Tensor, ...]:
        return self.run(*inputs)


def _write(network: AnyNetwork, part: Part, file: Path) -> Path:
    shapes = tuple({0: torch.export.Dim.DYNAMIC} if part.has_rows else None for _ in part.inputs)
    aside = file.with_name(f".{file.name}.partial")
    torch.onnx.export(
        _Traced(network, part.run).eval(),
        tuple(part.inputs.values()),
        str(aside),
        input_names=list(part.inputs),
        output_names=list(part.outputs),
        dynamic_shapes=(shapes,),
        dynamo=True,
        external_data=False,
        verbose=False,
    )
    aside.replace(file)
    return file
