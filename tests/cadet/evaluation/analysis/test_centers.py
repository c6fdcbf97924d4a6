"""nuScenes' AP and errors: against its rules written plainly, and in closed form."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import cadet
from analysis_helpers import car, found, moved, set_of_cars, shaky_set
from cadet.evaluation.analysis.centers import CenterAp
from cadet.formats.kitti import Label

Frames = list[list[Label]]


def centers(labels: Frames, detections: Frames, name: str = "Car") -> CenterAp:
    result = cadet.analyze(labels, detections, parts=["centers"], classes=[name]).centers
    assert result is not None
    return result[name]


def plainly(labels: Frames, detections: Frames, name: str, range_m: float, limit_m: float) -> dict[str, float]:
    """Write nuScenes' rules down for one class, ranking the whole set at once."""

    def is_near(label: Label) -> bool:
        return math.hypot(label.location_cam[0], label.location_cam[2]) < range_m

    ranking = [
        (label.score or 0.0, frame, label)
        for frame, seen in enumerate(detections)
        for label in seen
        if label.type == name and is_near(label)
    ]
    ranking.sort(key=lambda entry: -entry[0])
    there = [[label for label in here if label.type == name and is_near(label)] for here in labels]
    left = [list(here) for here in there]
    num_gt = sum(map(len, there))
    hits: list[bool] = []
    scores: list[float] = []
    errors: list[tuple[float, float, float, float]] = []
    for score, frame, label in ranking:
        apart = [
            math.hypot(a.location_cam[0] - label.location_cam[0], a.location_cam[2] - label.location_cam[2])
            for a in left[frame]
        ]
        hit = bool(apart) and min(apart) < limit_m
        if hit:
            truth = left[frame].pop(apart.index(min(apart)))
            small = math.prod(map(min, truth.dimensions_hwl, label.dimensions_hwl))
            union = math.prod(truth.dimensions_hwl) + math.prod(label.dimensions_hwl) - small
            turn = math.acos(max(-1.0, min(1.0, math.cos(truth.rotation_y - label.rotation_y))))
            errors.append((score, min(apart), 1 - small / union, turn))
        hits.append(hit)
        scores.append(score)
    recall, precision = np.cumsum(hits) / num_gt, np.cumsum(hits) / np.arange(1, len(hits) + 1)
    steps = np.linspace(0, 1, 101)
    heights = list(np.interp(steps, recall, precision, right=0)[11:])
    ap = sum(max(p - 0.1, 0.0) for p in heights) / len(heights) / 0.9
    at = np.interp(steps, recall, scores, right=0)
    last = max(k for k in range(101) if steps[k] <= recall[-1])
    result = {"ap": 100 * ap, "n_gt": num_gt, "n_detections": len(ranking)}
    for column, key in ((1, "ate_m"), (2, "ase"), (3, "aoe_rad")):
        means = [sum(e[column] for e in errors[: k + 1]) / (k + 1) for k in range(len(errors))]
        curve = np.interp(at[::-1], [e[0] for e in errors][::-1], means[::-1])[::-1]
        result[key] = float(np.mean(curve[11 : last + 1])) if last >= 11 else 1.0
    return result


@pytest.mark.parametrize("seed", range(4))
def test_the_rules_written_plainly_give_the_same(seed: int) -> None:
    # Without vans, which are the car's neighbors in KITTI and unknown to nuScenes.
    labels, detections = shaky_set(seed, kinds=("Car", "Pedestrian", "Truck"))
    for name, range_m in (("Car", 50.0), ("Pedestrian", 40.0)):
        result = centers(labels, detections, name)
        for limit_m in (0.5, 1.0, 2.0, 4.0):
            expected = plainly(labels, detections, name, range_m, limit_m)
            assert result.ap[f"{limit_m:g}"] == pytest.approx(expected["ap"], abs=1e-9), (name, limit_m)
        expected = plainly(labels, detections, name, range_m, 2.0)
        for key in ("ate_m", "ase", "aoe_rad", "n_gt", "n_detections"):
            assert getattr(result, key) == pytest.approx(expected[key], abs=1e-9), (name, key)
        assert result.mean_ap == pytest.approx(np.mean(list(result.ap.values())))


def test_a_perfect_result_has_no_errors() -> None:
    labels = set_of_cars()
    result = centers(labels, [[found(label) for label in here] for here in labels])
    assert list(result.ap.values()) == pytest.approx([100.0] * 4)
    assert (result.ate_m, result.ase, result.aoe_rad) == pytest.approx((0.0, 0.0, 0.0), abs=1e-7)


def test_errors_are_what_was_put_in() -> None:
    # No car lies so near the limit of the range that its detection lies beyond.
    labels = [[label for label in here if label.location_cam[2] < 45.0] for here in set_of_cars()]
    wrong = [
        [
            replace(
                moved(label, dx=0.42, dz=-0.56),
                dimensions_hwl=(3.0, 3.4, 8.2),
                rotation_y=label.rotation_y + 2 * math.pi - 0.25,
            )
            for label in here
        ]
        for here in labels
    ]
    result = centers(labels, wrong)
    assert (result.ate_m, result.ase, result.aoe_rad) == pytest.approx((0.7, 1 - 1 / 8, 0.25))
    # 0.7 m off: only the narrowest limit fails.
    assert result.ap == pytest.approx({"0.5": 0.0, "1": 100.0, "2": 100.0, "4": 100.0})


def test_a_ranking_that_never_reaches_a_tenth_of_recall_has_errors_of_one() -> None:
    labels = [[car()]] * 30
    result = centers(labels, [[found(car())]] * 2 + [[]] * 28)
    assert (result.ate_m, result.ase, result.aoe_rad, result.mean_ap) == (1.0, 1.0, 1.0, 0.0)


def test_neighbors_and_unlabeled_regions_are_neither_right_nor_wrong() -> None:
    van = car(-8.0, 25.0, kind="Van")
    region = Label("DontCare", -1, -1, -10, (300.0, 80.0, 420.0, 160.0), (-1, -1, -1), (-1000, -1000, -1000), -10)
    ghost = replace(found(car(-3.0, 40.0), 0.99), bbox=(310.0, 90.0, 400.0, 150.0))
    labels = [[car(), van, region]] * 30
    detections = [[found(car(), 0.5), replace(found(van, 0.95), type="Car"), ghost]] * 30
    result = centers(labels, detections)
    assert result.mean_ap == pytest.approx(100.0)
    assert (result.n_gt, result.n_detections) == (30, 30)
    # The same detection outside the region is a false alarm in every frame.
    outside = [[*seen[:2], replace(ghost, bbox=(800.0, 90.0, 890.0, 150.0))] for seen in detections]
    assert centers(labels, outside).mean_ap < 60.0
