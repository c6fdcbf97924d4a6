"""Some of a folder's frames: which ones follows from the seed alone, and fewer are among more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from avod.config import Config
from avod.data.order import stream_seed
from cadet.errors import CadetError
from cadet.formats.kitti import Label


def usable_frames(labels: Mapping[str, Sequence[Label]], config: Config, place: str) -> tuple[str, ...]:
    """Return the ids of the frames that hold enough objects of the classes to learn from, in their order.

    Args:
        labels: of each frame, by id.
        config: the detector and its training.
        place: where the frames are, for the error.

    Raises:
        CadetError: there is none.
    """
    names, least = config.class_names, config.training.min_objects
    ids = tuple(i for i, found in labels.items() if sum(label.type in names for label in found) >= least)
    if not ids:
        wanted = ("a " if least == 1 else f"{least} of ") + " or ".join(names)
        there = sorted({label.type for found in labels.values() for label in found})
        raise CadetError(f"{place} holds {wanted} to learn from; their labels have {', '.join(there) or 'no type'}")
    return ids


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
