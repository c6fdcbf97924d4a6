"""The report, its figure, and the command."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import pytest
from click.testing import CliRunner, Result

import cadet
from cadet import CadetError, Report
from cadet.cli.tools import cadet as command
from evaluation_helpers import detected, make_object, write


@pytest.fixture(scope="module")
def report() -> Report:
    car, walker = make_object(), make_object("Pedestrian", 1)
    gt = [[car, walker]] * 60
    det = [[detected(car, 0.9), detected(make_object(column=4), 0.95)], [detected(walker, 0.4)], []] * 20
    return cadet.evaluate(gt, det)


@pytest.fixture
def folders(tmp_path: Path) -> tuple[str, str]:
    car = make_object()
    return str(write(tmp_path / "label_2", [[car]] * 50)), str(write(tmp_path / "det", [[detected(car)]] * 45))


def run(*arguments: str) -> Result:
    return CliRunner().invoke(command, ["eval", *arguments], catch_exceptions=False)


def test_json_holds_everything(report: Report) -> None:
    data = json.loads(report.to_json())
    assert data["ap"] == {name: {m: dict(row) for m, row in rows.items()} for name, rows in report.ap.items()}
    curve = data["curves"]["Car"]["3d"]["Easy"]
    assert (len(curve["precision"]), len(curve["scores"]), curve["n_gt"]) == (41, 14, 60)
    assert (data["frames"], data["recall"], data["num_frames"]) == ("results", "r40", 60)
    assert [level["name"] for level in data["levels"]] == ["Easy", "Moderate", "Hard"]
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_json_bears_levels_without_limits() -> None:
    car = make_object()
    levels = [cadet.Level("Any", 25.0, True, float("inf"), None)]
    data = json.loads(cadet.evaluate([[car]], [[detected(car)]], levels=levels).to_json())
    assert data["levels"][0]["max_occlusion"] is data["levels"][0]["max_truncation"] is None


def test_markdown_is_a_table_of_what_was_evaluated(report: Report) -> None:
    lines = report.to_markdown().splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    assert rows[0] == ["Class", "Metric", "Overlap >", "Easy", "Moderate", "Hard"]
    value = f"{report.ap['Car']['3d']['Easy']:.2f}"
    assert ["Car", "3D", "0.70", value, value, value] in rows
    assert ["Car", "objects", "", "60", "60", "60"] in rows
    assert not any(row[0] == "Cyclist" for row in rows)
    assert 'frames="results": the 60 frames that have a result file' in "\n".join(lines)
    assert any("Cyclist" in line for line in lines if line.startswith("* "))


def test_print_shows_the_first_warnings(report: Report) -> None:
    assert len(report.warnings) == 1
    assert str(report).splitlines()[-1] == f"Note: {report.warnings[0]}"
    lines = str(replace(report, warnings=tuple("abcdefg"))).splitlines()
    assert lines[-6:] == [*(f"Note: {name}" for name in "abcde"), "... and 2 more: see warnings"]
    assert str(replace(report, warnings=())).endswith("60 detections.")


def test_the_figure_shows_curves(report: Report, tmp_path: Path) -> None:
    path = report.plot(tmp_path / "curves.png")
    image = cv2.imread(str(path))
    assert image is not None
    assert image.shape == (70 + 2 * 462, 1560, 3)
    # The curve of the last level is drawn over the others: precision 1/2 until recall 1/3, then down.
    panel = image[70 : 70 + 336, :520].astype(int)
    orange = (abs(panel - [40, 170, 255]).max(axis=2) < 30).nonzero()
    assert abs(orange[0].min() - (52 + 284 / 2)) <= 3
    assert abs(orange[1].max() - (58 + 444 * 13 / 40)) <= 3
    with pytest.raises(CadetError, match=r"\.png"):
        report.plot(tmp_path / "curves.pdf")


def test_nothing_to_plot_is_said(tmp_path: Path) -> None:
    car = make_object()
    empty = cadet.evaluate([[car]], [[]])
    assert (len(empty.ap), len(empty.curves)) == (0, 0)
    assert len(empty.warnings) == 3
    with pytest.raises(CadetError, match="nothing to plot"):
        empty.plot(tmp_path / "curves.png")


def test_the_command_prints_the_table(folders: tuple[str, str], tmp_path: Path) -> None:
    result = run(*folders, "--plot", str(tmp_path / "curves.png"))
    assert result.exit_code == 0
    assert (tmp_path / "curves.png").is_file()
    for text in ("Moderate", "AHS BEV", "100.00", 'frames="results": the 45 frames', "5 others left out", "Note: "):
        assert text in result.output


def test_the_command_prints_json_and_markdown(folders: tuple[str, str]) -> None:
    report = cadet.evaluate(*folders, classes=["Car"], recall="r11", levels="large_small", frames="all")
    options = ["--classes", "Car", "--recall", "r11", "--levels", "large_small", "--frames", "all"]
    assert run(*folders, *options, "--json").output == report.to_json()
    assert run(*folders, *options, "--markdown").output == report.to_markdown()
    limits = cadet.evaluate(*folders, min_overlap={"Car": 0.5, "Cyclist": (0.5, 0.25, 0.1)})
    assert run(*folders, "--min-overlap", "Car=0.5, Cyclist=0.5/0.25/0.1", "--json").output == limits.to_json()


@pytest.mark.parametrize("options", [["--min-overlap", "Car"], ["--min-overlap", "Bus=0.5"], ["--json", "--markdown"]])
def test_the_command_refuses_nonsense(folders: tuple[str, str], options: list[str]) -> None:
    with pytest.raises(CadetError):
        run(*folders, *options)
