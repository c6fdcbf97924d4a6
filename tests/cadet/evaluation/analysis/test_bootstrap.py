"""Draws of frames, intervals, and which of two detectors is better."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cadet
from analysis_helpers import car, found, moved, set_of_cars, shaky_set
from cadet import CadetError, MissingFileError
from cadet.evaluation.analysis.bootstrap import draw_frames
from cadet.evaluation.analysis.groups import find_groups
from cadet.formats.kitti import Label, text_from_labels

Frames = list[list[Label]]
CARS: dict[str, Any] = {"parts": [], "classes": ["Car"], "levels": "large_small"}


def test_groups_are_drawn_whole_and_as_many_as_there_are() -> None:
    ids = [f"{k:06d}" for k in range(30)]
    groups = find_groups({frame_id: str(k % 7) for k, frame_id in enumerate(ids)}, ids, None)
    assert (groups.unit, len(groups)) == ("groups", 7)
    starts, frames = draw_frames(groups, 400, 3)
    shares = np.zeros(7)
    for begin, end in itertools.pairwise(starts):
        counts = np.bincount(frames[begin:end], minlength=30)
        by_group = [set(counts[members]) for members in groups.members]
        assert all(len(each) == 1 for each in by_group)
        times = np.array([each.pop() for each in by_group])
        assert times.sum() == 7
        shares += times
    # Every group is as likely: 400 is expected, with a standard deviation of 18.5.
    assert abs(shares - 400).max() < 4 * 18.5
    assert draw_frames(groups, 400, 3)[1].tolist() == frames.tolist() != draw_frames(groups, 400, 4)[1].tolist()


def test_intervals_are_those_of_sets_written_out_draw_by_draw() -> None:
    labels, detections = shaky_set(2, 25)
    limits = {"Car": 0.2}
    analysis = cadet.analyze(labels, detections, bootstrap=40, seed=9, min_overlap=limits, **CARS)
    ids = [f"{k:06d}" for k in range(25)]
    starts, frames = draw_frames(find_groups("frames", ids, None), 40, 9)
    values = []
    for begin, end in itertools.pairwise(starts):
        chosen = frames[begin:end].tolist()
        part = [[side[k] for k in chosen] for side in (labels, detections)]
        report = cadet.evaluate(*part, classes=["Car"], levels="large_small", min_overlap=limits)
        values.append(report.ap["Car"]["bev"]["Small"])
    assert analysis.bootstrap is not None
    interval = analysis.bootstrap.ap["Car"]["bev"]["Small"]
    assert (interval.low, interval.high) == pytest.approx(tuple(np.percentile(values, (2.5, 97.5))))
    assert interval.value == analysis.report.ap["Car"]["bev"]["Small"] and interval.n_draws == 40
    assert interval.low < interval.value < interval.high
    again = cadet.analyze(labels, detections, bootstrap=40, seed=9, min_overlap=limits, **CARS)
    assert analysis.to_json() == again.to_json()


def test_equal_frames_leave_no_doubt() -> None:
    frame = [car(), car(8.0, 30.0)]
    analysis = cadet.analyze([frame] * 50, [[found(frame[0])]] * 50, bootstrap=20, **CARS)
    assert analysis.bootstrap is not None
    interval = analysis.bootstrap.ap["Car"]["3d"]["Small"]
    assert interval.low == interval.value == interval.high


def better_and_worse() -> tuple[Frames, Frames, Frames]:
    labels = set_of_cars()
    rng = np.random.default_rng(1)

    def detect(noise_m: float) -> Frames:
        return [
            [moved(one, noise_m * rng.normal(), 0, noise_m * rng.normal(), rng.uniform()) for one in here]
            for here in labels
        ]

    return labels, detect(0.5), detect(0.25)


def test_the_better_detector_is_named_and_noise_is_not() -> None:
    labels, worse, better = better_and_worse()
    for a, b, verdict in ((worse, better, "B is better"), (better, worse, "A is better")):
        comparison = cadet.analyze(labels, a, b, bootstrap=300, **CARS).comparison
        assert comparison is not None and comparison.verdict.startswith(f"{verdict}: AP 3D Small ")
        difference = comparison.differences["Car"]["3d"]["Small"]
        assert difference == comparison.mean
        assert difference.difference == pytest.approx(difference.b - difference.a)
        assert difference.a == cadet.evaluate(labels, a, classes=["Car"], levels="large_small").ap["Car"]["3d"]["Small"]
        assert comparison.report_b.ap == cadet.evaluate(labels, b, classes=["Car"], levels="large_small").ap
    same = cadet.analyze(labels, worse, worse, **CARS).comparison
    assert same is not None and same.verdict.startswith("no difference can be told")
    assert (same.num_draws, same.mean.low, same.mean.high, same.mean.share_better) == (1000, 0.0, 0.0, 0.5)


def test_pairs_are_told_apart_better_than_two_intervals() -> None:
    # The frames differ far more than the detectors: only their difference frame by frame shows which one is better.
    labels = set_of_cars()
    better = [[found(one) for one in here] if k % 2 else [] for k, here in enumerate(labels)]
    worse = [seen[:1] if k % 4 == 1 else seen for k, seen in enumerate(better)]
    analysis = cadet.analyze(labels, worse, better, bootstrap=300, **CARS)
    assert analysis.comparison is not None and analysis.bootstrap is not None
    alone = analysis.bootstrap.ap["Car"]["3d"]["Small"]
    assert analysis.comparison.mean.low > 0.0
    assert analysis.comparison.mean.high - analysis.comparison.mean.low < 0.75 * (alone.high - alone.low)


def test_a_class_that_only_one_finds_counts_as_nothing_for_the_other() -> None:
    labels = [[car(), car(-8.0, 20.0, kind="Pedestrian")]] * 45
    a, b = [[found(label) for label in labels[0]]] * 45, [[found(labels[0][0])]] * 45
    comparison = cadet.analyze(labels, a, b, bootstrap=20, parts=[], levels="large_small").comparison
    assert comparison is not None
    walkers = comparison.differences["Pedestrian"]["3d"]["Small"]
    assert (walkers.a, walkers.b, walkers.high) == pytest.approx((100.0, 0.0, -100.0))
    # Cyclists are nowhere: the mean is that of two classes.
    assert comparison.mean.difference == pytest.approx(-50.0)
    assert "mean AP 3D Small of 2 classes" in comparison.verdict


def written(root: Path, num_frames: int = 50) -> tuple[Path, Path]:
    """Write a dataset's labels and results."""
    labels, results = root / "training/label_2", root / "results"
    for folder, text in ((labels, text_from_labels([car()])), (results, text_from_labels([found(car())]))):
        folder.mkdir(parents=True)
        for k in range(num_frames):
            (folder / f"{k:06d}.txt").write_text(text)
    return root, results


def test_episodes_are_those_of_the_manifest(tmp_path: Path) -> None:
    root, results = written(tmp_path / "set")
    assert cadet.analyze(root, results, bootstrap=5, **CARS).bootstrap.unit == "frames"  # type: ignore[union-attr]
    with pytest.raises(MissingFileError, match=r"no manifest\.json"):
        cadet.analyze(root, results, bootstrap=5, groups="episodes", **CARS)
    (root / "manifest.json").write_text(json.dumps({"policy": {"samples_per_episode": 20}}))
    ids = [f"{k:06d}" for k in (0, 19, 20, 39, 40)]
    groups = find_groups(None, ids, root / "training/label_2")
    assert (groups.unit, [members.tolist() for members in groups.members]) == ("episodes", [[0, 1], [2, 3], [4]])
    analysis = cadet.analyze(root, results, bootstrap=5, **CARS)
    assert analysis.bootstrap is not None
    assert (analysis.bootstrap.unit, analysis.bootstrap.num_units) == ("episodes", 3)
    assert analysis.notes == ("Only 3 episodes are drawn from: intervals are too narrow to be trusted.",)
    assert str(analysis).endswith(f"Note: {analysis.notes[0]}")
    assert analysis.to_markdown().endswith(f"\n* {analysis.notes[0]}\n")
    assert cadet.analyze(root, results, bootstrap=5, groups="frames", **CARS).bootstrap.num_units == 50  # type: ignore[union-attr]
    (root / "manifest.json").write_text("{}")
    with pytest.raises(CadetError, match="samples_per_episode"):
        cadet.analyze(root, results, bootstrap=5, **CARS)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("000000 a\n000001\n", r"groups\.txt:2: expected a frame's id and a group's name"),
        ("000000 a\n000000 b\n", r"groups\.txt:2: frame '000000' comes twice"),
        ("000000 a\n", r"frame 000001 has no group"),
    ],
)
def test_files_of_groups_are_checked(tmp_path: Path, text: str, message: str) -> None:
    root, results = written(tmp_path / "set", 3)
    path = tmp_path / "groups.txt"
    path.write_text("000000 one\n000001 one\n000002 two\n")
    bootstrap = cadet.analyze(root, results, bootstrap=5, groups=path, **CARS).bootstrap
    assert bootstrap is not None and (bootstrap.unit, bootstrap.num_units) == ("groups", 2)
    path.write_text(text)
    with pytest.raises(CadetError, match=message):
        cadet.analyze(root, results, bootstrap=5, groups=path, **CARS)


def test_a_and_b_must_be_of_the_same_frames(tmp_path: Path) -> None:
    root, results = written(tmp_path / "set", 4)
    other = tmp_path / "other"
    other.mkdir()
    for k in range(3):
        (other / f"{k:06d}.txt").write_text((results / f"{k:06d}.txt").read_text())
    with pytest.raises(CadetError, match="1 have results of only one, such as 000003"):
        cadet.analyze(root, results, other, **CARS)
    assert cadet.analyze(root, results, other, frames="all", bootstrap=5, **CARS).comparison is not None
    with pytest.raises(CadetError, match="groups are drawn only by a bootstrap"):
        cadet.analyze(root, results, groups="frames", **CARS)
