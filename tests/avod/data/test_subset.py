"""Trainings on a few frames of a folder: which ones are drawn, and that a training keeps to them."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from avod.cli.commands import avod
from avod.config import Config
from avod.data.dataset import TrainingData
from avod.data.sample import Sample
from avod.data.subset import draw_frames
from avod.train.settings import read_record
from cadet.errors import CadetError
from detector.runs import StopAfter, assert_same_training, short_run, small_config, write_set

IDS = tuple(f"{number:06d}" for number in range(100))


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Config:
    return small_config(tmp_path_factory.mktemp("config"))


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_set(tmp_path_factory.mktemp("data") / "set", num_train=6)


def test_fewer_frames_are_among_more_and_another_seed_has_others() -> None:
    drawn = {count: draw_frames(IDS, count, 3) for count in (1, 10, 40, 99, 100)}
    for count, frames in drawn.items():
        assert len(set(frames)) == count and list(frames) == sorted(frames)
    assert set(drawn[1]) < set(drawn[10]) < set(drawn[40]) < set(drawn[99]) < set(drawn[100])
    assert draw_frames(IDS, 10, 3) == drawn[10] != draw_frames(IDS, 10, 4)


def test_every_frame_is_as_likely() -> None:
    counts = Counter(frame_id for seed in range(400) for frame_id in draw_frames(IDS, 25, seed))
    # 100 of 400 each, with a deviation of 8.7.
    assert set(counts) == set(IDS) and min(counts.values()) > 60 and max(counts.values()) < 140


def test_a_training_reads_the_drawn_frames_alone(config: Config, data: Path) -> None:
    two, four = (TrainingData(data, "train", config, 5, frames=count) for count in (2, 4))
    assert set(two.ids) < set(four.ids) < set(TrainingData(data, "train", config, 5).ids)
    samples = [two[index] for index in range(8)]
    assert {sample.frame_id for sample in samples if isinstance(sample, Sample)} == set(two.ids)


def test_more_frames_than_there_are_are_refused(config: Config, data: Path) -> None:
    with pytest.raises(CadetError, match=r"--num-frames 7: \S+set: 6 frames of the split 'train' hold enough objects"):
        TrainingData(data, "train", config, 0, frames=7)


def test_of_several_folders_the_last_gives_the_drawn_frames(config: Config, data: Path) -> None:
    both = TrainingData(((data, 0.5), (data, 0.5)), "train", config, 5, frames=2)
    whole, two = TrainingData(data, "train", config, 5), TrainingData(data, "train", config, 5, frames=2)
    assert both.ids == (*(f"0/{name}" for name in whole.ids), *(f"1/{name}" for name in two.ids))


def test_a_class_that_no_label_has_is_refused_by_name(config: Config, data: Path) -> None:
    buses = replace(config, classes=(replace(config.classes[0], name="Bus"),))
    with pytest.raises(CadetError, match=r"none of the 6 frames .* holds a Bus to learn from; their labels have Car"):
        TrainingData(data, "train", buses, 0)


def test_a_training_on_few_frames_goes_on_with_the_same_ones(config: Config, data: Path, tmp_path: Path) -> None:
    short_run(config, data, tmp_path / "unbroken", 5, num_frames=2, seed=3)
    short_run(config, data, tmp_path / "parts", 5, num_frames=2, seed=3, should_stop=StopAfter(2))
    record = read_record(tmp_path / "parts")
    assert (record.num_frames, record.num_used) == (2, 2)
    with pytest.raises(CadetError, match="has frames to learn from = 2, and is to go on with 3"):
        short_run(config, data, tmp_path / "parts", 5, num_frames=3, resume=True)
    # The command knows how many from the training's own record.
    arguments = ["train", "--out", str(tmp_path / "parts"), "--resume", "--steps", "5", "--workers", "0"]
    assert CliRunner().invoke(avod, arguments, catch_exceptions=False).exit_code == 0
    assert_same_training(tmp_path / "parts", tmp_path / "unbroken")
