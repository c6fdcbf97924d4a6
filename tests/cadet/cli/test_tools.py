"""`cadet view` and `cadet check`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import cv2
import pytest

from cadet import kitti
from cadet.cli import run_cadet
from synthetic import make_frame


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    for number in range(2):
        kitti.write_frame(tmp_path / "set", number, make_frame(seed=number))
    return tmp_path / "set"


def cadet(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int | str | None:
    monkeypatch.setattr(sys, "argv", ["cadet", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        run_cadet()
    return ended.value.code


def test_view_draws_a_frame(whole: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    out = whole.parent / "frame.png"
    assert cadet(monkeypatch, "view", whole / "000001", "-o", out) == 0
    assert capsys.readouterr().out == f"wrote {out}\n"
    picture = cv2.imread(str(out))
    assert picture is not None
    assert picture.shape[1] == 1920


def test_view_of_a_whole_draws_some_of_its_frames(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = whole.parent / "overview.png"
    assert cadet(monkeypatch, "view", whole, "-o", out) == 0
    two_rows = cv2.imread(str(out))
    (whole / "training" / "calib" / "000001.txt").unlink()
    for folder in ("image_2", "velodyne"):
        next((whole / "training" / folder).glob("000001.*")).unlink()
    assert cadet(monkeypatch, "view", whole, "-o", out) == 0
    one_row = cv2.imread(str(out))
    assert two_rows is not None
    assert one_row is not None
    assert two_rows.shape[0] > 1.8 * one_row.shape[0]


def test_check_names_file_and_line_and_exits_1(
    whole: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    labels = whole / "training" / "label_2" / "000001.txt"
    labels.write_text("Car 0.00 0 0.10\n")
    assert cadet(monkeypatch, "check", whole) == 1
    out = capsys.readouterr().out
    head, row, *_, counts, last = out.splitlines()
    assert head.split() == ["FRAME", "PLACE", "SEVERITY", "RULE", "WHAT"]
    assert row.startswith("000001  label_2/000001.txt:1  error     damaged-file  ")
    assert counts.split() == ["1", "0", "damaged-file"]
    assert last == "2 frames, 1 errors, 0 warnings"


def test_check_as_json(whole: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (whole / "training" / "planes" / "000009.txt").write_text("")
    assert cadet(monkeypatch, "check", whole, "--json", "--loose") == 0, "warnings alone"
    found = json.loads(capsys.readouterr().out)
    assert (found["frames"], found["errors"], found["warnings"]) == (2, 0, len(found["findings"]))
    stray = [one for one in found["findings"] if one["rule"] == "stray-file"]
    assert stray == [
        {
            "frame": "000009",
            "file": "planes/000009.txt",
            "line": None,
            "rule": "stray-file",
            "severity": "warning",
            "message": "belongs to no frame",
        }
    ]
    assert found["rules"]["stray-file"] == {"errors": 0, "warnings": 1}


def test_check_prints_the_first_findings_or_all(
    whole: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for number in range(100, 160):
        (whole / "training" / "planes" / f"{number:06d}.txt").write_text("")
    rows = [f"Car 0.00 0 0.10 {'x' * number}" for number in range(60)]
    (whole / "training" / "label_2" / "000001.txt").write_text("\n".join(rows))
    cadet(monkeypatch, "check", whole)
    out = capsys.readouterr().out
    assert "--all prints every finding" in out and "60 errors, 60 warnings" in out
    stray = [line for line in out.splitlines() if "planes/" in line]
    assert len(stray) == 1 and stray[0].startswith("000100  planes/000100.txt"), "one row for all of a kind"
    assert stray[0].endswith("belongs to no frame (60 times: also planes/000101.txt, planes/000102.txt, ...)")
    cadet(monkeypatch, "check", whole, "--all")
    assert capsys.readouterr().out.count("stray-file") == 61


def test_findings_of_different_kinds_are_rows_of_their_own(
    whole: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = (whole / "training" / "label_2" / "000000.txt").read_text().splitlines()
    odd = [lines[0].replace(" 0 ", f" {number} ", 1) for number in (7, 8, 9, 10, 11)]
    (whole / "training" / "label_2" / "000000.txt").write_text("\n".join([*odd, "Car 1"]))
    cadet(monkeypatch, "check", whole, "--json")
    found = json.loads(capsys.readouterr().out)["findings"]
    cadet(monkeypatch, "check", whole)
    rows = capsys.readouterr().out.split("\n\n")[0].splitlines()[1:]
    assert len(rows) < len(found)
    assert sum("expected 15 fields" in row for row in rows) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["view", "nothing/000012"], "nothing/000012: no such folder, and no frame: nothing is no dataset"),
        (["view", "nothing/12", "-o", "x.png"], "nothing/12: no such folder, and no frame: nothing is no dataset"),
        (["check", "nothing"], "nothing: no such folder"),
        (["draw"], "No such command 'draw'."),
    ],
)
def test_what_is_not_there_costs_one_line(
    arguments: list[str], message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cadet(monkeypatch, *arguments) == 2
    assert capsys.readouterr().err == f"cadet: {message}\n"


def test_a_command_without_its_libraries_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "rich" else object())
    assert cadet(monkeypatch, "check", "nothing") == 2
    assert capsys.readouterr().err == "cadet needs rich: pip install rich\n"
