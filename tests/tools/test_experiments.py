"""The experiments' cells, and that a kill in the middle changes no number of theirs."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import re
import threading
from collections import Counter
from pathlib import Path

import pytest

from avod.detector import Detector
from avod.predict import predict
from avod.train.checkpoint import checkpoints, read_checkpoint
from avod.train.log import read_log
from avod.train.settings import read_record
from cadet import evaluate
from cadet._util.operating_system import locked_folder
from cadet.errors import CadetError
from cadet.formats.kitti import text_from_labels
from detector.experiments import STEPS, micro_cells, micro_scale, micro_sets, run_micro
from detector.runs import assert_same_training, weights
from tools.experiments.cells import Cell
from tools.experiments.experiment import selected
from tools.experiments.outcome import is_finished, read_outcomes
from tools.experiments.plans import few_frame_cells
from tools.experiments.record import begin_experiment, cell_folder
from tools.experiments.scales import SCALES, Scale
from tools.experiments.sets import FrameSet, Sets, check_sets


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("experiments")


@pytest.fixture(scope="module")
def sets(folder: Path) -> Sets:
    return micro_sets(folder)


@pytest.fixture(scope="module")
def scale(folder: Path) -> Scale:
    return micro_scale(folder)


@pytest.fixture(scope="module")
def finished(folder: Path, scale: Scale, sets: Sets) -> Path:
    """Return the folder of a matrix that ran from its first step to its last."""
    assert run_micro(folder / "unbroken", micro_cells(scale), scale, sets)
    return folder / "unbroken"


class StopFrom:
    """Hears a signal after so many steps and frames."""

    def __init__(self, calls: int) -> None:
        self.left = calls

    def __call__(self) -> bool:
        self.left -= 1
        return self.left <= 0


class DieAfter:
    """Ends a process where it stands, as a kill does: no checkpoint is written."""

    def __init__(self, calls: int) -> None:
        self.left = calls

    def __call__(self) -> bool:
        self.left -= 1
        if self.left == 0:
            raise MemoryError
        return False


def run_until_finished(out: Path, cells: tuple[Cell, ...], scale: Scale, sets: Sets) -> int:
    """Run cells that are killed, or told to stop, again and again; return how often."""
    for attempt in range(40):
        # A checkpoint every second step: three are enough to get on.
        stop = DieAfter(3) if attempt % 2 else StopFrom(3)
        try:
            if run_micro(out, cells, scale, sets, stop):
                return attempt
        except MemoryError:
            pass
    raise AssertionError("it does not come to an end")


@pytest.mark.timeout(240)
@pytest.mark.parametrize("branch_step", [None, 3])
def test_killed_again_and_again_it_has_the_numbers_of_an_unbroken_run(
    sets: Sets, tmp_path: Path, branch_step: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    # What a stop leaves between two checkpoints must not be chosen from.
    monkeypatch.setattr("tools.experiments.testing.best", lambda scored: scored[0])
    scale = micro_scale(tmp_path, branch_step=branch_step, last=2)
    cells = micro_cells(scale)
    assert run_micro(tmp_path / "unbroken", cells, scale, sets)
    assert run_until_finished(tmp_path / "broken", cells, scale, sets) > 5
    for name in ("results.json", "table.md", "matrix.png"):
        assert (tmp_path / "broken" / name).read_bytes() == (tmp_path / "unbroken" / name).read_bytes(), name
    for cell in cells:
        mine, other = (cell_folder(tmp_path / name, cell.name) for name in ("broken", "unbroken"))
        for tested in cell.tests:
            files = sorted(path.name for path in (other / f"detections_{tested}").iterdir())
            assert files == [f"{frame_id}.txt" for frame_id in sets[tested].val_ids]
            for file in files:
                one, two = (path / f"detections_{tested}" / file for path in (mine, other))
                assert one.read_bytes() == two.read_bytes() and one.stat().st_size > 0
        assert (mine / "best" / "model.safetensors").read_bytes() == (other / "best" / "model.safetensors").read_bytes()


def test_a_tuning_begins_where_it_should(finished: Path, scale: Scale, sets: Sets, tmp_path: Path) -> None:
    sim, real, tuned = micro_cells(scale)
    record = read_record(cell_folder(finished, tuned.name) / "run")
    assert record.init == str(cell_folder(finished, sim.name) / "best")
    assert (Path(str(record.data)), record.num_used) == (sets["real"].folder.resolve(), 4)
    assert Path(str(read_record(cell_folder(finished, sim.name) / "run").data)) == sets["sim"].folder.resolve()
    assert (read_record(cell_folder(finished, real.name) / "run").init, record.config.training.steps) == (None, 2)
    # The paper's way: optimizer and schedule of a step in the middle, and the source goes on as if nothing had been.
    branched = micro_scale(tmp_path, branch_step=3)
    cells = micro_cells(branched)
    assert run_micro(tmp_path / "out", cells, branched, sets)
    source, goal = (cell_folder(tmp_path / "out", cells[index].name) for index in (0, 2))
    assert [path.name for path in checkpoints(source / "kept")] == ["000000003"]
    assert (source / "kept" / "000000003" / "optimizer.safetensors").is_file()
    assert read_checkpoint(goal / "best").step == 5
    one, other = (weights(cell_folder(out, sim.name) / "best") for out in (tmp_path / "out", finished))
    assert all((one[name] == other[name]).all() for name in one)


def test_what_was_killed_before_its_first_checkpoint_begins_again(
    finished: Path, scale: Scale, sets: Sets, tmp_path: Path
) -> None:
    cells = micro_cells(scale)[:1]
    begun, whole = (cell_folder(out, cells[0].name) / "run" for out in (tmp_path, finished))
    begun.mkdir(parents=True)
    for name in ("run.json", "log.csv"):
        (begun / name).write_bytes((whole / name).read_bytes())
    assert len(read_log(begun / "log.csv")) == 1
    assert run_micro(tmp_path, cells, scale, sets)
    assert_same_training(begun, whole)


def test_a_finished_cell_is_not_run_again(finished: Path, scale: Scale, sets: Sets) -> None:
    cells = micro_cells(scale)
    assert all(is_finished(finished, cell) for cell in cells)
    before = {path: path.stat().st_mtime_ns for path in (finished / "cells").rglob("*") if path.is_file()}
    assert run_micro(finished, cells, scale, sets, DieAfter(1))
    assert {path: path.stat().st_mtime_ns for path in (finished / "cells").rglob("*") if path.is_file()} == before


def test_pairs_on_a_few_frames_learn_from_the_same_ones(sets: Sets, folder: Path, finished: Path) -> None:
    scale = micro_scale(folder)
    cells = few_frame_cells(scale, ("Car",), ("default",), 1, (1, 3))
    # The pre-training is the matrix's own.
    assert run_micro(finished, cells, scale, sets)
    checksums = {}
    for cell in cells[1:]:
        record = read_record(cell_folder(finished, cell.name) / "run")
        num_sim = sets["sim"].num_train if "sim" in cell.data else 0
        assert record.num_used == num_sim + (cell.frames or 0) and record.config.training.steps == cell.stops[-1]
        checksums[cell.trained, cell.frames] = record.frames_crc32
    for count in (1, 3):
        assert checksums["real", count] == checksums["tuned", count]
    found = {(item.trained, item.frames): item for item in read_outcomes(finished) if item.tested == "real"}
    assert set(found) == {
        ("sim", None),
        ("longer", None),
        *((way, count) for way in ("real", "tuned") for count in (None, 1, 3)),
        *(("mixed", count) for count in (1, 3)),
    }
    assert (finished / "few_frames.png").is_file() and "simulated, then both" in (finished / "table.md").read_text()


def test_another_experiment_in_the_same_folder_is_refused(
    finished: Path, scale: Scale, sets: Sets, folder: Path
) -> None:
    def begin(scale: Scale = scale, steps: int | None = None, sets: Sets = sets) -> None:
        begin_experiment(finished, scale, steps, sets)

    begin()
    with pytest.raises(CadetError, match=r"begun with scale = 'micro', and is to go on with 'full': name a new folder"):
        begin(SCALES["full"])
    with pytest.raises(CadetError, match="begun with steps = None, and is to go on with 3"):
        begin(steps=3)
    with pytest.raises(CadetError, match=r"begun with sets\.real\.num_train = 4, and is to go on with 3"):
        begin(sets={"real": sets["sim"], "sim": sets["sim"]})
    # Equal ids, other labels.
    label = sets["real"].folder / "training" / "label_2" / f"{sets['real'].val_ids[0]}.txt"
    text = label.read_text()
    label.write_text(text.replace("Pedestrian", "Cyclist"))
    changed = FrameSet.read(sets["real"].folder)
    label.write_text(text)
    with pytest.raises(CadetError, match=r"begun with sets\.real\.crc32 = \d+, and is to go on with \d+"):
        begin(sets={"real": changed, "sim": sets["sim"]})
    # A set that is not needed may be left out, and one may come later.
    begin(sets={"real": sets["real"]})
    begin()
    cells = micro_cells(scale)
    training = dataclasses.replace(cells[0].config.training, learning_rate=1e-3)
    other = dataclasses.replace(cells[0], config=dataclasses.replace(cells[0].config, training=training))
    (cell_folder(finished, other.name) / "test_real.json").rename(folder / "aside.json")
    with pytest.raises(CadetError, match=r"sim-seed0: begun with config.training.learning_rate = 0.004, and is to"):
        run_micro(finished, [other], scale, sets)
    (folder / "aside.json").rename(cell_folder(finished, other.name) / "test_real.json")


def test_sets_that_lack_what_a_cell_needs_are_refused_before_it_starts(scale: Scale, sets: Sets) -> None:
    sim, real, _ = micro_cells(scale)
    few = dataclasses.replace(real, frames=4)
    check_sets([sim, real, few], sets)
    with pytest.raises(CadetError, match=r"real: 4 of its train frames hold Car or more, and car-default-real-5frames"):
        check_sets([sim, dataclasses.replace(real, frames=5)], sets)
    training = dataclasses.replace(real.config.training, min_objects=3)
    picky = dataclasses.replace(real, config=dataclasses.replace(real.config, training=training))
    with pytest.raises(CadetError, match=r"real: 0 of its train frames hold 3 of Car or more, and \S+ learns from 1"):
        check_sets([picky], sets)
    without = dict(sets["sim"].objects) | {"val": (Counter(Van=2),)}
    with pytest.raises(CadetError, match="sim: its val frames hold no Car for car-default-sim-seed0 to find"):
        check_sets([sim], {**sets, "sim": dataclasses.replace(sets["sim"], objects=without)})


def test_the_best_of_the_last_checkpoints_counts(
    scale: Scale, sets: Sets, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cells = [dataclasses.replace(micro_cells(scale)[0], last=2)]
    monkeypatch.setattr("tools.experiments.testing.forget_old", lambda folder, keep: None)
    aps = iter([30.0, 20.0, 10.0])
    monkeypatch.setattr("tools.experiments.testing.score", lambda report, names: next(aps))
    assert run_micro(tmp_path, cells, scale, sets)
    place = cell_folder(tmp_path, cells[0].name)
    written = checkpoints(place / "run" / "checkpoints")
    assert [path.name for path in written] == ["000000002", "000000004"]
    # Chosen on the first set, and tested as it is on the other.
    assert [(item.tested, item.step) for item in read_outcomes(tmp_path)] == [("sim", 2), ("real", 2)]
    assert (place / "best" / "model.safetensors").read_bytes() == (written[0] / "model.safetensors").read_bytes()
    detector = Detector(written[0])
    for tested in ("sim", "real"):
        for frame_id, labels in predict(detector, sets[tested].folder, sets[tested].val_ids):
            assert (place / f"detections_{tested}" / f"{frame_id}.txt").read_text() == text_from_labels(labels)


def test_a_cells_numbers_are_those_of_cadet_eval(finished: Path, sets: Sets) -> None:
    num_compared = 0
    for item in read_outcomes(finished):
        if item.frames is None:
            place = finished / "cells" / f"car-default-{item.trained}-seed0" / f"detections_{item.tested}"
            for levels in ("kitti", "large_small") if item.tested == "sim" else ("kitti",):
                report = evaluate(sets[item.tested].folder, place, classes=["Car"], levels=levels)
                for metric in ("3d", "bev"):
                    # After four steps some cells find no car.
                    for level, curve in report.curves.get("Car", {}).get(metric, {}).items():
                        assert item.ap[metric][level] == {"r11": curve.r11, "r40": curve.r40}
                        num_compared += 1
    assert num_compared > 0


def test_cells_are_chosen_by_patterns(finished: Path, scale: Scale, tmp_path: Path) -> None:
    cells = micro_cells(scale)
    sim, real, tuned = cells
    assert selected(cells, (), tmp_path) == cells
    assert selected(cells, ("*-tuned-*", "*sim*"), tmp_path) == (sim, tuned)
    assert selected(cells, ("*-tuned-*",), finished) == (tuned,)
    with pytest.raises(CadetError, match="tuned-seed0 begins with the weights of car-default-sim-seed0, which is not"):
        selected(cells, ("*-tuned-*",), tmp_path)
    with pytest.raises(CadetError, match=re.escape("--cells ped-*: names none of car-default-sim-seed0, car-")):
        selected(cells, ("ped-*",), tmp_path)


def test_two_processes_do_not_run_one_cell(
    scale: Scale, sets: Sets, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tools.experiments.experiment.WAIT_S", 0.1)
    cells = micro_cells(scale)
    place = cell_folder(tmp_path, cells[0].name)
    place.mkdir(parents=True)
    with (
        locked_folder(place, place / ".lock"),
        pytest.raises(CadetError, match="sim-seed0: another process is at work on this cell"),
    ):
        run_micro(tmp_path, cells[:1], scale, sets)


def test_a_cell_waits_for_what_a_killed_process_left_behind(scale: Scale, sets: Sets, tmp_path: Path) -> None:
    (cell, *_) = micro_cells(scale)
    place = cell_folder(tmp_path, cell.name)
    place.mkdir(parents=True)
    with contextlib.ExitStack() as held:
        held.enter_context(locked_folder(place, place / ".lock"))
        timer = threading.Timer(0.5, held.close)
        timer.start()
        assert run_micro(tmp_path, [cell], scale, sets)
        timer.join()


def test_a_damaged_file_is_named(finished: Path, scale: Scale, sets: Sets, folder: Path) -> None:
    path = cell_folder(finished, micro_cells(scale)[1].name) / "test_real.json"
    text = path.read_text()
    for damaged, message in (
        ("{", r"test_real.json:\d+: invalid JSON"),
        ("{}", "test_real.json: not a file of the experiments"),
        (text.replace('"version": 1', '"version": 2'), "test_real.json: version 2, expected 1"),
        (text.replace('"r40"', '"r41"'), "real-seed0: damaged: KeyError: 'r40'"),
        (json.dumps({**json.loads(text), "ap": [1]}), "real-seed0: damaged: TypeError"),
    ):
        path.write_text(damaged)
        with pytest.raises(CadetError, match=message):
            read_outcomes(finished)
    path.write_text(text)
    assert len(read_outcomes(finished)) >= STEPS
