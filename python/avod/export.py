"""Networks as ONNX files, a file for each part that has one arithmetic for all frames.

What lies between the parts is geometry: maps, anchors, crops, and the points of boxes. A program that runs the files
does it itself; `avod.data.build`, `avod.ops`, and `avod.model.refinement` say how.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import torch
from torch import Tensor, nn

from avod.detector import Detector
from avod.model.avod.network import AvodNetwork
from avod.model.center.network import CenterNetwork
from avod.model.center.targets import NUM_BOX
from avod.model.network import AnyNetwork
from avod.model.refinement import BOX_FEATURES, POINT_FEATURES, PointRefinement
from cadet._util.extras import load_extra

_ROWS = 2
"""Of the examples that a number of rows, which is free, is traced with."""


@dataclass(frozen=True, eq=False)
class Part:
    """One of a network's parts.

    Attributes:
        name: of its file.
        run: takes the inputs in their order.
        inputs: an example of each by name.
        outputs: names.
        has_rows: whether the first axis of all is free: boxes or anchors; else it is the one frame.
    """

    name: str
    run: Callable[..., tuple[Tensor, ...]]
    inputs: Mapping[str, Tensor]
    outputs: tuple[str, ...]
    has_rows: bool


def parts_of(network: AnyNetwork) -> tuple[Part, ...]:
    """List a network's parts."""
    parts = _avod_parts(network) if isinstance(network, AvodNetwork) else _center_parts(cast("CenterNetwork", network))
    return parts if network.refinement is None else (*parts, _refinement_part(network.refinement))


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
    network = detector.network.to("cpu").eval()
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    return tuple(_write(network, part, out / f"{part.name}.onnx") for part in parts_of(network))


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


def _center_parts(network: CenterNetwork) -> tuple[Part, ...]:
    def maps(bev: Tensor) -> tuple[Tensor, ...]:
        found = network.run_maps(bev)
        return found[:, :-NUM_BOX], found[:, -NUM_BOX:]

    bev = torch.zeros((1, *network.config.bev.shape))
    return (Part("maps", maps, {"bev": bev}, ("marks", "boxes"), has_rows=False),)


def _avod_parts(network: AvodNetwork) -> tuple[Part, ...]:
    config = network.config
    width, height = config.image.size
    second = network.second_stage.layers[0]
    first = network.anchor_classifier.layers[0]
    crops = {"crops": torch.zeros((_ROWS, cast("nn.Linear", first).in_features))}
    proposals = {"crops": torch.zeros((_ROWS, cast("nn.Linear", second).in_features))}
    frame = {"bev": torch.zeros((1, *config.bev.shape)), "image": torch.zeros((1, 3, height, width))}
    names = ("bev_features", "image_features", "bev_bottleneck", "image_bottleneck")
    return (
        Part("features", network.run_maps, frame, names, has_rows=False),
        Part("anchors", network.run_anchors, crops, ("logits", "offsets"), has_rows=True),
        Part("proposals", network.second_stage, proposals, ("class_logits", "box_offsets", "vectors"), has_rows=True),
    )


def _refinement_part(refinement: PointRefinement) -> Part:
    most = refinement.config.max_points
    inputs: dict[str, Any] = {
        "features": torch.zeros((_ROWS, most, POINT_FEATURES)),
        "is_point": torch.ones((_ROWS, most), dtype=torch.bool),
        "seen": torch.zeros((_ROWS, BOX_FEATURES)),
    }
    return Part("refinement", refinement.judge, inputs, ("corrections", "quality_logits"), has_rows=True)
