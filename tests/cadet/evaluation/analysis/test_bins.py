"""AP bin by bin, against sets that hold the objects of one bin alone."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cadet
from analysis_helpers import car, found, moved, set_of_cars
from cadet import CadetError, MissingFileError, kitti
from cadet.formats.kitti import Label
from synthetic import make_frame


def distance(label: Label) -> float:
    return math.hypot(label.location_cam[0], label.location_cam[2])


def detect(labels: list[list[Label]], seed: int) -> list[list[Label]]:
    """Find most cars, the far ones worse, and some that are not there; none so far off that it changes its bin."""
    rng = np.random.default_rng(seed)
    detections = []
    for here in labels:
        seen = []
        for label in here:
            shift = 0.02 * distance(label) * rng.normal()
            across = (math.cos(label.rotation_y), -math.sin(label.rotation_y))
            seen.append(moved(label, shift * across[0], 0.0, shift * across[1], round(rng.uniform(0.2, 1.0), 2)))
        if rng.random() < 0.5:
            seen.append(found(car(0.0, rng.uniform(70, 90)), round(rng.uniform(), 2)))
        detections.append([one for one in seen if rng.random() < 0.9])
    return detections


def test_a_bin_of_distance_has_the_ap_of_its_own_objects_and_false_alarms() -> None:
    # Cars that lie well inside their bins, so that no detection of theirs lies in another.
    labels = [[one for one in here if min(abs(distance(one) - e) for e in (20, 40)) > 3.0] for here in set_of_cars()]
    detections = detect(labels, 1)
    analysis = cadet.analyze(labels, detections, parts=[], by={"distance": (0, 20, 40)}, classes=["Car"])
    bins = analysis.by["distance"]
    assert [(one.low, one.high) for one in bins] == [(0, 20), (20, 40), (40, None)]
    for one in bins:
        high = math.inf if one.high is None else one.high
        part = [
            [[label for label in here if one.low <= distance(label) < high] for here in side]
            for side in (labels, detections)
        ]
        expected = cadet.evaluate(*part, classes=["Car"])
        assert one.ap["Car"] == expected.ap["Car"]
        assert one.n_gt["Car"] == expected.n_gt["Car"]["3d"]
        assert 10.0 < one.ap["Car"]["3d"]["Moderate"] < 95.0
    assert sum(one.n_gt["Car"]["Moderate"] for one in bins) == analysis.report.n_gt["Car"]["3d"]["Moderate"]


def test_an_object_of_another_bin_excuses_what_finds_it() -> None:
    # A car just beyond the limit, found just before it: neither right nor wrong in the near bin, right in the far one.
    near, far = car(0.0, 10.0), car(0.0, 20.2, math.pi / 2)
    labels = [[near, far]] * 50
    detections = [[found(near, 0.5), moved(far, dz=-0.3, score=0.9)]] * 50
    bins = cadet.analyze(labels, detections, parts=[], by={"distance": (0, 20)}, classes=["Car"]).by["distance"]
    assert [one.ap["Car"]["bev"]["Moderate"] for one in bins] == pytest.approx([100.0, 100.0])


def test_occlusion_counts_every_false_alarm_and_needs_no_level_of_it() -> None:
    labels = [[car(-8.0, 15.0, occluded=k % 4), car(8.0, 25.0, occluded=2)] for k in range(200)]
    detections = [[*map(found, here), *[found(car(0.0, 60.0), 0.95)] * (k % 2)] for k, here in enumerate(labels)]
    bins = cadet.analyze(labels, detections, parts=[], by=["occlusion"], classes=["Car"]).by["occlusion"]
    assert [one.n_gt["Car"]["Easy"] for one in bins] == [50, 50, 250, 50]
    # 100 false alarms are surer than all that is right.
    for one in bins:
        n_gt = one.n_gt["Car"]["Easy"]
        assert one.ap["Car"]["3d"]["Moderate"] == pytest.approx(100.0 * n_gt / (n_gt + 100))


def dataset(root: Path, num_points: tuple[int, ...]) -> None:
    """Write frames with a car each, that many points in it and a few beside it."""
    frame = make_frame()
    for number, count in enumerate(num_points):
        label = car(2.0, 20.0)
        rng = np.random.default_rng(number)
        inside = rng.uniform(-0.4, 0.4, (count, 3)) * [1.6, 1.4, 1.6] + [2.0, 0.85, 20.0]
        beside = rng.uniform(-0.4, 0.4, (9, 3)) + [6.0, 0.85, 20.0]
        points_velo = frame.calib.points_velo_from_cam(np.concatenate([inside, beside]))
        scan = np.column_stack([points_velo, np.zeros(len(points_velo))]).astype(np.float32)
        kitti.write_frame(root, number, replace(frame, points_velo=scan, labels=(label,)), split="train")


def test_points_are_counted_in_the_scans_beside_the_labels(tmp_path: Path) -> None:
    counts = (0, 4, 5, 19, 20, 60, 100, 499, 500, 700)
    dataset(tmp_path / "set", counts)
    results = tmp_path / "results"
    results.mkdir()
    for number in range(len(counts)):
        # Every second one is found; a false alarm with 9 points stands in every frame.
        alarm = found(car(6.0, 20.0), 0.2)
        seen = [alarm] if number % 2 else [found(car(2.0, 20.0)), alarm]
        (results / f"{number:06d}.txt").write_text(kitti.text_from_labels(seen))
    for gt in (tmp_path / "set", tmp_path / "set/training/label_2"):
        analysis = cadet.analyze(gt, results, parts=[], by=["points"], classes=["Car"], levels="large_small")
        bins = analysis.by["points"]
        assert [(one.low, one.high) for one in bins] == [(0, 5), (5, 20), (20, 100), (100, 500), (500, None)]
        assert [one.n_gt["Car"]["Small"] for one in bins] == [2] * 5
    alone = cadet.analyze(gt, results, parts=[], by={"points": (9, 10)}, classes=["Car"]).by["points"]
    assert [one.n_gt["Car"]["Moderate"] for one in alone] == [0, 7]


def test_nonsense_is_refused(tmp_path: Path) -> None:
    labels, detections = [[car()]], [[found(car())]]
    for by, message in (
        (["colour"], "by: unknown 'colour', expected some of distance, points, occlusion"),
        ({"distance": (3, 2)}, r"by\['distance'\]: expected rising numbers"),
        ({"distance": ()}, r"by\['distance'\]: expected rising numbers"),
        ({"distance": (-1, 2)}, "of at least 0"),
        (["points"], "not a KITTI folder"),
    ):
        with pytest.raises(CadetError, match=message):
            cadet.analyze(labels, detections, by=by)
    (tmp_path / "label_2").mkdir()
    (tmp_path / "det").mkdir()
    for name, one in (("label_2", labels[0]), ("det", detections[0])):
        (tmp_path / name / "000000.txt").write_text(kitti.text_from_labels(one))
    with pytest.raises(MissingFileError, match="no velodyne and calib beside the labels"):
        cadet.analyze(tmp_path, tmp_path / "det", by=["points"])
