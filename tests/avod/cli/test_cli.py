"""The commands from end to end on a tiny folder."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result

from avod.cli.commands import avod
from avod.cli.options import resolve_workers
from avod.config import Config
from avod.data.sample import Sample
from avod.detector import Detector
from avod.evaluate import analyze_detectors, evaluate_detector, score
from avod.figures import _running_mean
from avod.train.step import new_network
from cadet import kitti
from cadet.cli.tools import cadet
from cadet.errors import CadetError, CadetWarning
from cadet.formats.kitti import Calibration, Label, labels_from_text, write_frame
from cadet.formats.kitti.frame import Frame
from synthetic import make_frame

CONFIG = Path(__file__).parents[2] / "support" / "detector" / "overfit.toml"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("kitti")
    for index, split in enumerate(("train", "train", "val")):
        write_frame(root, index, make_frame(), split=split)
    return root


@pytest.fixture(scope="module")
def trained(dataset: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run")
    config = tmp_path_factory.mktemp("config") / "unsure.toml"
    # After ten steps the network is sure of nothing.
    config.write_text(f"base = {json.dumps(str(CONFIG))}\n[detection]\nmin_score = 0.0\n")
    call("train", "--config", config, "--data", dataset, "--out", out, "--steps", 10)
    return out


def table_of(result: Result) -> list[str]:
    return [line for line in result.output.splitlines() if re.search(r"^ *(Car)? +(2D|BEV|3D|AOS) ", line)]


def call(*arguments: object) -> Result:
    result = CliRunner().invoke(avod, [str(argument) for argument in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result


def test_training_leaves_a_log_and_a_checkpoint(trained: Path) -> None:
    assert (trained / "log.csv").read_text().count("\n") == 2
    assert sorted(path.name for path in (trained / "checkpoints" / "000000010").iterdir()) == [
        "checkpoint.json",
        "model.safetensors",
        "optimizer.safetensors",
    ]
    # Whoever may read one file may read all.
    assert len({path.stat().st_mode for path in (trained / "checkpoints" / "000000010").iterdir()}) == 1


def test_an_interrupted_training_says_how_to_go_on(
    dataset: Path, trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("avod.cli.train.train", interrupt)
    for out, expected in (
        (tmp_path, r"interrupted; no checkpoint yet: --out \S+ --resume begins again"),
        (trained, r"interrupted; last checkpoint: \S+/000000010; to continue: avod train --out \S+ --resume"),
    ):
        arguments = ["train", "--config", str(CONFIG), "--data", str(dataset), "--out", str(out)]
        assert avod.main(arguments, standalone_mode=False) == 130
        assert re.fullmatch(expected, capsys.readouterr().err.strip().splitlines()[-1])


def test_prediction_writes_a_file_for_each_frame(dataset: Path, trained: Path, tmp_path: Path) -> None:
    result = call("predict", "--checkpoint", trained, "--data", dataset, "--out", tmp_path / "found")
    files = sorted((tmp_path / "found").iterdir())
    assert [path.name for path in files] == ["000000.txt", "000001.txt", "000002.txt"]
    found = [labels_from_text(path.read_text()) for path in files]
    assert all(label.score is not None for labels in found for label in labels)
    # Its three frames are the same.
    assert found[0] == found[1] == found[2] and len(found[0]) > 0
    assert f"{sum(map(len, found))} detections in 3 frames" in result.output


def test_evaluation_prints_the_table_of_cadet_and_keeps_the_best(dataset: Path, trained: Path, tmp_path: Path) -> None:
    result = call("eval", "--checkpoint", trained, "--data", dataset, "--last", 2)
    assert sorted(path.name for path in (trained / "best").iterdir()) == ["checkpoint.json", "model.safetensors"]
    again = call("eval", "--checkpoint", trained / "best", "--data", dataset)
    assert table_of(again) == table_of(result)
    assert re.search(r"^000000010 +\d+\.\d\d +best$", result.output, re.MULTILINE)
    found = tmp_path / "found"
    call("predict", "--checkpoint", trained / "best", "--data", dataset, "--split", "val", "--out", found)
    ours = CliRunner().invoke(cadet, ["eval", str(dataset), str(found), "--classes", "Car", "--split", "val"])
    assert table_of(ours) == table_of(result) != [], "one table, whoever prints it"


def test_all_checkpoints_are_evaluated_on_one_reading(
    dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tmp_path / "often.toml"
    config.write_text(
        f"base = {json.dumps(str(CONFIG))}\n[training]\ncheckpoint_steps = 1\n[detection]\nmin_score = 0.0\n"
    )
    run = tmp_path / "run"
    call("train", "--config", config, "--data", dataset, "--out", run, "--steps", 3, "--workers", 0)
    read: list[str] = []
    right = kitti.read_frame

    def counting(root: Path, frame_id: str, **options: Any) -> Frame:
        read.append(frame_id)
        return right(root, frame_id, **options)

    monkeypatch.setattr("cadet.formats.kitti.dataset.read_frame", counting)
    result = call("eval", "--checkpoint", run, "--data", dataset, "--split", "all", "--last", 3, "--workers", 0)
    assert read == ["000000", "000001", "000002"]
    values = re.findall(r"^(\d{9})  (\d+\.\d\d)", result.output, re.MULTILINE)
    for name, value in values:
        detector = Detector(run / "checkpoints" / name)
        report = evaluate_detector(detector, dataset, kitti.Dataset(dataset).ids)
        assert f"{score(report, detector.config.class_names):.2f}" == value
    assert [name for name, _ in values] == ["000000001", "000000002", "000000003"]


def test_each_of_several_detectors_is_evaluated_by_what_it_finds(dataset: Path) -> None:
    class Sure(Detector):
        """Finds what `found` says."""

        found: tuple[Label, ...] = ()

        def detect_samples(self, samples: Sequence[Sample], calibs: Sequence[Calibration]) -> list[tuple[Label, ...]]:
            return [self.found] * len(samples)

    network = new_network(Config.named(CONFIG), 0)
    detectors = [Sure(network), Sure(network), Sure(network)]
    truths = tuple(dataclasses.replace(label, score=0.9) for label in make_frame().labels if not label.is_dont_care)
    detectors[1].found = truths
    ids = kitti.Dataset(dataset).ids
    reports = [analysis.report for analysis in analyze_detectors(detectors, dataset, ids)]
    blind, whole, other = (score(report, ("Car",)) for report in reports)
    assert blind == other == 0.0 < whole
    detectors[2] = Sure(new_network(Config.named("tiny_car"), 0))
    with pytest.raises(CadetError, match="these detectors need different inputs, their 'classes' differ"):
        analyze_detectors(detectors, dataset, ids)


def test_detection_can_be_changed_for_one_run(dataset: Path, trained: Path, tmp_path: Path) -> None:
    def detected(*options: object) -> list[Label]:
        out = tmp_path / "_".join(map(str, options)) / "found"
        call("predict", "--checkpoint", trained, "--data", dataset, "--num-frames", 1, "--out", out, *options)
        return list(labels_from_text((out / "000000.txt").read_text()))

    # Nothing overlaps by more than all of it, so all boxes stay.
    every = detected("--nms-iou", 1.0)
    scores = [label.score or 0.0 for label in every]
    assert scores == sorted(scores, reverse=True)
    limit = sorted(set(scores))[len(set(scores)) // 2]
    above = detected("--nms-iou", 1.0, "--min-score", limit)
    assert [label.score for label in above] == [score for score in scores if score >= limit]
    assert 0 < len(above) < len(every)
    assert 0 < len(detected()) < len(every), "at the configuration's limit boxes suppress each other"
    assert len(detected("--proposals", 1, "--nms-iou", 1.0)) <= 1
    assert detected("--nms-iou", 1.0, "--set", f"detection.min_score={limit}") == above
    with pytest.raises(CadetError, match=r"^--set: rpn\.hidden: expected \d+, with which the weights"):
        detected("--set", "rpn.hidden=5")
    result = call("eval", "--checkpoint", trained, "--data", dataset, "--min-score", 1.0)
    assert table_of(result) == [], "nothing is found"


def test_frames_are_read_by_as_many_processes_as_there_are_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda pid: {1, 4, 5})
    assert [resolve_workers(count) for count in (None, 0, 7)] == [3, 0, 7]
    monkeypatch.setattr("os.sched_getaffinity", lambda pid: set(range(96)))
    assert resolve_workers(None) == 16


def test_the_bench_names_the_stages(dataset: Path, trained: Path) -> None:
    result = call("bench", "--checkpoint", trained, "--data", dataset, "--num-frames", 2)
    times = {
        match[1]: float(match[2])
        for match in re.finditer(r"^ *([a-z][a-z ,()]+?) +(\d+\.\d) *$", result.output, re.MULTILINE)
    }
    assert set(times) == {"maps, anchors, image", "network", "boxes", "inference", "reading files (apart)"}
    parts = times["maps, anchors, image"] + times["network"] + times["boxes"]
    assert times["inference"] == pytest.approx(parts, abs=0.3)
    assert "mean over 2 frames on cpu" in result.output


def test_figures_are_drawn(dataset: Path, trained: Path, tmp_path: Path) -> None:
    call("view", "--checkpoint", trained, "--data", dataset, "--frame-id", "000002", "-o", tmp_path / "a.png")
    call("view", "--log", trained, "-o", tmp_path / "b.png")
    beside, losses = cv2.imread(str(tmp_path / "a.png")), cv2.imread(str(tmp_path / "b.png"))
    assert beside is not None and losses is not None
    assert beside.shape[1] == 2 * 620 + 12
    assert losses.shape == (480, 960, 3) and losses.max() > 150


def test_curves_are_running_means() -> None:
    values = np.random.default_rng(0).uniform(1, 2, 200)
    expected = [values[max(k - 3, 0) : k + 4].mean() for k in range(200)]
    np.testing.assert_allclose(_running_mean(values.tolist()), expected)
    assert _running_mean([4.0]).tolist() == [4.0]


def test_mistakes_are_named(dataset: Path, trained: Path, tmp_path: Path) -> None:
    cases = [
        (
            ("train", "--config", "none", "--data", dataset, "--out", tmp_path),
            "unknown configuration 'none'; known: ",
        ),
        (("train", "--config", CONFIG, "--data", tmp_path / "no", "--out", tmp_path), "no: no such folder"),
        (("train", "--config", CONFIG, "--data", dataset, "--split", "no", "--out", tmp_path), "no such split"),
        (("predict", "--checkpoint", tmp_path, "--data", dataset, "--out", tmp_path), "not a checkpoint"),
        (
            ("predict", "--checkpoint", trained, "--data", dataset, "--out", tmp_path, "--device", "gpu"),
            "--device: 'gpu'",
        ),
        (("predict", "--checkpoint", trained, "--data", dataset), "predict needs --out, --video, or both"),
        (
            ("predict", "--checkpoint", trained, "--data", dataset, "--video", "film.avi"),
            "film.avi: expected a name that ends in .mp4",
        ),
        (("view", "--checkpoint", trained, "-o", "a.png"), "view needs --checkpoint, --data and --frame-id, or --log"),
        (("view", "--log", tmp_path, "-o", "a.png"), "log.csv: no such file"),
        (("view", "--log", trained, "-o", "a.gif"), "a.gif: expected a name that ends in .png, .jpg, .jpeg"),
        (("bench", "--checkpoint", trained, "--data", dataset, "--workers", 2), "--workers"),
    ]
    for arguments, message in cases:
        with pytest.raises(CadetError) as error:
            CliRunner().invoke(avod, [str(a) for a in arguments], catch_exceptions=False)
        assert message in str(error.value)


@pytest.mark.parametrize("workers", [0, 2])
def test_prediction_writes_the_frames_that_can_be_read_and_ends_by_naming_the_others(
    trained: Path, tmp_path: Path, workers: int
) -> None:
    for frame_id in ("a1", "b2", "c3"):
        write_frame(tmp_path, frame_id, make_frame(labels=()))
    file = tmp_path / "training" / "velodyne" / "b2.bin"
    file.write_bytes(file.read_bytes()[:-1])
    arguments = ["predict", "--checkpoint", trained, "--data", tmp_path, "--out", tmp_path / "out"]
    with pytest.raises(
        CadetError, match=r"1 of 3 frames cannot be read \(b2: velodyne/b2\.bin: truncated: .*they are not in "
    ):
        CliRunner().invoke(avod, [*map(str, arguments), "--workers", str(workers)], catch_exceptions=False)
    assert sorted(path.name for path in (tmp_path / "out").glob("*.txt")) == ["a1.txt", "c3.txt"]


def test_evaluation_and_validation_leave_out_what_cannot_be_read(
    trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ids = ("a1", "b2", "c3")
    for number, frame_id in enumerate(ids):
        write_frame(tmp_path, frame_id, make_frame(seed=number))
    kitti.write_image_set(tmp_path, "val", kitti.ImageSet(ids))
    file = tmp_path / "training" / "image_2" / "b2.png"
    file.write_bytes(file.read_bytes()[:2000])
    whole = tmp_path / "whole"
    shutil.copytree(tmp_path / "training", whole / "training", ignore=shutil.ignore_patterns("b2.*"))
    common = ["--checkpoint", trained, "--workers", 0, "--json", "--split", "all"]
    with pytest.warns(CadetWarning, match="1 of 3 frames cannot be read .*b2: image_2/b2.png"):
        found = call("eval", "--data", tmp_path, *common)
    assert json.loads(found.stdout) == json.loads(call("eval", "--data", whole, *common).stdout)
    monkeypatch.setattr("cadet._util.notices._said", set())
    run = ["train", "--config", CONFIG, "--workers", 0, "--steps", 2, "--val-every", 1, "--split", "all"]
    with pytest.warns(CadetWarning, match="b2"):
        call(*run, "--data", tmp_path, "--out", tmp_path / "run")
    assert len((tmp_path / "run" / "val.csv").read_text().splitlines()) == 3
    file.unlink()
    (tmp_path / "training" / "image_2" / "c3.png").unlink()
    for arguments in (["eval", "--data", tmp_path, *common], [*run, "--data", tmp_path, "--out", tmp_path / "no"]):
        with pytest.raises(CadetError, match=r"2 of 3 frames cannot be read \(b2: .*more than half"):
            CliRunner().invoke(avod, [str(one) for one in arguments], catch_exceptions=False)


def odd_frame(kind: str) -> Frame:
    """Make a frame that lacks what a detector lives on."""
    frame = make_frame()
    points_velo = frame.points_velo.copy()
    if kind == "no points":
        return dataclasses.replace(frame, points_velo=points_velo[:0])
    if kind == "no points, no plane":
        return dataclasses.replace(frame, points_velo=points_velo[:0], plane=None)
    if kind == "no ground":
        return dataclasses.replace(frame, points_velo=points_velo[:20], plane=None)
    if kind == "another size":
        return dataclasses.replace(frame, image=np.ascontiguousarray(frame.image[:101, :333]))
    return dataclasses.replace(frame, labels=()) if kind == "no cars" else frame


@pytest.mark.parametrize("kind", ["no points", "no points, no plane", "no cars", "another size"])
def test_odd_frames_are_predicted_and_evaluated(trained: Path, tmp_path: Path, kind: str) -> None:
    write_frame(tmp_path, 0, odd_frame(kind))
    call("predict", "--checkpoint", trained, "--data", tmp_path, "--out", tmp_path / "found")
    found = labels_from_text((tmp_path / "found" / "000000.txt").read_text())
    assert not found or not kind.startswith("no points")
    result = call("eval", "--checkpoint", trained, "--data", tmp_path, "--split", "all")
    assert "KITTI AP|R40 in percent" in result.output


@pytest.mark.filterwarnings("ignore:frame .* is left out")
def test_frames_that_cannot_be_used_are_one_clear_error(trained: Path, tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame())
    (tmp_path / "training" / "velodyne" / "000000.bin").write_bytes(bytes(33))
    common = ["--data", str(tmp_path), "--split", "all", "--out", str(tmp_path / "out"), "--workers", "0"]
    for arguments in (["predict", "--checkpoint", str(trained)], ["train", "--config", str(CONFIG), "--steps", "1"]):
        with pytest.raises(CadetError, match=r"velodyne/000000\.bin: truncated"):
            CliRunner().invoke(avod, [*arguments, *common], catch_exceptions=False)


def test_frames_without_ground_are_trained_on_and_predicted_with_one_warning_each(
    trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_frame(tmp_path, 0, make_frame(plane=None))
    write_frame(tmp_path, 1, odd_frame("no ground"))
    common = ["--data", tmp_path, "--split", "all", "--workers", 0]
    for number, arguments in enumerate(
        (
            ["predict", "--checkpoint", trained, "--out", tmp_path / "found"],
            ["train", "--config", CONFIG, "--steps", 8, "--out", tmp_path / "run"],
            ["eval", "--checkpoint", trained],
        )
    ):
        shutil.rmtree(tmp_path / "training" / "planes", ignore_errors=True)
        monkeypatch.setattr("cadet._util.notices._said", set())
        with pytest.warns(CadetWarning) as caught:
            call(*arguments, *common)
        lines = [str(one.message) for one in caught]
        assert len(lines) == 1, (number, lines)
        assert lines[0].startswith("frame 000001: no ground is found in the scan (ground plane: expected at least ")
        assert "a file in planes/ gives another" in lines[0]
    assert (tmp_path / "found" / "000001.txt").is_file()


def test_without_labels_there_are_predictions_but_no_evaluation_and_no_training(trained: Path, tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame())
    shutil.rmtree(tmp_path / "training" / "label_2")
    call("predict", "--checkpoint", trained, "--data", tmp_path, "--out", tmp_path / "found")
    common = ["--data", str(tmp_path), "--split", "all"]
    for arguments in (
        ["eval", "--checkpoint", str(trained)],
        ["train", "--config", str(CONFIG), "--steps", "1", "--out", str(tmp_path / "out")],
    ):
        with pytest.raises(CadetError, match=r"label_2(/000000\.txt|, which is needed)"):
            CliRunner().invoke(avod, [*arguments, *common], catch_exceptions=False)


def test_test_frames_are_read_from_testing(tmp_path: Path) -> None:
    write_frame(tmp_path, 1, make_frame())
    shutil.copytree(tmp_path / "training", tmp_path / "testing")
    (tmp_path / "training" / "velodyne" / "000001.bin").write_bytes(b"no scan")
    (tmp_path / "ImageSets" / "test.txt").write_text("000001\n")
    arguments = ["predict", "--checkpoint", "tiny_car", "--data", str(tmp_path), "--split", "test"]
    result = CliRunner().invoke(avod, [*arguments, "--out", str(tmp_path / "found")], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    assert [path.name for path in (tmp_path / "found").glob("*.txt")] == ["000001.txt"]
