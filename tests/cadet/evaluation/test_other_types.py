"""Types that KITTI does not have: evaluated when asked, counted when not, refused by name where nothing has them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import cadet
from cadet import CadetError, EvalClass
from cadet.formats.kitti import Label
from evaluation_helpers import DONT_CARE, detected, make_object, write

CAR, CONE, SMALL = make_object(), make_object("Trafficcone", 1), make_object("trafficcone", 2)
GT: list[list[Label]] = [[CAR, CONE, SMALL, make_object("Bus", 3), DONT_CARE]] * 50
DET: list[list[Label]] = [
    [detected(CAR), detected(CONE, 0.8), detected(SMALL, 0.7), detected(CAR, 0.6, type="Bike")]
] * 50


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    return write(tmp_path / "label_2", GT), write(tmp_path / "det", DET)


def test_another_type_is_evaluated_like_kittis(folders: tuple[Path, Path]) -> None:
    renamed = [
        [[replace(label, type="Car") for label in labels if label.type.lower() == "trafficcone"] for labels in side]
        for side in (GT, DET)
    ]
    expected = cadet.evaluate(*renamed, classes=["Car"], min_overlap={"Car": 0.5})
    for sides in (folders, (GT, DET)):
        report = cadet.evaluate(*sides, classes=["TrafficCone"], min_overlap={"TrafficCone": 0.5})
        assert report.ap["TrafficCone"] == expected.ap["Car"]
        assert report.n_gt["TrafficCone"] == expected.n_gt["Car"]
        own = EvalClass("cones", ("trafficcone",), (0.5, 0.5, 0.5), neighbors=("Bus",))
        assert cadet.evaluate(*sides, classes=[own]).ap["cones"] == expected.ap["Car"]


def test_what_takes_no_part_is_counted_on_both_sides(folders: tuple[Path, Path]) -> None:
    for sides in (folders, (GT, DET)):
        report = cadet.evaluate(*sides, classes=["Car"])
        assert report.warnings == (
            "150 objects are of types that KITTI does not have, and take no part: Trafficcone (100), Bus (50).",
            "150 detections are of types that KITTI does not have, and take no part: Trafficcone (100), Bike (50).",
        )
        report = cadet.evaluate(*sides, classes=["Trafficcone"], min_overlap={"Trafficcone": 0.5})
        assert [warning.partition(": ")[2] for warning in report.warnings] == ["Bus (50).", "Bike (50)."]


def test_letter_case_and_limits_are_asked_for_by_name(folders: tuple[Path, Path]) -> None:
    assert cadet.evaluate(*folders, classes=["car"], min_overlap={"CAR": 0.5}).ap.keys() == {"Car"}
    with pytest.raises(CadetError, match=r"^class Cone: neither labels nor results have the type Cone; they have "):
        cadet.evaluate(*folders, classes=["Cone"], min_overlap={"Cone": 0.5})
    with pytest.raises(CadetError, match=r"^min_overlap\['Cone'\]: no limit for 2d, and KITTI sets none; give one"):
        cadet.evaluate(*folders, classes=["Cone"])
    with pytest.raises(CadetError, match=r"^min_overlap: 'Cone' is not one of the classes Car"):
        cadet.evaluate(*folders, classes=["Car"], min_overlap={"Cone": 0.5})


def test_an_analysis_tells_them_apart(folders: tuple[Path, Path]) -> None:
    wrong = [[*labels[:1], replace(labels[1], type="Bus", score=0.8)] for labels in DET]
    for sides in ((GT, wrong), (folders[0], {f"{index:06d}": labels for index, labels in enumerate(wrong)})):
        found = cadet.analyze(
            *sides,
            parts=("confusion", "errors"),
            classes=["Bus", "Trafficcone"],
            min_overlap={"Bus": 0.5, "Trafficcone": 0.5},
        )
        assert found.confusion is not None and found.errors is not None
        assert found.confusion.counts["Trafficcone"] == {"Car": 0, "Bus": 50, "missed": 50}
        assert found.confusion.counts["Bus"]["missed"] == 50
        # All that was found as a bus was a cone.
        assert found.errors["Bus"].mended["class"] == {}
