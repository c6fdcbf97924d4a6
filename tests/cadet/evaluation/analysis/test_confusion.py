"""Confusion of classes, best thresholds, own rules, and the result as a whole."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import cadet
from analysis_helpers import car, found, moved, shaky_set
from cadet import CadetError, EvalClass, Level
from cadet.cli.tools import cadet as command
from cadet.evaluation import LEVELS, Rules
from cadet.evaluation.analysis.bins import parse_by
from cadet.formats.kitti import Label, text_from_labels

RULES = """
[[level]]
name = "Any"
min_height_px = 10
inclusive = true

[[level]]
name = "Seen"
min_height_px = 25
max_occlusion = 0
max_truncation = 0.1

[class.Car]
min_overlap = 0.5
neighbors = ["Van"]

[class.Vehicle]
types = ["Car", "Van", "Truck"]
neighbors = ["Misc"]
min_overlap = { 2d = 0.7, bev = 0.5, 3d = 0.25 }
"""


def test_confusion_is_what_was_put_in() -> None:
    region = Label("DontCare", -1, -1, -10, (300.0, 80.0, 420.0, 160.0), (-1, -1, -1), (-1000, -1000, -1000), -10)
    walker, van = car(-9.0, 12.0, kind="Pedestrian"), car(9.0, 40.0, kind="Van")
    labels = [[car(), walker, van, region]] * 10
    excused = replace(found(car(-3.0, 50.0), 0.9), bbox=(310.0, 90.0, 400.0, 150.0))
    detections = [
        [
            found(car(), 0.8) if k < 7 else replace(found(car(), 0.8), type="Pedestrian"),
            *([found(walker, 0.7)] if k < 6 else []),
            *([replace(moved(van, dx=1.0), type="Car")] if k < 4 else []),
            *([found(car(0.0, 70.0), 0.9)] if k < 3 else []),
            # Less sure than the best threshold of its class.
            *([found(car(0.0, 80.0), 0.1)] if k < 9 else []),
            excused,
        ]
        for k in range(10)
    ]
    result = cadet.analyze(labels, detections, parts=["confusion"]).confusion
    assert result is not None
    assert result.counts == {
        "Car": {"Car": 7, "Pedestrian": 3, "missed": 0},
        "Van": {"Car": 4, "Pedestrian": 0, "missed": 6},
        "Pedestrian": {"Car": 0, "Pedestrian": 6, "missed": 4},
        "background": {"Car": 3, "Pedestrian": 0, "missed": 0},
    }
    assert result.least_scores == {"Car": 0.8, "Pedestrian": 0.7}


@pytest.mark.parametrize("seed", range(3))
def test_objects_are_confused_or_missed_once(seed: int) -> None:
    labels, detections = shaky_set(seed)
    result = cadet.analyze(
        labels, detections, parts=["confusion"], classes=["Car", "Van"], min_overlap={"Van": 0.5}
    ).confusion
    assert result is not None
    for kind in ("Car", "Van", "Pedestrian", "Truck"):
        assert sum(result.counts[kind].values()) == sum(label.type == kind for here in labels for label in here)
    for kind, least in (("Car", result.least_scores["Car"]), ("Van", result.least_scores["Van"]), ("Truck", 0.0)):
        seen = sum(label.type == kind and (label.score or 0.0) >= least for here in detections for label in here)
        assert sum(row[kind] for row in result.counts.values()) == seen


def test_the_best_threshold_is_that_of_all_which_were_tried() -> None:
    rng = np.random.default_rng(0)
    labels = [[car(-8.0, 15.0), car(8.0, 25.0)] for _ in range(30)]
    detections = [
        [found(one, round(rng.uniform(0.3, 1), 3)) for one in here if rng.random() < 0.8]
        + [found(car(0.0, 50.0), round(rng.uniform(0, 0.7), 3))]
        for here in labels
    ]
    analysis = cadet.analyze(labels, detections, parts=["operating", "errors"], classes=["Car"])
    assert analysis.operating_points is not None and analysis.errors is not None
    curve = analysis.report.curves["Car"]["3d"]["Moderate"]
    best = analysis.operating_points["Car"]["3d"]["Moderate"]

    def f1_at(least: float) -> tuple[float, float, float]:
        kept = [one for seen in detections for one in seen if (one.score or 0.0) >= least]
        right = sum(one.location_cam[2] < 50.0 for one in kept)
        precision, recall = right / len(kept), right / 60
        return 2 * precision * recall / (precision + recall), precision, recall

    assert best.f1 == pytest.approx(max(f1_at(score)[0] for score in curve.scores))
    assert (best.f1, best.precision, best.recall) == pytest.approx(f1_at(best.score))
    # Among all scores, where centers count.
    point = analysis.errors["Car"].operating_point
    assert point is not None
    scores = {one.score or 0.0 for seen in detections for one in seen}
    assert (point.f1, point.score) == max((f1_at(score)[0], score) for score in scores)


def test_own_rules_are_kittis_where_they_say_the_same() -> None:
    labels, detections = shaky_set(3)
    rules = Rules.from_toml(RULES)
    assert [level.name for level in rules.levels] == ["Any", "Seen"]
    assert rules.levels[1] == Level("Seen", 25, max_occlusion=0, max_truncation=0.1)
    vehicle = EvalClass("Vehicle", ("Car", "Van", "Truck"), (0.7, 0.5, 0.25), ("Misc",))
    assert rules.classes == (EvalClass("Car", ("Car",), (0.5, 0.5, 0.5), ("Van",)), vehicle)
    own = cadet.evaluate(labels, detections, classes=rules.classes[:1], levels=LEVELS["kitti"])
    kittis = cadet.evaluate(labels, detections, classes=["Car"], min_overlap={"Car": 0.5})
    assert own == kittis
    assert 0.0 < kittis.ap["Car"]["2d"]["Moderate"] < 100.0


def test_a_class_of_several_types_is_that_of_the_same_types_renamed() -> None:
    labels, detections = shaky_set(4)
    vehicle = EvalClass("Vehicle", ("Car", "Van", "Truck"), (0.5, 0.2, 0.1), ("Pedestrian",))

    def renamed(frames: list[list[Label]]) -> list[list[Label]]:
        names = {"Van": "Tram", "Car": "Tram", "Truck": "Tram", "Pedestrian": "Pedestrian"}
        return [[replace(one, type=names[one.type]) for one in frame] for frame in frames]

    tram = EvalClass("Tram", ("Tram",), (0.5, 0.2, 0.1), ("Pedestrian",))
    own = cadet.evaluate(labels, detections, classes=[vehicle])
    as_trams = cadet.evaluate(renamed(labels), renamed(detections), classes=[tram])
    assert own.curves["Vehicle"] == as_trams.curves["Tram"]
    assert own.n_gt["Vehicle"]["3d"]["Hard"] > cadet.evaluate(labels, detections).n_gt["Car"]["3d"]["Hard"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("min_height_px = 25", "min_height_px = -1", "level Seen.min_height_px: expected a number of at least 0"),
        ("min_height_px = 25", "", "level 2: min_height_px is missing"),
        ('name = "Seen"', 'name = "Any"', "each name once"),
        ("inclusive", "inclusiv", "level 1: unknown key 'inclusiv', expected some of name, min_height_px"),
        ("[[level]]", "[[levels]]", "unknown key 'levels', expected some of level, class"),
        ('"Truck"]', '"DontCare"]', r"class Vehicle\.types: expected types of labels such as Car, got 'D"),
        ('["Misc"]', '["Van"]', r"class Vehicle\.neighbors: Van is one of its own types"),
        (", 3d = 0.25", "", r"class Vehicle\.min_overlap: no limit for 3d"),
        ("3d = 0.25", "3d = 1.0", "1.0 is not a limit"),
        ("min_overlap = 0.5", "", "class Car: min_overlap is missing"),
        (RULES, "", r"neither a \[\[level\]\] nor a \[class.NAME\]"),
        (RULES, "level = 3", r"level: expected tables \[\[level\]\]"),
        (RULES, "class = 3", r"class: expected tables \[class.NAME\]"),
        ("]]", "]", "mine.toml: invalid TOML"),
    ],
)
def test_rules_that_make_no_sense_are_refused(old: str, new: str, message: str) -> None:
    assert old in RULES
    with pytest.raises(CadetError, match=f"^mine.toml: .*{message}" if "TOML" not in message else message):
        Rules.from_toml(RULES.replace(old, new), "mine.toml")


@pytest.fixture
def folders(tmp_path: Path) -> tuple[str, str, str]:
    labels, detections = shaky_set(6, 30)
    better = [[found(label, 0.5) for label in here] for here in labels]
    for name, frames in (("label_2", labels), ("a", detections), ("b", better)):
        (tmp_path / name).mkdir()
        for number, frame in enumerate(frames):
            (tmp_path / name / f"{number:06d}.txt").write_text(text_from_labels(frame))
    return str(tmp_path / "label_2"), str(tmp_path / "a"), str(tmp_path / "b")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(command, ["eval", *arguments], catch_exceptions=False)


def test_the_command_prints_what_was_asked_for(folders: tuple[str, str, str], tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(RULES)
    output = run(*folders, "--details", "--bootstrap", "20", "--seed", "3").output
    for text in (
        "Best operating point, Moderate, percent",
        "Car: AP if one kind of error were corrected, Moderate, overlap > 0.7/0.7",
        "Car: found minus true, median (16 to 84 %) by distance",
        "AP by distance, Moderate",
        "AP by occlusion, Moderate without its limit of occlusion",
        "Confusion, objects",
        "nuScenes' AP in percent",
        "AP (95 % interval) of 20 draws of 30 frames, seed 3",
        "Verdict: B is better: mean AP 3D Moderate of 2 classes",
    ):
        assert text in output, text
    assert "AP by distance" not in run(*folders[:2]).output
    own = run(*folders[:2], "--levels", str(tmp_path / "mine.toml"), "--by", "distance=0,10", "--markdown").output
    assert "| Vehicle | 0-10 m |" in own and "**AP by distance, Seen**" in own
    only = run(*folders[:2], "--levels", str(tmp_path / "mine.toml"), "--classes", "Vehicle,Pedestrian").output
    assert "Vehicle" in only and "Pedestrian" in only and " Car " not in only


def test_json_has_everything_and_the_report_at_its_top(folders: tuple[str, str, str]) -> None:
    gt, a, b = folders
    report = cadet.evaluate(gt, a)
    assert run(gt, a, "--json").output == report.to_json()
    data = json.loads(run(gt, a, b, "--details", "--bootstrap", "20", "--json").output)
    again = cadet.analyze(gt, a, b, by=["distance", "occlusion"], bootstrap=20)
    assert data == json.loads(again.to_json())
    plain = json.loads(report.to_json())
    assert {key: data[key] for key in plain} == plain
    parts = ["operating_points", "errors", "by", "confusion", "centers", "bootstrap", "comparison"]
    assert [key for key in data if key not in plain] == parts == again.parts()
    assert data["errors"]["Car"]["mended"]["as it is"]["3d"] == data["ap"]["Car"]["3d"]
    assert data["bootstrap"]["ap"]["Car"]["3d"]["Easy"]["value"] == data["ap"]["Car"]["3d"]["Easy"]
    assert data["comparison"]["report_b"]["ap"] == cadet.evaluate(gt, b).ap
    assert data["centers"]["Car"]["ap"].keys() == {"0.5", "1", "2", "4"}


def test_texts_for_bins_are_read() -> None:
    assert parse_by(["distance=0,20.5", "occlusion"]) == {"distance": (0.0, 20.5), "occlusion": (0.0, 1.0, 2.0, 3.0)}
    for text, message in (("speed", "unknown 'speed'"), ("distance=near", "expected numbers such as distance=0,20,40")):
        with pytest.raises(CadetError, match=message):
            parse_by([text])


@pytest.mark.parametrize(
    "options", [["--levels", "hard"], ["--levels", "none.toml"], ["--by", "speed"], ["--groups", "frames"]]
)
def test_the_command_refuses_nonsense(folders: tuple[str, str, str], options: list[str]) -> None:
    with pytest.raises(CadetError):
        run(*folders[:2], *options)


def test_unknown_parts_are_refused() -> None:
    with pytest.raises(CadetError, match="parts: unknown 'speed', expected some of operating, errors"):
        cadet.analyze([[car()]], [[found(car())]], parts=["speed"])
