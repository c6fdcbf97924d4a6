"""Sizes of a folder's labels: means, and anchors fitted to them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet import kitti
from cadet.errors import CadetError
from cadet.formats.webdataset import open_dataset

_RESTARTS: Final = 40
_MOST_ROUNDS: Final = 200


def anchor_sizes(root: str | Path, split: str | None, counts: Mapping[str, int]) -> dict[str, NDArray[np.float64]]:
    """Fit anchor sizes to the labels of a folder by k-means on length, width and height in meters.

    Args:
        root: a KITTI folder with labels, or a folder of shards.
        split: a list of its `ImageSets`; None for every frame.
        counts: how many sizes each class gets.

    Returns:
        For each class (K, 3) lengths, widths and heights, the shortest first.

    Raises:
        CadetError: a class with fewer different sizes than it is to get.
    """
    dataset = open_dataset(root, split)
    sizes: dict[str, list[tuple[float, float, float]]] = {name: [] for name in counts}
    for frame_id in dataset.ids:
        for label in dataset.read_labels(frame_id):
            if label.type in sizes:
                height, width, length = label.dimensions_hwl
                sizes[label.type].append((length, width, height))
    fitted = {}
    for name, count in counts.items():
        rows = np.array(sizes[name], np.float64).reshape(-1, 3)
        if len(np.unique(rows, axis=0)) < count:
            raise CadetError(
                f"{root}: expected labels of {name} in at least {count} sizes, got {len(np.unique(rows, axis=0))} "
                f"among {len(rows)} labels of {len(dataset.ids)} frames"
            )
        centers = k_means(rows, count)
        fitted[name] = centers[np.argsort(centers[:, 0], kind="stable")]
    return fitted


def mean_sizes(labels: Iterable[kitti.Label], names: Sequence[str]) -> dict[str, NDArray[np.float64]]:
    """Return the mean (3,) length, width, and height in meters of each class that has labels."""
    sizes: dict[str, list[tuple[float, float, float]]] = {}
    for label in labels:
        if label.type in names:
            height, width, length = label.dimensions_hwl
            sizes.setdefault(label.type, []).append((length, width, height))
    return {name: np.mean(rows, axis=0) for name, rows in sizes.items()}


def mean_sizes_of(root: str | Path, names: Sequence[str]) -> tuple[tuple[float, float, float], ...]:
    """Return the mean (l, w, h) of each class among all labels of a folder, meters, to the millimeter.

    Raises:
        CadetError: a class without a label there.
    """
    dataset = open_dataset(root)
    labels = (label for frame_id in dataset.ids for label in dataset.read_labels(frame_id))
    found = mean_sizes(labels, names)
    for name in names:
        if name not in found:
            raise CadetError(f"{root}: none of {len(dataset)} frames has a label of {name}, whose mean size is wanted")
    means = [found[name].round(3).tolist() for name in names]
    return tuple((length, width, height) for length, width, height in means)


def k_means(points: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Find centers with a small sum of squared distances from points to their nearest ones.

    Lloyd's iteration from several starts, each drawn by k-means++ from a fixed stream; the best is kept.

    Args:
        points: (N, D), at least `count` different ones.
        count: of centers.

    Returns:
        (count, D), in no particular order.

    Reference: Arthur and Vassilvitskii, "k-means++: The Advantages of Careful Seeding" (2007).
    """
    best, least = points[:count], np.inf
    for start in range(_RESTARTS):
        centers = _spread(points, count, np.random.default_rng([start, count]))
        for _ in range(_MOST_ROUNDS):
            nearest = _squared_distances(points, centers).argmin(axis=1)
            moved = np.stack(
                [points[nearest == k].mean(axis=0) if (nearest == k).any() else centers[k] for k in range(count)]
            )
            if np.array_equal(moved, centers):
                break
            centers = moved
        cost = float(_squared_distances(points, centers).min(axis=1).sum())
        if cost < least:
            best, least = centers, cost
    return best


def toml_of(sizes: Mapping[str, NDArray[np.float64]]) -> str:
    """Write sizes as a configuration holds them."""
    tables = []
    for name, rows in sizes.items():
        listed = ", ".join("[" + ", ".join(f"{value:.3f}" for value in row) + "]" for row in rows)
        tables.append(f'[[classes]]\nname = "{name}"\nanchor_sizes_lwh_m = [{listed}]\n')
    return "\n".join(tables)


def _spread(points: NDArray[np.float64], count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Choose points as first centers, far ones with a higher probability."""
    chosen = [points[rng.integers(len(points))]]
    while len(chosen) < count:
        away = _squared_distances(points, np.stack(chosen)).min(axis=1)
        place = int(np.searchsorted(np.cumsum(away), rng.random() * away.sum(), side="right"))
        chosen.append(points[min(place, len(points) - 1)])
    return np.stack(chosen)


def _squared_distances(points: NDArray[np.float64], centers: NDArray[np.float64]) -> NDArray[np.float64]:
    distances: NDArray[np.float64] = ((points[:, None] - centers[None]) ** 2).sum(axis=2)
    return distances
