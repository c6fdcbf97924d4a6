"""KITTI's rules one by one, on cases small enough to work out by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet.evaluation import Level
from cadet.formats.kitti import Label
from evaluation_helpers import DONT_CARE, detected, make_object, write

FULL = 41
"""Objects enough for a perfect result to get 100."""


def copies(label: Label, count: int = FULL) -> list[list[Label]]:
    return [[label] for _ in range(count)]


def moderate(gt: list[list[Label]], det: list[list[Label]], metric: str = "3d", name: str = "Car") -> float:
    return cadet.evaluate(gt, det).ap[name][metric]["Moderate"]


def test_a_perfect_result_gets_100_from_41_objects_on() -> None:
    car = make_object()
    report = cadet.evaluate(copies(car), copies(detected(car)))
    assert set(report.ap["Car"]) == {"2d", "bev", "3d", "aos", "ahs_bev", "ahs_3d"}
    assert all(value == pytest.approx(100.0) for row in report.ap["Car"].values() for value in row.values())
    assert set(report.ap) == {"Car"}
    assert report.best_ap == {"Car": {"Easy": 100.0, "Moderate": 100.0, "Hard": 100.0}}


def test_few_objects_are_warned_of() -> None:
    car = make_object()
    report = cadet.evaluate(copies(car, 10), copies(detected(car), 10))
    assert report.ap["Car"]["3d"]["Easy"] == pytest.approx(22.5)
    assert any("Car Easy: only 10 objects" in warning and "22.50" in warning for warning in report.warnings)
    full = cadet.evaluate(copies(car), copies(detected(car)), classes=["Car"])
    assert full.warnings == ()


def test_half_found_with_as_many_wrong_ones_behind() -> None:
    car = make_object()
    gt = copies(car, 80)
    det = [[detected(car, 0.9)] if index < 40 else [detected(make_object(column=3), 0.5)] for index in range(80)]
    # Thresholds lie at recall 0, 1/40, ..., 1/2, all at the score 0.9, where nothing is wrong: 20 of 40 positions.
    assert moderate(gt, det) == pytest.approx(50.0)
    wrong_first = [[detected(label, 1.0 - label.score) for label in labels if label.score] for labels in det]
    # Now all wrong ones stand before the first right one: precision 40 / 80.
    assert moderate(gt, wrong_first) == pytest.approx(25.0)


def test_heading_similarity_is_what_cosines_say() -> None:
    car = make_object()
    det = copies(detected(car, alpha=car.alpha + np.pi / 2, rotation_y=car.rotation_y + np.pi))
    ap = cadet.evaluate(copies(car), det).ap["Car"]
    assert ap["2d"]["Easy"] == ap["3d"]["Easy"] == 100.0
    assert ap["aos"]["Easy"] == pytest.approx(50.0)
    assert ap["ahs_bev"]["Easy"] == pytest.approx(0.0, abs=1e-9)
    assert ap["ahs_3d"]["Easy"] == pytest.approx(0.0, abs=1e-9)


def test_one_unknown_observation_angle_switches_aos_off_for_all() -> None:
    car, walker = make_object(), make_object("Pedestrian", 1)
    det = [[detected(car), detected(walker, alpha=-10.0 if index == 7 else 0.0)] for index in range(FULL)]
    report = cadet.evaluate([[car, walker]] * FULL, det)
    assert all("aos" not in report.ap[name] and "ahs_3d" in report.ap[name] for name in ("Car", "Pedestrian"))
    assert any("AOS" in warning for warning in report.warnings)


def test_an_overlap_of_exactly_the_limit_is_no_match() -> None:
    # Two boxes of length 3 that share 2: 2 / 4, exact in binary.
    car = Label("Pedestrian", 0, 0, 0, (0, 100, 96, 164), (1.5, 2.0, 3.0), (0, 1.5, 16), 0.0)
    shifted = detected(car, bbox=(32.0, 100.0, 128.0, 164.0), location_cam=(1.0, 1.5, 16.0))
    for metric in ("2d", "bev", "3d"):
        assert moderate(copies(car), copies(shifted), metric, "Pedestrian") == 0.0
        limits = {"Pedestrian": 0.4999999}
        assert (
            cadet.evaluate(copies(car), copies(shifted), min_overlap=limits).ap["Pedestrian"][metric]["Easy"] == 100.0
        )


def test_the_neighbor_class_is_neither_right_nor_wrong() -> None:
    car, van, truck = make_object(), make_object("Van", 1), make_object("Truck", 2)
    as_cars = [[detected(car, 0.5), detected(van, 0.9, type="Car")]] * FULL
    assert moderate([[car, van]] * FULL, as_cars) == 100.0
    as_cars = [[detected(car, 0.5), detected(truck, 0.9, type="Car")]] * FULL
    assert moderate([[car, truck]] * FULL, as_cars) == pytest.approx(50.0)


def test_dont_care_regions_excuse_in_2d_alone() -> None:
    car = make_object()
    stuff = detected(make_object(column=5), 0.95, bbox=(300.0, 80.0, 319.0, 121.0))
    region = Label("DontCare", -1, -1, -10, (290.0, 70.0, 330.0, 125.0), (-1, -1, -1), (-1000, -1000, -1000), -10)
    det = [[detected(car), stuff]] * FULL
    assert moderate([[car, region]] * FULL, det, "2d") == 100.0
    assert moderate([[car, region]] * FULL, det, "bev") == pytest.approx(50.0)
    assert moderate([[car]] * FULL, det, "2d") == pytest.approx(50.0)


def test_a_detection_without_a_place_is_excused_from_above_beside_a_region() -> None:
    """KITTI's program builds the box of DontCare's marks, and the detection's marks coincide with it."""
    car = make_object()
    flat = detected(
        make_object(column=5), 0.95, dimensions_hwl=(-1, -1, -1), location_cam=(-1000, -1000, -1000), rotation_y=-10.0
    )
    det = [[detected(car), flat]] * FULL
    with_region = cadet.evaluate([[car, DONT_CARE]] * FULL, det).ap["Car"]
    without = cadet.evaluate([[car]] * FULL, det).ap["Car"]
    assert with_region["bev"]["Easy"] == 100.0
    assert with_region["3d"]["Easy"] == without["bev"]["Easy"] == without["3d"]["Easy"] == pytest.approx(50.0)


def test_heights_on_the_limit_count_for_detections_and_not_for_objects() -> None:
    car = make_object(height_px=25.0)
    report = cadet.evaluate(copies(car), copies(detected(car)))
    assert report.n_gt["Car"]["2d"] == {"Easy": 0, "Moderate": 0, "Hard": 0}
    inclusive = cadet.evaluate(copies(car), copies(detected(car)), levels=[Level("All", 25.0, True)])
    assert inclusive.ap["Car"]["2d"] == {"All": 100.0}
    lower = detected(car, bbox=(20.0, 100.0, 100.0, 124.99))
    inclusive = cadet.evaluate(copies(car), copies(lower), levels=[Level("All", 25.0, True)])
    assert (inclusive.ap["Car"]["2d"], inclusive.n_thresholds["Car"]["2d"]) == ({"All": 0.0}, {"All": 0})


@pytest.mark.parametrize(
    ("changes", "counts"),
    [
        ({"truncated": 0.15}, (1, 1, 1)),
        ({"truncated": 0.16}, (0, 1, 1)),
        ({"truncated": 0.5, "occluded": 2}, (0, 0, 1)),
        ({"occluded": 1}, (0, 1, 1)),
        ({"occluded": 3}, (0, 0, 0)),
        ({"height_px": 40.0}, (0, 1, 1)),
    ],
)
def test_levels_have_kittis_limits(changes: dict[str, float], counts: tuple[int, ...]) -> None:
    car = make_object(**changes)  # type: ignore[arg-type]
    report = cadet.evaluate([[car]], [[detected(car)]])
    assert tuple(report.n_gt["Car"]["3d"].values()) == counts


def test_a_small_detection_of_another_class_takes_the_object_from_a_surer_right_one() -> None:
    car = make_object()
    small = detected(make_object("Tram"), 0.95, bbox=(20.0, 100.0, 100.0, 124.0))
    det = [[detected(car), small]] * FULL
    assert cadet.evaluate([[car]] * FULL, det).n_thresholds["Car"]["3d"] == {"Easy": 0, "Moderate": 0, "Hard": 0}


def test_nothing_over_nothing_is_0() -> None:
    """Pass 1 gives the valid car a detection; in pass 2 an ignored one, first in the file, takes it."""
    hidden, car = make_object(occluded=3), make_object()
    near = detected(car, 0.9)
    decoy = detected(car, 0.95, bbox=(20.0, 100.0, 100.0, 120.0), location_cam=(-20.0, 1.5, 20.1))
    report = cadet.evaluate([[hidden, car]], [[near, decoy]], recall="r11")
    curve = report.curves["Car"]["3d"]["Easy"]
    assert (curve.num_tp, curve.num_fp) == ((0,), (0,))
    assert report.ap["Car"]["3d"]["Easy"] == 0.0


def test_letter_case_does_not_matter_and_unknown_names_are_told(tmp_path: Path) -> None:
    car = make_object()
    gt = write(tmp_path / "label_2", copies(car))
    det = write(tmp_path / "det", copies(detected(car)))
    for path in det.iterdir():
        path.write_text(path.read_text().replace("Car", "cAR") + path.read_text().replace("Car", "Lorry"))
    report = cadet.evaluate(gt, det)
    assert report.ap["Car"]["3d"]["Easy"] == 100.0
    assert "41 detections are of types that KITTI does not have, and take no part: Lorry (41)." in report.warnings


def test_what_a_detector_does_not_say_is_absent() -> None:
    car = make_object()
    flat = detected(car, dimensions_hwl=(-1.0, 1.75, 4.0), location_cam=(-20.0, -1000.0, 20.0))
    ap = cadet.evaluate(copies(car), copies(flat)).ap["Car"]
    assert set(ap) == {"2d", "bev", "aos", "ahs_bev"}
    assert ap["bev"]["Easy"] == 100.0
