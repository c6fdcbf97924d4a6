"""The paper's tables of AP.

Source: Brekke, Vatsendvik, Lindseth, "Multimodal 3D Object Detection from Simulated Pretraining", 2019, the tables of
its results. AVOD's evaluation, which it uses, averages precision over 11 recall positions. IoU is above 0.7 for cars
and above 0.5 for pedestrians.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from tools.experiments.cells import REAL, SIM, TUNED
from tools.experiments.scales import MAPS

RULE: Final = "r11"
"""The rule of the paper's numbers."""

_KITTI: Final = ("Easy", "Moderate", "Hard")
_OWN: Final = ("Large", "Small")

# For each configuration of the maps: AP 3D and AP BEV by level.
_Row = tuple[tuple[float, ...], tuple[float, ...]]
_ROWS: Final[Mapping[tuple[str, str, str], tuple[_Row, _Row, _Row]]] = {
    (REAL, REAL, "Car"): (
        ((83.46, 73.94, 67.81), (89.37, 86.44, 78.64)),
        ((83.16, 73.97, 67.98), (89.84, 86.62, 79.85)),
        ((82.98, 73.92, 67.84), (89.62, 86.61, 79.68)),
    ),
    (REAL, REAL, "Pedestrian"): (
        ((41.05, 37.00, 32.00), (44.12, 39.54, 38.11)),
        ((45.61, 42.66, 38.06), (49.16, 45.99, 44.53)),
        ((27.85, 27.17, 24.54), (33.39, 33.10, 29.78)),
    ),
    (SIM, SIM, "Car"): (
        ((70.86, 69.37), (80.13, 71.32)),
        ((70.96, 69.59), (79.81, 71.28)),
        ((68.79, 60.87), (78.75, 70.72)),
    ),
    (SIM, SIM, "Pedestrian"): (
        ((75.43, 73.89), (75.43, 73.91)),
        ((76.13, 72.99), (80.24, 73.41)),
        ((75.49, 71.82), (79.73, 72.37)),
    ),
    (SIM, REAL, "Car"): (
        ((29.85, 20.29, 18.40), (50.58, 37.81, 30.77)),
        ((35.85, 29.40, 24.99), (57.32, 49.63, 43.25)),
        ((30.34, 24.28, 20.25), (45.22, 37.56, 31.17)),
    ),
    (TUNED, REAL, "Car"): (
        ((83.84, 68.67, 67.40), (89.41, 79.77, 78.86)),
        ((76.85, 72.44, 66.55), (88.20, 85.18, 78.71)),
        ((81.00, 66.95, 65.88), (88.76, 79.36, 78.41)),
    ),
    (TUNED, REAL, "Pedestrian"): (
        ((40.26, 38.55, 33.93), (46.96, 44.80, 40.73)),
        ((39.19, 38.02, 34.15), (46.14, 43.54, 40.44)),
        ((37.32, 34.34, 32.60), (45.71, 42.43, 37.62)),
    ),
}


def published_ap(trained: str, tested: str, class_name: str, maps: str, metric: str, level: str) -> float | None:
    """Return the paper's AP in percent; None where it has none.

    Args:
        trained: "sim", "real" or "tuned".
        tested: "sim" or "real".
        class_name: "Car" or "Pedestrian".
        maps: configuration of the bird's-eye-view maps.
        metric: "3d" or "bev".
        level: "Easy", "Moderate" or "Hard" of real frames, "Large" or "Small" of simulated ones.
    """
    rows, levels = _ROWS.get((trained, tested, class_name)), _KITTI if tested == REAL else _OWN
    if rows is None or maps not in MAPS or level not in levels:
        return None
    return rows[MAPS.index(maps)][0 if metric == "3d" else 1][levels.index(level)]
