"""Every kind of damage, each in a set that is otherwise whole: found, named by its rule, and nothing else."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cadet.formats.kitti import RULES, lint, write_frame
from damages import KINDS, seal, write_set
from synthetic import make_calib, make_frame, make_label, make_labels

ROOT = Path(__file__).parents[5]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("whole")
    write_set(root)
    return root


def test_the_whole_set_has_no_finding(whole: Path) -> None:
    assert [str(finding) for finding in lint(whole)] == []
    assert [str(finding) for finding in lint(whole, strict=False)] == []


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_damage_is_named_and_nothing_else(kind: str, whole: Path, tmp_path: Path) -> None:
    root = tmp_path / "set"
    shutil.copytree(whole, root)
    damage, is_sealed, place, rule, part = KINDS[kind]
    damage(root)
    if is_sealed:
        seal(root)
    found = [(finding.place, finding.rule) for finding in lint(root)]
    assert found == [(place, rule)], [str(finding) for finding in lint(root)]
    assert part in lint(root)[0].message


def test_the_kinds_cover_the_rules() -> None:
    # What the system does not let read is in test_lint_damage.py; dialects and nuScenes' tables are in their own tests.
    assert {rule for _, _, _, rule, _ in KINDS.values()} == set(RULES) - {"unreadable-file", "dialect", "table-row"}


def test_a_street_with_other_cars_is_no_duplicate(tmp_path: Path) -> None:
    """What a car sees that waits at a red light: image and scan stay, another car moves."""
    frame = make_frame(seed=1)
    for number, z in enumerate((14.0, 14.02, 17.0)):
        moved = make_label("Car", (-2.0, 1.65, z, 4.1, 1.7, 1.5, 1.5), make_calib())
        image = frame.image + np.uint8(number)  # darker than 250
        write_frame(tmp_path, number, replace(frame, image=image, labels=(moved, *frame.labels[1:])), split=None)
        points_velo = frame.points_velo[: len(frame.points_velo) - number]
        (tmp_path / "training" / "velodyne" / f"{number:06d}.bin").write_bytes(points_velo.tobytes())
    found = [(finding.file, finding.rule) for finding in lint(tmp_path, strict=True)]
    assert found == [("image_2/000001.png", "duplicate-frame")]


def test_workers_change_nothing(tmp_path: Path) -> None:
    for number in range(40):
        frame = make_frame(seed=number % 37, labels=() if number % 5 == 0 else make_labels(make_calib()))
        write_frame(tmp_path, number, frame, split=None)
    alone = lint(tmp_path, strict=True)
    assert len(alone) > 8
    assert lint(tmp_path, strict=True, workers=2) == alone


def test_the_rules_are_documented() -> None:
    page = (ROOT / "docs" / "datasets.md").read_text()
    for rule, meaning in RULES.items():
        assert f"| `{rule}` | {meaning} |" in page
