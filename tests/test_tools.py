"""`cadet view` and `cadet check`, on frames of the fake core."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import cv2
import pytest

from cadet import Environment, kitti
from cadet.cli import run_cadet
from synthetic import make_frame


@pytest.fixture
def dataset(fake_core: object, tmp_path: Path) -> Path:
    env = Environment()
    env.reset(seed=0)
    for number in range(2):
        kitti.write_frame(tmp_path / "set", number, env.step())
    return tmp_path / "set"


def cadet(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int | str | None:
    monkeypatch.setattr(sys, "argv", ["cadet", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        run_cadet()
    return ended.value.code


def test_view_draws_a_frame(dataset: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    out = dataset.parent / "frame.png"
    assert cadet(monkeypatch, "view", dataset / "000001", "-o", out) == 0
    assert capsys.readouterr().out == f"wrote {out}\n"
    picture = cv2.imread(str(out))
    assert picture is not None
    assert picture.shape[1] == 1920


def test_view_of_a_dataset_draws_some_of_its_frames(dataset: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = dataset.parent / "overview.png"
    assert cadet(monkeypatch, "view", dataset, "-o", out) == 0
    two_rows = cv2.imread(str(out))
    (dataset / "training" / "calib" / "000001.txt").unlink()
    for folder in ("image_2", "velodyne"):
        next((dataset / "training" / folder).glob("000001.*")).unlink()
    assert cadet(monkeypatch, "view", dataset, "-o", out) == 0
    one_row = cv2.imread(str(out))
    assert two_rows is not None
    assert one_row is not None
    assert two_rows.shape[0] > 1.8 * one_row.shape[0]


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    for number in range(2):
        kitti.write_frame(tmp_path / "set", number, make_frame(seed=number))
    return tmp_path / "set"


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
    cadet(monkeypatch, "check", whole)
    assert "more: --all prints them" in capsys.readouterr().out
    cadet(monkeypatch, "check", whole, "--all")
    assert capsys.readouterr().out.count("stray-file") == 61


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["view", "nothing/000012"], "nothing: no KITTI folder: neither training/calib nor calib lies there"),
        (["view", "nothing/12"], "nothing/12: no such folder; a frame's id has six digits: nothing/000012"),
        (["view", "nothing", "-o", "x.png"], "nothing: no KITTI folder: neither training/calib nor calib lies there"),
        (["check", "nothing"], "nothing: no KITTI folder: neither training/calib nor calib lies there"),
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
