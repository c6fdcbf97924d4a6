"""Against the official program: its answers on sets of labels and results, where they are at hand."""

from __future__ import annotations

import json
import math
import tarfile
from pathlib import Path
from typing import Any

import pytest

import cadet
from cadet.evaluation import LEVELS, Level

CASES = Path(__file__).parents[3] / "shared" / "eval_cases"
TOLERANCE = 1e-5

pytestmark = [
    pytest.mark.usefixtures("core"),
    pytest.mark.skipif(not CASES.is_dir(), reason="the official answers are not at hand"),
]


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
