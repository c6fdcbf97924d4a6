"""Self-training: what is learned from detections, and rounds that go on after a stop."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from avod.adapt import UNSURE, Adaptation, adapt, pseudo_labels
from avod.cli.commands import avod
from avod.config import Config
from avod.train import Run, train, with_steps
from avod.train.checkpoint import read_checkpoint
from cadet import kitti
from cadet.errors import CadetError
from cadet.formats.kitti_sequences import RawDrive
from detector.runs import StopAfter, assert_same_training, write_set
from raw_drives import write_raw_drive
from synthetic import make_calib, make_labels

CONFIG_FILE = Path(__file__).parents[1] / "support" / "detector" / "center.toml"
ANY = Adaptation(rounds=2, steps=3, sure=0.0, unsure=0.0)


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_set(tmp_path_factory.mktemp("source"))


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Frames as real ones come: without labels and lists."""
    root = write_set(tmp_path_factory.mktemp("target"))
    shutil.rmtree(root / "training" / "label_2")
    shutil.rmtree(root / "ImageSets")
    return root


@pytest.fixture(scope="module")
def checkpoint(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("first")
    return train(with_steps(Config.named(CONFIG_FILE), 2), Run(data=source, out=out))


def test_labels_are_sure_or_left_open_or_background() -> None:
    car = make_labels(make_calib())[0]
    found = [dataclasses.replace(car, score=score) for score in (0.9, 0.5, 0.49, 0.25, 0.24)]
    labels = pseudo_labels(found, Adaptation(sure=0.5, unsure=0.25))
    assert [label.type for label in labels] == [car.type, car.type, UNSURE, UNSURE]
    assert all(label.score is None and label.box_cam.tolist() == car.box_cam.tolist() for label in labels)


def test_rounds_learn_from_what_was_found_and_go_on_after_a_stop(
    source: Path, target: Path, checkpoint: Path, tmp_path: Path
) -> None:
    frames, seen = kitti.Dataset(target), []
    rate = read_checkpoint(checkpoint).config.training.learning_rate
    whole = Run(data=source, out=tmp_path / "whole")
    last = adapt(checkpoint, frames, whole, ANY, on_step=lambda number, done, losses: seen.append((number, done)))
    assert last == tmp_path / "whole" / "round_2" / "checkpoints" / "000000003"
    assert seen == [(number, done) for number in (1, 2) for done in (1, 2, 3)]
    found = kitti.Dataset(tmp_path / "whole" / "round_1" / "found", "train")
    assert found.ids == frames.ids
    assert found[0].points_velo.tobytes() == frames.read_frame(frames.ids[0]).points_velo.tobytes()
    assert {label.type for frame_id in found.ids for label in found.read_labels(frame_id)} <= {"Car", "Pedestrian"}
    settings = read_checkpoint(last).config
    first = read_checkpoint(tmp_path / "whole" / "round_1").config
    assert settings.training.learning_rate == first.training.learning_rate == pytest.approx(rate / 3.0)
    assert settings.ignored_types[-1] == UNSURE and settings.training.steps == ANY.steps

    parts = Run(data=source, out=tmp_path / "parts")
    assert adapt(checkpoint, frames, parts, ANY, should_stop=StopAfter(2)) is None
    with pytest.raises(CadetError, match="an adaptation was begun there: name a new folder, or go on with --resume"):
        adapt(checkpoint, frames, parts, ANY)
    goes_on = dataclasses.replace(parts, resume=True)
    with pytest.raises(CadetError, match="change nothing but --rounds"):
        adapt(checkpoint, frames, goes_on, dataclasses.replace(ANY, sure=0.5))
    with pytest.raises(CadetError, match=r"'seed': None.* and is to go on with .*'seed': 3"):
        adapt(checkpoint, frames, dataclasses.replace(goes_on, seed=3), ANY)
    assert adapt(checkpoint, frames, goes_on, ANY, should_stop=StopAfter(2)) is None
    assert adapt(checkpoint, frames, goes_on, ANY) is not None
    for number in (1, 2):
        assert_same_training(*(tmp_path / name / f"round_{number}" for name in ("parts", "whole")))


def test_the_command_says_where_the_weights_are_and_what_is_wrong(
    source: Path, target: Path, checkpoint: Path, tmp_path: Path
) -> None:
    def call(*arguments: object) -> Result:
        common = ("--checkpoint", checkpoint, "--source", source, "--out", tmp_path / "out", "--workers", 0)
        return CliRunner().invoke(avod, ["adapt", *map(str, (*common, *arguments))])

    done = call("--data", target, "--rounds", 1, "--steps", 1, "--sure", 0, "--unsure", 0)
    assert done.exit_code == 0 and f"last checkpoint: {tmp_path / 'out' / 'round_1'}" in done.output
    assert isinstance(call("--data", target, "--unsure", 0.6).exception, CadetError)
    other = tmp_path / "other"
    nothing = CliRunner().invoke(
        avod, ["adapt", "--checkpoint", str(checkpoint), "--data", str(target), "--source", str(source)]
        + ["--out", str(other), "--sure", "1", "--workers", "0"]
    )  # fmt: skip
    assert "found: none of the 5 frames of the split 'train' holds a Car or Pedestrian to learn from" in str(
        nothing.exception
    )


def test_a_raw_drive_is_learned_from_too(source: Path, target: Path, checkpoint: Path, tmp_path: Path) -> None:
    frames = kitti.Dataset(target)
    drive = RawDrive(write_raw_drive(tmp_path, [frames.read_frame(frame_id) for frame_id in frames.ids]))
    run, once = Run(data=source, out=tmp_path / "out"), dataclasses.replace(ANY, rounds=1)
    assert adapt(checkpoint, drive, run, once) == tmp_path / "out" / "round_1" / "checkpoints" / "000000003"
    found = kitti.Dataset(tmp_path / "out" / "round_1" / "found", "train")
    assert found.ids == drive.ids
    for frame_id, other_id in zip(found.ids, frames.ids, strict=True):
        frame, other = found.read_frame(frame_id), frames.read_frame(other_id)
        assert frame.labels
        assert frame.image.tobytes() == other.image.tobytes()
        assert frame.points_velo.tobytes() == other.points_velo.tobytes()
        np.testing.assert_allclose(frame.calib.P2, other.calib.P2, rtol=1e-6)
        np.testing.assert_allclose(frame.calib.cam_from_velo, other.calib.cam_from_velo, atol=1e-6)
