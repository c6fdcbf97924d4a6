"""The numbers of a dataset: histograms of its labels by class, and what its records say of the frames."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.plain_text import json_from_text
from cadet.datasets.report.quantities import CLASSES, LABEL_QUANTITIES, OBJECTS, POINTS, QUANTITIES, values_of
from cadet.errors import FileFormatError
from cadet.formats.kitti import Label

KITTI_FILE: Final = Path(__file__).parent / "kitti_statistics.json"
"""Of the 7,481 label files of KITTI's object training set (Geiger, Lenz, and Urtasun, 2012); of the points, of 200 of
these. `benches/kitti_statistics.py` makes it."""


@dataclass
class Statistics:
    """Counts that grow frame by frame.

    Attributes:
        num_frames: frames counted.
        labels: by type, DontCare included.
        histograms: counts by bin of a quantity of `QUANTITIES`, by class.
        num_frames_with: frames with at least one object of a class.
    """

    num_frames: int = 0
    labels: Counter[str] = field(default_factory=Counter)
    histograms: dict[str, dict[str, NDArray[np.int64]]] = field(default_factory=dict)
    num_frames_with: Counter[str] = field(default_factory=Counter)

    def add(self, labels: Iterable[Label], num_points: Iterable[int] | None = None) -> None:
        """Count a frame's labels.

        Args:
            labels: all of its label file's.
            num_points: returns in the box of each label but DontCare, in their order; None where no scan is known.
        """
        labels = tuple(labels)
        objects = [label for label in labels if not label.is_dont_care]
        points = None if num_points is None else list(num_points)
        self.num_frames += 1
        self.labels.update(label.type for label in labels)
        for name in CLASSES:
            chosen = [index for index, label in enumerate(objects) if label.type == name]
            self._count(OBJECTS.name, name, [len(chosen)])
            if not chosen:
                continue
            self.num_frames_with[name] += 1
            values = values_of([objects[index] for index in chosen])
            for quantity in LABEL_QUANTITIES:
                self._count(quantity.name, name, values[quantity.name])
            if points is not None:
                self._count(POINTS.name, name, [points[index] for index in chosen])

    def merge(self, other: Statistics) -> None:
        """Add the counts of other frames."""
        self.num_frames += other.num_frames
        self.labels.update(other.labels)
        self.num_frames_with.update(other.num_frames_with)
        for quantity, by_class in other.histograms.items():
            for name, counts in by_class.items():
                self._add(quantity, name, counts)

    def counts(self, quantity: str, name: str) -> NDArray[np.int64]:
        """Return the counts by bin of a quantity and class; zeros where nothing was counted."""
        none = np.zeros(QUANTITIES[quantity].num_bins, np.int64)
        return self.histograms.get(quantity, {}).get(name, none)

    def to_text(self) -> str:
        """Write the counts as JSON, a histogram a line."""
        head = {"num_frames": self.num_frames, "labels": self.labels, "num_frames_with": self.num_frames_with}
        lines = [f' "{key}": {json.dumps(value)}' for key, value in head.items()]
        lines += [
            f'  "{quantity}": {{\n'
            + ",\n".join(f'   "{name}": {json.dumps(counts.tolist())}' for name, counts in by_class.items())
            + "\n  }"
            for quantity, by_class in self.histograms.items()
        ]
        num_head = len(head)
        return (
            "{\n" + ",\n".join(lines[:num_head]) + ',\n "histograms": {\n' + ",\n".join(lines[num_head:]) + "\n }\n}\n"
        )

    @classmethod
    def from_text(cls, text: str | bytes, file: str) -> Statistics:
        """Read what `to_text` wrote.

        Raises:
            FileFormatError: no such JSON, or histograms of other bins.
        """
        content = json_from_text(text, file)
        try:
            histograms = {
                quantity: {name: _checked(quantity, counts) for name, counts in by_class.items()}
                for quantity, by_class in content["histograms"].items()
            }
            counters = Counter(content["labels"]), Counter(content["num_frames_with"])
            return cls(int(content["num_frames"]), counters[0], histograms, counters[1])
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise FileFormatError(f"invalid statistics: {error}", file) from None

    def _count(self, quantity: str, name: str, values: list[int] | NDArray[np.float64]) -> None:
        self._add(quantity, name, QUANTITIES[quantity].count(np.asarray(values, np.float64)))

    def _add(self, quantity: str, name: str, counts: NDArray[np.int64]) -> None:
        by_class = self.histograms.setdefault(quantity, {})
        by_class[name] = by_class[name] + counts if name in by_class else counts


def kitti_statistics() -> Statistics:
    """Return the statistics of KITTI's labels; see `KITTI_FILE`."""
    return Statistics.from_text(KITTI_FILE.read_bytes(), KITTI_FILE.name)


def _checked(quantity: str, counts: Any) -> NDArray[np.int64]:
    array = np.asarray(counts, np.int64)
    if array.shape != (QUANTITIES[quantity].num_bins,):
        raise ValueError(f"{quantity}: {len(array)} bins, expected {QUANTITIES[quantity].num_bins}")
    return array


def shares(counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return each bin's share of all; zeros where nothing was counted."""
    return counts / max(int(counts.sum()), 1)


def mix(counts: Mapping[str, int]) -> list[tuple[str, int, float]]:
    """Return names, counts, and shares, the most frequent first."""
    total = max(sum(counts.values()), 1)
    return [(name, count, count / total) for name, count in sorted(counts.items(), key=lambda one: (-one[1], one[0]))]
