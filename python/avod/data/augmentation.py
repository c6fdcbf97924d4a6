"""Changes of a sample in training, and the random streams that they are drawn from."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Final

import numpy as np

from avod.config import Size
from avod.config.augmentation import AugmentationConfig

OFF: Final = AugmentationConfig()
"""No change but AVOD's own."""


@dataclass(frozen=True)
class Augmentation:
    """How a sample is changed in training.

    Attributes:
        is_mirrored: left and right change places.
        has_jitter: the image's colors are shifted along their principal axes.
        seed: of all that is drawn.
        settings: what else is changed, and how far.
        size_shifts_m: (l, w, h) that objects of each class grow by; empty for none.
    """

    is_mirrored: bool = False
    has_jitter: bool = False
    seed: tuple[int, ...] = (0,)
    settings: AugmentationConfig = OFF
    size_shifts_m: tuple[Size, ...] = ()

    def stream(self, name: str) -> np.random.Generator:
        """Return the random numbers of one change: another change that is switched on or off leaves them alone."""
        return np.random.default_rng([*self.seed, zlib.crc32(name.encode())])


UNCHANGED: Final = Augmentation()
"""No change."""
