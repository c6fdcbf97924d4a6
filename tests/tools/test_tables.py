"""Means, tables, figures and estimates of experiments, against numbers computed by hand or in another way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from avod.device import Processes
from cadet import evaluate
from detector.experiments import micro_cells, micro_scale, micro_sets, silent
from synthetic import make_frame
from tools.experiments.cells import Cell
from tools.experiments.estimate import TIMED, WARM_UP, Speed, cell_seconds, hours, measure_speed, shared_seconds
from tools.experiments.figure import few_frames_figure, matrix_figure, png_of
from tools.experiments.machine import Machine
from tools.experiments.means import grouped, mean_of
from tools.experiments.outcome import Outcome, numbers_of
from tools.experiments.plans import matrix_cells
from tools.experiments.published import published_ap
from tools.experiments.scales import CLASSES, MAPS, SCALES
from tools.experiments.table import plain_rows, tables


def outcome(trained: str, tested: str, ap: float, *, seed: int = 0, frames: int | None = None) -> Outcome:
    """Make a test of cars whose AP differs by metric, level and rule in a known way."""
    levels = ("Easy", "Moderate", "Hard") + (("Large", "Small") if tested == "sim" else ())
    numbers = {
        metric: {level: {"r11": ap + up - down, "r40": ap + up - down - 5.0} for down, level in enumerate(levels)}
        for metric, up in (("3d", 0.0), ("bev", 10.0))
    }
    return Outcome("Car", "default", trained, frames, seed, tested, 100, 50, numbers)


def cells_of(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]


def table_after(text: str, title: str) -> list[list[str]]:
    lines = text[text.index(title) :].splitlines()[2:]
    rows = [cells_of(line) for line in lines[: lines.index("") if "" in lines else None]]
    return [rows[0], *rows[2:]]


def test_the_interval_is_students() -> None:
    assert str(mean_of([70.0])) == "70.00"
    mean = mean_of([70.0, 72.0, 77.0])
    # Mean 73; squares 9 + 1 + 16 over 2 are 13; 4.303 sqrt(13 / 3) = 8.957.
    assert (mean.value, mean.count) == (73.0, 3)
    assert str(mean) == "73.00 ±8.96"


def test_the_table_has_means_intervals_and_the_papers_numbers() -> None:
    groups = grouped(
        [
            outcome("real", "real", 72.0, seed=1),
            outcome("real", "real", 70.0),
            outcome("sim", "real", 40.0),
            outcome("sim", "sim", 60.0),
        ]
    )
    text = tables(groups)
    header, real, sim = table_after(text, "**AP R11 in percent on real frames, the paper's in parentheses**")
    assert header[:5] == ["trained on", "class", "maps", "3D Easy", "3D Moderate"]
    # Two values that differ by 2: a deviation of sqrt(2), by sqrt(2) is 1, times 12.706.
    assert real == [
        *("real", "Car", "default", "71.00 ±12.71 (83.46)", "70.00 ±12.71 (73.94)", "69.00 ±12.71 (67.81)"),
        *("81.00 ±12.71 (89.37)", "80.00 ±12.71 (86.44)", "79.00 ±12.71 (78.64)"),
    ]
    assert sim[:5] == ["simulated", "Car", "default", "40.00 (29.85)", "39.00 (20.29)"]
    header, real, sim = table_after(text, "**AP R40 in percent on real frames**")
    assert sim == ["simulated", "Car", "default", "35.00", "34.00", "33.00", "45.00", "44.00", "43.00"]
    header, sim = table_after(text, "**AP R11 in percent on simulated frames, the paper's in parentheses**")
    assert header[3:] == ["3D Large", "3D Small", "BEV Large", "BEV Small"]
    # Large and Small come after Easy, Moderate and Hard.
    assert sim[3:] == ["57.00 (70.86)", "56.00 (69.37)", "67.00 (80.13)", "66.00 (71.32)"]
    assert "number of real frames" not in text

    rows = plain_rows(groups)
    (real_row,) = [row for row in rows if row["trained"] == "real"]
    assert (real_row["seeds"], real_row["num_frames"]) == ([0, 1], 50)
    assert real_row["ap"]["3d"]["Moderate"]["r11"]["by_seed"] == [69.0, 71.0]
    assert real_row["ap"]["3d"]["Moderate"]["r11"]["mean"] == 70.0
    assert real_row["ap"]["3d"]["Moderate"]["paper"] == 73.94
    assert tables([]) == "No cell is finished.\n"


def few(seeds: Sequence[int] = (0, 1)) -> list[Outcome]:
    found = [outcome("given", "real", 51.0)]
    for seed in seeds:
        found += [outcome("real", "real", 20.0 + 10 * k + 2 * seed, seed=seed, frames=10 * 4**k) for k in range(3)]
        found += [outcome("tuned", "real", 60.0 + 5 * k + seed, seed=seed, frames=10 * 4**k) for k in range(3)]
        found += [outcome("mixed", "real", 61.0 + 5 * k + seed, seed=seed, frames=10 * 4**k) for k in range(3)]
        found += [outcome("longer", "real", 52.0 + seed, seed=seed)]
    return found


def test_numbers_are_taken_out_of_reports_by_metric_level_and_rule() -> None:
    truths = {f"{number:06d}": make_frame(seed=number).labels for number in range(50)}
    # All are found where they are, and every second has half its height.
    found = {
        frame_id: tuple(
            replace(
                label, score=0.9, dimensions_hwl=(0.7, *label.dimensions_hwl[1:]) if index else label.dimensions_hwl
            )
            for index, label in enumerate(label for label in labels if label.type == "Car")
        )
        for frame_id, labels in truths.items()
    }
    reports = {levels: evaluate(truths, found, classes=("Car",), levels=levels) for levels in ("kitti", "large_small")}
    numbers = numbers_of(reports, "Car")
    assert set(numbers["3d"]) == {"Easy", "Moderate", "Hard", "Large", "Small"}
    for levels, report in reports.items():
        for metric in ("3d", "bev"):
            for level, curve in report.curves["Car"][metric].items():
                assert numbers[metric][level] == {"r11": curve.r11, "r40": curve.r40}, levels
    assert numbers["bev"]["Large"]["r40"] > 99.0 and 10.0 < numbers["3d"]["Large"]["r40"] < 90.0
    assert numbers["3d"]["Large"]["r11"] != numbers["3d"]["Large"]["r40"]
    nothing = numbers_of({"kitti": evaluate(truths, dict.fromkeys(truths, ()), classes=("Car",))}, "Car")
    assert nothing["3d"] == {level: {"r11": 0.0, "r40": 0.0} for level in ("Easy", "Moderate", "Hard")}


def test_the_table_by_number_of_frames() -> None:
    header, *rows = table_after(tables(grouped(few())), "**AP R40 Moderate in percent by number of real frames")
    assert header[2:] == ["real frames", "trained on", "3D", "BEV", "3D gain", "BEV gain"]
    # Moderate is 1 below and R40 5: 20 and 22 are 14 and 16.
    assert [row[2:] for row in rows[:5]] == [
        ["0", "given weights", "45.00", "55.00", "", ""],
        ["0", "simulated, longer", "46.50 ±6.35", "56.50 ±6.35", "", ""],
        # Seed by seed 32 and 31 less, and 8 and 9 more.
        ["10", "real", "15.00 ±12.71", "25.00 ±12.71", *["-31.50 ±6.35"] * 2],
        ["10", "simulated, then real", "54.50 ±6.35", "64.50 ±6.35", *["8.00 ±0.00"] * 2],
        ["10", "simulated, then both", "55.50 ±6.35", "65.50 ±6.35", *["9.00 ±0.00"] * 2],
    ]
    assert [row[2] for row in rows] == ["0"] * 2 + ["10"] * 3 + ["40"] * 3 + ["160"] * 3


def test_the_papers_numbers_fall_as_levels_get_harder_and_boxes_get_a_height() -> None:
    count = 0
    for trained, tested in (("real", "real"), ("sim", "sim"), ("sim", "real"), ("tuned", "real")):
        levels = ("Easy", "Moderate", "Hard") if tested == "real" else ("Large", "Small")
        for class_name in CLASSES:
            for maps in MAPS:
                key = (trained, tested, class_name, maps)
                by_metric = [[published_ap(*key, metric, level) for level in levels] for metric in ("3d", "bev")]
                volumes, areas = ([value for value in row if value is not None] for row in by_metric)
                assert volumes == sorted(volumes, reverse=True) and areas == sorted(areas, reverse=True), key
                assert all(area >= volume for volume, area in zip(volumes, areas, strict=True)), key
                count += len(volumes) + len(areas)
    # Six tables of three levels and two of two, less pedestrians from simulated to real frames, which are not there.
    assert count == 3 * 2 * (5 * 3 + 2 * 2)
    assert published_ap("sim", "real", "Pedestrian", "default", "3d", "Easy") is None
    assert published_ap("sim", "sim", "Car", "default", "3d", "Easy") is None


def test_figures_are_drawn_of_what_there_is() -> None:
    assert matrix_figure([]) is None and few_frames_figure([]) is None
    assert matrix_figure(grouped(few())) is None and few_frames_figure(grouped([outcome("sim", "real", 1.0)])) is None


def test_bars_and_lines_stand_where_their_numbers_are() -> None:
    figure = matrix_figure(grouped([outcome("real", "real", 70.0), outcome("sim", "real", 35.0)]))
    assert figure is not None
    drawn: list[Any] = figure.axes
    for axis, up, papers in zip(drawn, (0.0, 10.0), ([73.94, 20.29], [86.44, 37.81]), strict=True):
        # Moderate is 1 below Easy.
        assert [bar.get_height() for bar in axis.patches] == [69.0 + up, 34.0 + up]
        across = [lines for lines in axis.collections if lines.get_linewidth() == [2.0]]
        assert [lines.get_segments()[0][:, 1].tolist() for lines in across] == [[paper] * 2 for paper in papers]
    figure = few_frames_figure(grouped(few()))
    assert figure is not None
    containers: list[Any] = figure.axes[0].containers
    lines = [container.lines[0] for container in containers]
    assert all(line.get_xdata().tolist() == [10, 40, 160] for line in lines)
    # R40 is 5 below R11; the means of two seeds.
    expected = [[15.0, 25.0, 35.0], [54.5, 59.5, 64.5], [55.5, 60.5, 65.5]]
    assert [line.get_ydata().tolist() for line in lines] == expected
    assert png_of(figure) == png_of(figure)


def full_cells() -> tuple[Cell, ...]:
    return matrix_cells(SCALES["full"], ("Car",), ("default",), 1)


def test_the_estimate_adds_steps_and_frames() -> None:
    sim, real, tuned = full_cells()
    num_val = {"real": 3_769, "sim": 2_000}
    speed = Speed(step_s=0.5, frame_s=0.1)
    # Of 60 checkpoints the best of the last 20 is chosen on the first set.
    assert cell_seconds(sim, speed, num_val) == pytest.approx(120_000 * 0.5 + (20 * 2_000 + 3_769) * 0.1)
    assert cell_seconds(real, speed, num_val) == pytest.approx(120_000 * 0.5 + 20 * 3_769 * 0.1)
    assert cell_seconds(tuned, speed, num_val) == pytest.approx(60_000 * 0.5 + (20 * 3_769 + 2_000) * 0.1)
    tiny = matrix_cells(SCALES["tiny"], ("Car",), ("default",), 1)[2]
    assert cell_seconds(tiny, speed, num_val) == pytest.approx(350 * 0.5 + (3_769 + 2_000) * 0.1)


def test_devices_share_cells_and_wait_for_sources() -> None:
    cells = matrix_cells(SCALES["full"], ("Car",), MAPS[:2], 1)
    seconds = dict(zip((cell.name for cell in cells), (4.0, 3.0, 2.0, 4.0, 3.0, 2.0), strict=True))
    assert shared_seconds(cells, seconds, 1) == 18.0
    # sim 0-4 and real 0-3; tuned waits for its source; sim 3-7, and so on:
    # A: sim 0-4, tuned 4-6, real 6-9; B: real 0-3, sim 3-7, tuned 7-9.
    assert shared_seconds(cells, seconds, 2) == 9.0
    # No more devices help than the longest chain lets: sim, then tuned.
    assert shared_seconds(cells, seconds, 8) == 6.0
    assert shared_seconds([], {}, 2) == 0.0
    # The first device is free at 5, and what comes next begins with what the second ends at 6.
    waiting = [cells[index] for index in (0, 3, 1, 5)]
    times = dict(zip((cell.name for cell in waiting), (4.0, 6.0, 1.0, 2.0), strict=True))
    assert shared_seconds(waiting, times, 2) == 8.0
    # A source that is finished keeps nobody waiting.
    assert shared_seconds(cells[2:3], seconds, 1) == 2.0
    assert [hours(value) for value in (90.0, 5_400.0)] == ["1.5 min", "1.5 h"]


def test_speed_is_measured_after_a_warm_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sets = micro_sets(tmp_path)
    config = micro_cells(micro_scale(tmp_path))[0].config
    clock = iter(float(k**2) for k in range(100))
    monkeypatch.setattr("tools.experiments.estimate.time.perf_counter", lambda: next(clock))
    machine = Machine(processes=Processes(), should_stop=lambda: False, progress=silent)
    speed = measure_speed(config, sets["real"], machine)
    # Steps end at 0, 1, 4, ...: from the third to the tenth. Of two frames the first is the warm-up.
    first, last = WARM_UP - 1, WARM_UP + TIMED - 1
    assert speed.step_s == (last**2 - first**2) / TIMED
    begin = WARM_UP + TIMED + 1
    assert speed.frame_s == (begin + 2) ** 2 - (begin + 1) ** 2
