"""Some of a folder's frames: which ones follows from the seed alone, and fewer are among more."""

from __future__ import annotations

import numpy as np

from avod.data.order import stream_seed


def draw_frames(ids: tuple[str, ...], count: int, seed: int) -> tuple[str, ...]:
    """Draw frames without replacement. Those of a smaller count are among those of a larger one of the same seed.

    Args:
        ids: of the frames to draw from.
        count: how many, at most as many as there are.
        seed: of the draw.

    Returns:
        Their ids, in the order of `ids`.
    """
    order = np.random.default_rng(stream_seed(seed, "subset")).permutation(len(ids))
    return tuple(ids[index] for index in sorted(order[:count]))
