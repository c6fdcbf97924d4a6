"""The numbers of the center detector: frozen, checked when made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from avod.config.limits import MAX_LAYERS
from cadet._util.checks import Limits, check_fields
from cadet.errors import CadetError


@dataclass(frozen=True, kw_only=True)
class CenterConfig:
    """A detector that marks objects' centers in maps of the bird's-eye view, without a camera.

    Raises:
        CadetError: tuples that do not fit each other, or a number outside its range.

    Reference: Yin et al., "Center-based 3D Object Detection and Tracking" (CVPR 2021).
    """

    channels: Annotated[tuple[int, ...], Limits(1, 4096)] = (24, 48, 96)
    """Of each stage of the encoder, which begins with a convolution of stride 2."""
    convolution_pairs: Annotated[tuple[int, ...], Limits(0, 32)] = (1, 2, 3)
    """Pairs of convolutions of each stage, whose outputs are added to what comes in."""
    fused_channels: Annotated[tuple[int, ...], Limits(1, 4096)] = (48, 40)
    """Of the decoder after each fusion, from coarse to fine; the last is what the heads see."""
    spread: Annotated[float, Limits(0, 10)] = 0.27
    """Standard deviation of the mark about a center, over the object's width ..."""
    min_spread_cells: Annotated[float, Limits(0.1, 100)] = 0.8
    """... and its least, in cells of the output."""
    regression_weight: Annotated[float, Limits(0)] = 1.0
    """Of the box loss against that of the marks."""

    def __post_init__(self) -> None:
        count = len(self.channels)
        for name, numbers, wanted in (
            ("channels", count, range(2, MAX_LAYERS + 1)),
            ("convolution_pairs", len(self.convolution_pairs), range(count, count + 1)),
            ("fused_channels", len(self.fused_channels), range(count - 1, count)),
        ):
            if numbers not in wanted:
                raise CadetError(f"CenterConfig.{name}: expected {wanted[0]} to {wanted[-1]} numbers, got {numbers}")
        check_fields(self)

    @property
    def stride(self) -> int:
        """How many cells of the maps one cell of the coarsest stage covers, along each axis."""
        return int(2 ** len(self.channels))
