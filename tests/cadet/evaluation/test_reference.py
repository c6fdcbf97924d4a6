"""Against the official program: on labels and results of our own, and on larger sets where they are at hand.

`official/` holds 14 frames that were invented for it: streets of all classes, with heights, truncations, and occlusions
at the borders of the levels, ties of scores, objects found twice, under another class, or turned around, regions
without labels, one frame without labels, and one without detections. Each line begins with its frame's number. Its
`precision.txt` is what `cpp/evaluate_object.cpp` of KITTI's object development kit wrote of them to its `stats_*.txt`:
41 points of precision or orientation similarity for each class, metric, and level. It was compiled with g++ 12 and
Boost 1.74 from the copy in github.com/sunnyln/kitti-devkit at c735595, with N_TESTIMAGES set to 14 and nothing else
changed.
"""

from __future__ import annotations

import json
import math
import tarfile
from pathlib import Path
from typing import Any

import pytest

import cadet
from cadet.evaluation import LEVELS, Level
from cadet.formats.kitti import Label, labels_from_text

CASES = Path(__file__).parents[4] / "shared" / "eval_cases"
TOLERANCE = 1e-5

OFFICIAL = Path(__file__).parent / "official"

needs_cases = pytest.mark.skipif(not CASES.is_dir(), reason="needs larger sets in ../shared/eval_cases")


def frames(name: str) -> dict[str, tuple[Label, ...]]:
    """Return the labels of each of the 14 frames."""
    lines: dict[str, list[str]] = {f"{number:06d}": [] for number in range(14)}
    for line in (OFFICIAL / name).read_text().splitlines():
        frame_id, _, text = line.partition(" ")
        lines[frame_id].append(text)
    return {frame_id: labels_from_text("\n".join(of_frame)) for frame_id, of_frame in lines.items()}


def test_our_own_frames_get_the_official_answers() -> None:
    truths, found = frames("labels.txt"), frames("detections.txt")
    by_recall = {recall: cadet.evaluate(truths, found, recall=recall) for recall in ("r11", "r40")}
    report = by_recall["r40"]
    rows = [line.split() for line in (OFFICIAL / "precision.txt").read_text().splitlines()]
    assert {(name, metric, level) for name, metric, level, *_ in rows} == {
        (name, metric, level)
        for name, metrics in report.curves.items()
        for metric, levels in metrics.items()
        for level in levels
        if not metric.startswith("ahs")
    }
    for name, metric, level, *texts in rows:
        expected = [float(text) for text in texts]
        # Six decimals are what the program writes.
        assert report.curves[name][metric][level].precision == pytest.approx(expected, abs=6e-7), (name, metric, level)
        for recall, points in (("r11", expected[::4]), ("r40", expected[1:])):
            ap = by_recall[recall].ap[name][metric][level]
            assert ap == pytest.approx(100.0 * sum(points) / len(points), abs=1e-4), (name, metric, level, recall)


def with_limits(is_inclusive: bool, most: tuple[float, float]) -> tuple[Level, ...]:
    return tuple(Level(name, height, is_inclusive, *most) for name, height in (("Large", 40.0), ("Small", 25.0)))


NO_LIMITS = (math.inf, math.inf)
SETTINGS: dict[str, dict[str, Any]] = {
    "strict": {},
    "loose": {"min_overlap": "loose"},
    "strict_gt_height_ge": {
        "levels": [
            Level(level.name, level.min_height_px, True, level.max_occlusion, level.max_truncation)
            for level in LEVELS["kitti"]
        ]
    },
    "large_small_hard": {"levels": with_limits(False, (2, 0.5))},
    "large_small_hard_ge": {"levels": with_limits(True, (2, 0.5))},
    "large_small_all": {"levels": with_limits(False, NO_LIMITS)},
    "large_small_all_ge": {"levels": "large_small"},
}


def names() -> list[str]:
    return sorted(path.parent.name for path in CASES.glob("*/expected.json")) + [
        path.name.removesuffix(".expected.json") for path in sorted(CASES.glob("*.expected.json"))
    ]


def case(name: str, tmp_path: Path) -> tuple[Path, dict[str, Any]]:
    """Return a case's folder and the official answers."""
    folder, archive = CASES / name, CASES / f"{name}.tar.xz"
    answers = folder / "expected.json" if folder.is_dir() else CASES / f"{name}.expected.json"
    if archive.is_file():
        with tarfile.open(archive) as packed:
            if hasattr(tarfile, "data_filter"):
                packed.extractall(tmp_path, filter="data")
            else:  # Python before 3.10.12 and 3.11.4
                packed.extractall(tmp_path)
        folder = next(path.parent for path in tmp_path.rglob("label_2"))
    return folder, json.loads(answers.read_text())


def zero_for_none(values: Any) -> Any:
    """Read the official 0/0 as 0."""
    return [zero_for_none(value) for value in values] if isinstance(values, list) else values or 0.0


@needs_cases
@pytest.mark.parametrize("name", names())
def test_every_setting_of_a_case_gets_the_official_answer(name: str, tmp_path: Path) -> None:
    folder, answers = case(name, tmp_path)
    num_compared = 0
    for setting, by_class in answers["configs"].items():
        reports = {
            recall: cadet.evaluate(folder / "label_2", folder / "det", recall=recall.lower(), **SETTINGS[setting])
            for recall in ("R11", "R40")
        }
        report = reports["R40"]
        assert report.num_frames == answers["frames"]
        assert (report.num_gt, report.num_detections) == (answers["n_gt_lines"], answers["n_det_lines"])
        for class_name, by_metric in by_class.items():
            assert bool(by_metric) == (class_name in report.ap)
            assert set(by_metric) == set(report.ap.get(class_name, {})) - {"ahs_bev", "ahs_3d"}
            for metric, expected in by_metric.items():
                what = f"{setting} {class_name} {metric}"
                assert list(report.n_gt[class_name][metric].values()) == expected["n_gt"], what
                assert list(report.n_thresholds[class_name][metric].values()) == expected["n_thresholds"], what
                for recall in ("R11", "R40"):
                    found = list(reports[recall].ap[class_name][metric].values())
                    assert found == pytest.approx(zero_for_none(expected[recall]), abs=TOLERANCE), f"{what} {recall}"
                    num_compared += len(found)
                curves = report.curves[class_name][metric].values()
                for curve, samples in zip(curves, zero_for_none(expected.get("curve", [])), strict=False):
                    assert curve.precision == pytest.approx(samples, abs=1e-6), what
    assert num_compared > 0
