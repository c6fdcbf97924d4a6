"""`make readers`: programs count a set's frames and objects in processes of their own, and what differs is an error."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cadet import kitti
from readers.__main__ import answer, ask, row
from readers.programs import READERS, Reader
from small_runs import make

NUM_FRAMES = 4
BY_NAME = {reader.name: reader for reader in READERS}
RULES = BY_NAME["OpenPCDet, MMDetection3D"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    make(tmp_path / "kitti", NUM_FRAMES)
    monkeypatch.setenv("PYTHONPATH", "python:tests/support")
    monkeypatch.chdir(Path(__file__).parents[3])
    return tmp_path


def test_programs_count_what_was_generated_and_a_line_more_is_an_error(folder: Path) -> None:
    frames = list(kitti.Dataset(folder / "kitti", "trainval"))
    expected = NUM_FRAMES, sum(not label.is_dont_care for frame in frames for label in frame.labels)
    for reader in (RULES, BY_NAME["mlcroissant"]):
        line, wrong = row(reader, ask(reader, folder, [sys.executable]), expected)
        assert line.endswith(f"| `kitti` | {NUM_FRAMES} | {expected[1]} |\n") and wrong is None
    labels = sorted((folder / "kitti" / "training" / "label_2").iterdir())
    path = next(path for path in labels if not path.read_text().startswith("DontCare"))
    path.write_text(path.read_text().partition("\n")[0] + "\n" + path.read_text())
    _, wrong = row(RULES, ask(RULES, folder, [sys.executable]), expected)
    assert wrong is not None and f"{expected[1] + 1} boxes, but generated were {NUM_FRAMES}" in wrong


def test_a_program_that_fails_or_is_missing_has_a_row(folder: Path) -> None:
    (folder / "kitti" / "ImageSets" / "trainval.txt").unlink()
    line, wrong = row(RULES, ask(RULES, folder, [sys.executable]), (NUM_FRAMES, 1))
    assert "| failed |" in line and wrong is not None and "trainval.txt" in wrong
    missing = Reader("none", "no-such-distribution", "kitti", RULES.read)
    assert row(missing, answer(missing, folder / "kitti"), (NUM_FRAMES, 1)) == (
        "| none | not installed | `kitti` | - | - |\n",
        None,
    )
