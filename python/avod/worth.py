"""What frames are worth to a detector: AP on other frames after a fixed, short training on them alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from avod.config import Config
from avod.data.frames import Data
from avod.detector import Detector
from avod.evaluate import analyze_detector
from avod.train import Run, train, with_steps
from cadet.evaluation.analysis import Analysis
from cadet.evaluation.analysis.mending import AS_IT_IS

STEPS: Final = {10: 400, 30: 1_200, 90: 3_700}
"""Steps of the training by about how many minutes of processor time it takes: steps alone decide, so that figures of
different machines can be compared."""

REMEDIES: Final = {
    "size": "objects have other sizes than those of the test: `avod train --sizes-from` or the generator's sizes",
    "vertical": "bottoms and heights differ: look at planes and labels with `cadet check` and `cadet report`",
    "heading": "headings are seldom of the kind that the test has: more crossings and parked objects",
    "place": "boxes stand elsewhere about their points than the test's: compare both with `cadet report`",
    "class": "look-alikes of other classes are rare: frames need the test's other vehicles and people",
    "no duplicates": "objects are found twice: hardly the data",
    "no false alarms": "what stands beside streets is missing: hedges, fences, walls, signs",
    "no misses": "objects as far away, or as hidden, as the test's are rare: denser and deeper streets",
}
"""Errors whose mending is compared, and what in the data they point at."""


@dataclass(frozen=True)
class Worth:
    """What frames are worth.

    Attributes:
        checkpoint: of the detector that learned from them.
        analysis: of its detections in the frames of the test, with errors and intervals.
        gains: points of AP 3D, Moderate, that mending each error of `REMEDIES` would bring, the greatest first.
    """

    checkpoint: Path
    analysis: Analysis
    gains: tuple[tuple[str, float], ...]


def worth(
    config: Config,
    run: Run,
    test: Data,
    ids: tuple[str, ...],
    *,
    draws: int = 300,
    on_step: Callable[[int, dict[str, Any]], None] | None = None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Worth | None:
    """Train a detector and judge it on frames of a test.

    Args:
        config: of the detector, such as `fixed_recipe` gives.
        run: the frames to learn from, and where the training goes.
        test: a KITTI folder with labels, or shards.
        ids: of its frames.
        draws: of frames, for the intervals.
        on_step: called after each step with its number and losses.
        should_stop: called after each step; on True training writes a checkpoint and ends.

    Returns:
        What was found; None if it was told to stop: with `Run.resume` it goes on.

    Raises:
        CadetError: as for `train` and `analyze_detector`.
    """
    last = train(config, run, on_step=on_step, should_stop=should_stop)
    if last.name != f"{config.training.steps:09d}":
        return None
    detector = Detector(last, device=run.device, precision=run.precision)
    analysis = analyze_detector(detector, test, ids, parts=("errors",), bootstrap=draws, workers=run.workers)
    return Worth(last, analysis, _gains(analysis, config.class_names[0]))


def fixed_recipe(minutes: int) -> Config:
    """Return the detector and its training for one of the budgets of `STEPS`."""
    return with_steps(Config.named("center_car"), STEPS[minutes])


def _gains(analysis: Analysis, class_name: str) -> tuple[tuple[str, float], ...]:
    errors = (analysis.errors or {}).get(class_name)
    if errors is None:
        return ()
    level = analysis.report.levels[1].name
    ap = {name: metrics.get("3d", {}).get(level, 0.0) for name, metrics in errors.mended.items()}
    gains = [(name, ap[name] - ap[AS_IT_IS]) for name in REMEDIES]
    return tuple(sorted(gains, key=lambda gain: -gain[1]))
