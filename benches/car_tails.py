"""Says where returns lie on the tails of cars, from the near ends of their boxes: a KITTI folder's, real or generated.

    python benches/car_tails.py DATA

Cars that nothing hides, seen from behind within 15 degrees and 30 m. A cell is the median over cars of the median
place, in cm, positive toward the sensor, of the returns at a height and a lateral place; and the number of cars.
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import cadet
from cadet.kitti import Dataset

_HEIGHTS_M = ((0.20, 0.45), (0.45, 0.65), (0.65, 0.85), (0.85, 1.05), (1.05, 1.30))
_LATERAL_OF_WIDTH = (0.0, 0.1, 0.2, 0.3, 0.4, 0.47)
_WITHIN_M = 30.0
_ASLANT_DEG = 15.0
_DEEPEST_M = 0.6
_LEAST_RETURNS = 3


def tails(frame: cadet.Frame) -> list[NDArray[np.float64]]:
    """For each car that counts (N, 3), its returns: beyond the near end, share of the width, height over the bottom."""
    points_cam = frame.calib.points_cam_from_velo(frame.points_velo[:, :3])
    found = []
    for label in frame.labels:
        is_whole = label.occluded == 0 and label.truncated <= 0.05
        if label.type != "Car" or not is_whole:
            continue
        x, y, z, length, width, height, rotation_y = label.box_cam
        cos, sin = np.cos(rotation_y), np.sin(rotation_y)
        to_sensor = np.array([-(cos * x - sin * z), -(sin * x + cos * z)])
        # Seen from behind: the sensor is on the side that the box does not head to.
        if np.hypot(x, z) > _WITHIN_M or to_sensor[0] > 0.0:
            continue
        if np.degrees(np.arctan2(abs(to_sensor[1]), -to_sensor[0])) > _ASLANT_DEG:
            continue
        at = points_cam - (x, y, z)
        along, across, up = cos * at[:, 0] - sin * at[:, 2], sin * at[:, 0] + cos * at[:, 2], -at[:, 1]
        beyond = -along - length / 2.0
        kept = (beyond > -_DEEPEST_M) & (beyond < 0.5) & (np.abs(across) < width / 2.0 + 0.1) & (up < height + 0.3)
        found.append(np.stack([beyond[kept], np.abs(across[kept]) / width, up[kept]], axis=1))
    return found


def main(root: Path) -> None:
    """Print the table."""
    cars = [tail for frame in Dataset(root) for tail in tails(frame)]
    shares = ", ".join(f"{share:g}" for share in _LATERAL_OF_WIDTH[1:])
    print(f"{len(cars)} cars; lateral places up to {shares} of the width")
    for low, high in _HEIGHTS_M:
        cells = []
        for first, last in itertools.pairwise(_LATERAL_OF_WIDTH):
            medians = []
            for beyond, lateral, up in (car.T for car in cars):
                here = (lateral >= first) & (lateral < last) & (up >= low) & (up < high)
                if here.sum() >= _LEAST_RETURNS:
                    medians.append(np.median(beyond[here]))
            cells.append(f"{100.0 * np.median(medians):+.1f} ({len(medians)})" if medians else "-")
        print(f"{low:.2f} to {high:.2f} m: " + ", ".join(cells))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
