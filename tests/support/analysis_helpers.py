"""Sets of labels and detections with errors of known kinds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cadet.formats.kitti import Label

NUM_FRAMES = 60


def car(x: float = 2.0, z: float = 20.0, rotation_y: float = 0.3, kind: str = "Car", **changes: object) -> Label:
    """Make an object; its box in the image is 60 px high and belongs to its place."""
    left = 600.0 + 700.0 * x / z
    label = Label(
        type=kind,
        truncated=0.0,
        occluded=0,
        alpha=rotation_y - math.atan2(x, z),
        bbox=(left - 40.0, 150.0, left + 40.0, 210.0),
        dimensions_hwl=(1.5, 1.7, 4.1),
        location_cam=(x, 1.6, z),
        rotation_y=rotation_y,
    )
    return replace(label, **changes)  # type: ignore[arg-type]


def found(label: Label, score: float = 0.9, **changes: object) -> Label:
    """Detect an object, by default exactly."""
    return replace(label, score=score, **changes)  # type: ignore[arg-type]


def moved(label: Label, dx: float = 0.0, dy: float = 0.0, dz: float = 0.0, score: float = 0.9) -> Label:
    """Detect an object elsewhere; its box in the image stays."""
    x, y, z = label.location_cam
    return replace(label, location_cam=(x + dx, y + dy, z + dz), score=score)


def set_of_cars() -> list[list[Label]]:
    """Make frames with two cars each, at distances from 8 to 60 m and all headings."""
    rng = np.random.default_rng(5)
    frames = []
    for _ in range(NUM_FRAMES):
        places = ((-8.0, rng.uniform(8, 60)), (8.0, rng.uniform(8, 60)))
        frames.append([car(x, z, rng.uniform(-math.pi, math.pi)) for x, z in places])
    return frames


def shaky_set(
    seed: int, num_frames: int = 40, kinds: tuple[str, ...] = ("Car", "Van", "Pedestrian", "Truck")
) -> tuple[list[list[Label]], list[list[Label]]]:
    """Make labels and detections with every kind of error: misses, copies, wrong types, false alarms, equal scores."""
    rng = np.random.default_rng(seed)
    labels, detections = [], []
    for _ in range(num_frames):
        here = [
            car(rng.uniform(-25, 25), rng.uniform(5, 60), rng.uniform(-3.1, 3.1), str(rng.choice(kinds)))
            for _ in range(rng.integers(0, 7))
        ]
        seen = []
        for label in here:
            for _ in range(rng.choice([0, 1, 1, 1, 2])):
                shift = rng.normal(0, 0.6, 3)
                height, width, length = rng.uniform(0.8, 1.2, 3) * label.dimensions_hwl
                guess = moved(label, shift[0], 0.1 * shift[1], shift[2], round(rng.uniform(0, 1), 1))
                kind = str(rng.choice(kinds)) if rng.random() < 0.2 else label.type
                turn = label.rotation_y + rng.normal(0, 0.3)
                seen.append(replace(guess, type=kind, dimensions_hwl=(height, width, length), rotation_y=turn))
        for _ in range(rng.integers(0, 3)):
            seen.append(found(car(rng.uniform(-25, 25), rng.uniform(5, 60)), round(rng.uniform(0, 0.7), 1)))
        order = rng.permutation(len(seen))
        labels.append(here)
        detections.append([seen[k] for k in order])
    return labels, detections
