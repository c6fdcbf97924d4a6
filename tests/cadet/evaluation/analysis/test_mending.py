"""Mending an error that was put in brings AP back; mending another does not. And what the errors of boxes are."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import cadet
from analysis_helpers import car, found, moved, set_of_cars
from cadet.evaluation.analysis.box_errors import differences
from cadet.evaluation.analysis.class_errors import ClassErrors
from cadet.evaluation.analysis.mending import mend_boxes
from cadet.evaluation.analysis.tables import boxes_table
from cadet.formats.kitti import Label

Frames = list[list[Label]]


def errors_of(labels: Frames, detections: Frames, name: str = "Car") -> ClassErrors:
    analysis = cadet.analyze(labels, detections, parts=["errors"], classes=[name], levels="large_small")
    assert analysis.errors is not None
    return analysis.errors[name]


def mended(errors: ClassErrors) -> dict[str, float]:
    return {what: row["3d"]["Small"] for what, row in errors.mended.items()}


def shrunk(label: Label) -> Label:
    """Detect a car as too short and too narrow, its nearest corner in its place."""
    box = np.array([[*label.location_cam, label.dimensions_hwl[2], label.dimensions_hwl[1], 1.5, label.rotation_y]])
    smaller = box.copy()
    smaller[:, 3:5] *= 0.7
    x, _, z = mend_boxes(box, smaller, ("size",))[0, :3]
    height, width, length = label.dimensions_hwl
    return replace(
        label, location_cam=(x, label.location_cam[1], z), dimensions_hwl=(height, 0.7 * width, 0.7 * length), score=0.9
    )


WRONG: dict[str, tuple[Callable[[Label], Label], set[str]]] = {
    "size": (shrunk, {"size", "size, heading", "all but place"}),
    "vertical": (lambda label: moved(label, dy=-0.6), {"vertical", "all but place"}),
    "heading": (
        lambda label: found(label, rotation_y=label.rotation_y + 0.9),
        {"heading", "size, heading", "all but place"},
    ),
    "place": (lambda label: moved(label, dx=0.9, dz=0.9), {"place"}),
}


@pytest.mark.parametrize("kind", WRONG)
def test_mending_the_error_that_was_put_in_brings_all_back(kind: str) -> None:
    make_wrong, cures = WRONG[kind]
    labels = set_of_cars()
    values = mended(errors_of(labels, [[make_wrong(label) for label in here] for here in labels]))
    assert values["as it is"] < 5.0
    # A car that is seen along its middle may be anchored at the other corner when it has shrunk.
    cured = {what for what, value in values.items() if value > 90.0}
    assert cured == cures | {"whole box"}


def test_the_nearest_corner_stays_where_it_is() -> None:
    def corners(box: np.ndarray) -> np.ndarray:
        return cadet_corners(box[None])[0, :4][:, [0, 2]]

    from cadet.formats.kitti.boxes import corners_cam as cadet_corners

    rng = np.random.default_rng(0)
    for _ in range(200):
        box = np.array([rng.uniform(-20, 20), 1.6, rng.uniform(8, 50), 4.0, 1.7, 1.5, rng.uniform(-4, 4)])
        truth = np.array([0.0, 0.0, 0.0, rng.uniform(3, 6), rng.uniform(1.4, 2.5), 1.0, 0.0])
        after = mend_boxes(box[None], truth[None], ("size",))[0]
        assert after[3:5] == pytest.approx(truth[3:5])
        assert np.delete(after, [0, 2, 3, 4]) == pytest.approx(np.delete(box, [0, 2, 3, 4]))
        near = min(corners(box), key=lambda corner: float(np.hypot(*corner)))
        # Exactly one corner is shared, and it is the near one unless two are about as near.
        apart = np.abs(corners(after)[:, None] - corners(box)[None]).max(axis=2)
        assert (apart < 1e-9).sum() == 1
        shared = corners(box)[int(np.argwhere(apart < 1e-9)[0, 1])]
        assert np.hypot(*shared) <= np.hypot(*near) + 0.5


def test_copies_false_alarms_misses_and_classes_are_told_apart() -> None:
    labels = set_of_cars()
    exact = [[found(label, 0.5) for label in here] for here in labels]
    copies = [[*seen, moved(seen[0], dx=1.0, score=0.9)] for seen in exact]
    # The surer copy finds the car first, so the exact one is the duplicate; without it the car is not found.
    assert mended(errors_of(labels, copies))["no duplicates"] < mended(errors_of(labels, copies))["as it is"]
    late = [[*seen, moved(seen[0], dx=1.0, score=0.4)] for seen in exact]
    values = mended(errors_of(labels, late))
    assert values["no duplicates"] == pytest.approx(100.0)
    alarms = [[*seen, found(car(0.0, 70.0), 0.9)] for seen in exact]
    values = mended(errors_of(labels, alarms))
    assert values["no false alarms"] == pytest.approx(100.0)
    assert values["as it is"] == values["no duplicates"] == values["whole box"] < 80.0
    half = [seen[:1] for seen in exact]
    values = mended(errors_of(labels, half))
    assert values["no misses"] == pytest.approx(100.0)
    assert values["as it is"] == values["place"] == values["class"] < 55.0
    taken_for_trucks = [[replace(seen[0], type="Truck"), seen[1]] for seen in exact]
    values = mended(errors_of(labels, taken_for_trucks))
    assert values["class"] == pytest.approx(100.0)
    assert values["as it is"] == values["no false alarms"] < 55.0


def test_false_alarms_are_counted_at_the_best_threshold() -> None:
    labels = set_of_cars()
    alarm = found(car(0.0, 70.0), 0.7)
    detections = [[*(found(label, 0.8) for label in here), *[alarm] * (k % 2)] for k, here in enumerate(labels)]
    errors = errors_of(labels, detections)
    assert errors.operating_point is not None
    assert (errors.operating_point.score, errors.operating_point.precision, errors.operating_point.recall) == (
        0.8,
        1,
        1,
    )
    assert errors.false_alarms_a_frame == 0.0
    surer = [[replace(one, score=0.9 if one.location_cam[2] == 70.0 else 0.8) for one in seen] for seen in detections]
    assert errors_of(labels, surer).false_alarms_a_frame == 0.5


def test_errors_of_boxes_are_what_was_put_in() -> None:
    labels = set_of_cars()
    detections = []
    for here in labels:
        seen = []
        for label in here:
            # 0.3 m ahead and 0.1 m to its side, 0.2 m longer, turned by 4 degrees and the wrong way round.
            c, s = math.cos(label.rotation_y), math.sin(label.rotation_y)
            height, width, length = label.dimensions_hwl
            there = moved(label, 0.3 * c + 0.1 * s, 0.05, -0.3 * s + 0.1 * c)
            turn = label.rotation_y + math.radians(184.0)
            seen.append(replace(there, dimensions_hwl=(height - 0.1, width, length + 0.2), rotation_y=turn))
        detections.append(seen)
    bands = errors_of(labels, detections).boxes
    assert sum(band.n for band in bands) == sum(map(len, labels)) == sum(band.n_reversed for band in bands)
    assert [(band.from_m, band.to_m) for band in bands] == [(0, 15), (15, 30), (30, 45), (45, None)]
    expected = {"along_m": 0.3, "across_m": 0.1, "bottom_m": 0.05, "length_m": 0.2, "width_m": 0.0, "height_m": -0.1}
    for band in bands:
        for name, value in (expected | {"heading_deg": 4.0}).items():
            spread = band.errors[name]
            assert (spread.median, spread.p16, spread.p84) == pytest.approx((value,) * 3, abs=1e-6), name
        # Within the distance that it is off at all.
        assert abs(band.errors["away_m"].median) <= math.hypot(0.3, 0.1)
    near = [[one for one in seen if math.hypot(one.location_cam[0], one.location_cam[2]) < 40.0] for seen in detections]
    fewer = errors_of(labels, near)
    assert [band.n_objects for band in fewer.boxes] == [band.n for band in bands]
    numbers = [f"{band.n} of {band.n_objects}" for band in fewer.boxes]
    assert [band.n for band in fewer.boxes[:2]] == [band.n for band in bands[:2]] and numbers[3] == f"0 of {bands[3].n}"
    rows = boxes_table("Car", fewer).rows
    assert rows[1] == ("found", *numbers) and all(row[4] == "" for row in rows[2:-1])


def test_the_heading_is_folded_and_away_is_along_the_view() -> None:
    truth = np.array([[3.0, 1.0, 4.0, 4.0, 2.0, 1.5, 0.0]])
    there = truth + [0.6, 0.0, 0.8, 0.0, 0.0, 0.0, math.radians(100.0)]
    rows, is_reversed = differences(truth, there)
    assert rows[0] == pytest.approx([0.6, 0.8, 1.0, 0, 0, 0, 0, -80.0])
    assert is_reversed.tolist() == [True]


def test_without_a_usable_detection_there_is_nothing_to_mend() -> None:
    analysis = cadet.analyze([[car()]], [[found(car(kind="Truck"))]], parts=["errors"], classes=["Car"])
    assert analysis.errors == {}
    far = cadet.analyze([[car()]], [[found(car(20.0, 60.0))]], parts=["errors"], classes=["Car"])
    assert far.errors is not None and far.errors["Car"].operating_point is None and far.errors["Car"].boxes == ()
    assert "Car: AP if one kind of error were corrected" in str(far)
