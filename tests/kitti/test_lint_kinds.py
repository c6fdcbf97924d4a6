"""Every kind of damage, each in a set that is otherwise whole: found, named by its rule, and nothing else."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from cadet.kitti import RULES, lint, write_frame
from damages import KINDS, seal, write_set
from synthetic import make_calib, make_frame, make_labels

ROOT = Path(__file__).parents[2]


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
    # What the system does not let read is in test_lint_damage.py.
    assert {rule for _, _, _, rule, _ in KINDS.values()} == set(RULES) - {"unreadable-file"}


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
