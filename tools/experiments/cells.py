"""A cell of the experiments: one training, or weights that are given, and the frames it is tested on."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from avod.config import Config
from avod.config.tables import table_from_config
from tools.experiments.scales import CLASSES

REAL: Final = "real"
SIM: Final = "sim"
TUNED: Final = "tuned"
MIXED: Final = "mixed"
LONGER: Final = "longer"
GIVEN: Final = "given"

WEIGHTS_FILE: Final = "model.safetensors"


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One training and its tests.

    Attributes:
        class_name: that the detector finds.
        maps: configuration of the bird's-eye-view maps.
        trained: "sim", "real", "tuned" (sim, then real), "mixed" (sim, then both by turns), "longer" (sim, then sim for
            as long), or "given" (weights from elsewhere).
        frames: how many real frames it learns from; None for all.
        seed: of the training.
        config: of the detector and its training.
        stops: steps at which the training is kept for another one to go on from, and its end; none for given weights.
        source: name of the cell whose weights it begins with.
        branch_step: of the source's stops, the one it goes on from with optimizer and schedule; None takes the weights
            of the source's chosen checkpoint.
        init: the checkpoint of given weights: what it begins with, or what is tested.
        tests: sets whose validation frames it is tested on, "real" or "sim"; its checkpoint is chosen on the first.
        last: how many last checkpoints it is chosen from.
    """

    class_name: str
    maps: str
    trained: str
    seed: int
    config: Config
    tests: tuple[str, ...]
    frames: int | None = None
    stops: tuple[int, ...] = ()
    source: str | None = None
    branch_step: int | None = None
    init: Path | None = None
    last: int = 1

    @property
    def name(self) -> str:
        """Name the cell: its folder's name."""
        few = () if self.frames is None else (f"{self.frames}frames",)
        return "-".join((CLASSES[self.class_name], self.maps, self.trained, *few, f"seed{self.seed}"))

    @property
    def data(self) -> tuple[str, ...]:
        """The sets that it learns from in equal shares, "sim" or "real"; `frames` are of the last."""
        return {SIM: (SIM,), LONGER: (SIM,), MIXED: (SIM, REAL)}.get(self.trained, (REAL,))

    @property
    def first_step(self) -> int:
        """The step at which its training begins."""
        return self.branch_step or 0

    @property
    def num_steps(self) -> int:
        """How many steps it trains."""
        return self.stops[-1] - self.first_step if self.stops else 0

    def describe(self) -> dict[str, Any]:
        """Return all that its numbers follow from, but the frames, as plain values."""
        weights = None if self.init is None else zlib.crc32((self.init / WEIGHTS_FILE).read_bytes())
        return {
            "class": self.class_name,
            "maps": self.maps,
            "trained": self.trained,
            "frames": self.frames,
            "seed": self.seed,
            "stops": list(self.stops),
            "source": self.source,
            "branch_step": self.branch_step,
            "init_crc32": weights,
            "tests": list(self.tests),
            "last": self.last,
            "config": table_from_config(self.config),
        }
