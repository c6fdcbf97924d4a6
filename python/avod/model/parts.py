"""The parts of a network that have one arithmetic for all frames."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from torch import Tensor

EXAMPLE_ROWS: Final = 2
"""Of the examples of a part whose number of rows is free."""


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
