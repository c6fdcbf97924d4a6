"""Training on shards: the very numbers of training on the folder, each frame once whatever workers and processes."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from click.testing import CliRunner

from avod.cli.commands import avod
from avod.config import Config
from avod.data.dataset import TrainingData
from avod.data.loading import batches, whole
from avod.device import Processes
from avod.train.log import Validated
from avod.validate import Validator
from cadet.errors import CadetError
from cadet.formats.convert import convert
from detector.runs import StopAfter, assert_same_training, short_run, write_set

STEPS = 5
NUM_TRAIN, NUM_VAL, NUM_CHANGES = 5, 2, 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a set in KITTI's format, `set`, and in shards of two frames, `shards`."""
    folder = tmp_path_factory.mktemp("shards")
    convert(write_set(folder / "set", NUM_TRAIN, NUM_VAL), folder / "shards", "webdataset", shard_size=2)
    return folder


def named(folder: Path) -> Path:
    return folder / "shards" / "train" / "{000000..000002}.tar"


@pytest.mark.parametrize("workers", [0, 2])
def test_a_training_on_shards_that_stops_and_goes_on_is_the_one_on_the_folder(
    folder: Path, config: Config, tmp_path: Path, workers: int
) -> None:
    short_run(config, folder / "set", tmp_path / "on_folder", STEPS)
    short_run(config, named(folder), tmp_path / "run", STEPS, workers=workers, should_stop=StopAfter(2))
    short_run(config, named(folder), tmp_path / "run", STEPS, workers=workers, resume=True)
    assert_same_training(tmp_path / "run", tmp_path / "on_folder")


@pytest.mark.parametrize(("world_size", "workers"), [(1, 2), (2, 0), (3, 2)])
def test_an_epoch_holds_each_frame_once_over_workers_and_processes(
    folder: Path, config: Config, world_size: int, workers: int
) -> None:
    num_steps = 2 * NUM_TRAIN * NUM_CHANGES // world_size
    training = replace(config.training, steps=num_steps)
    read: dict[str, list[str]] = {"shards": [], "set": []}
    for name, ids in read.items():
        by_rank = []
        for rank in range(world_size):
            data = TrainingData(named(folder) if name == "shards" else folder / "set", "train", config, 7)
            processes = Processes(rank, world_size, torch.device("cpu"))
            with batches(data, training, 0, processes, workers) as steps:
                found = [whole(samples, processes.device)[0] for samples in steps]
            by_rank.append([sample.frame_id for sample in found])
        ids += [by_rank[rank][step] for step in range(num_steps) for rank in range(world_size)]
    assert read["shards"] == read["set"]
    in_epoch = Counter(read["shards"][: NUM_TRAIN * NUM_CHANGES])
    assert in_epoch == {f"{number:06d}": NUM_CHANGES for number in range(NUM_TRAIN)}


def test_validation_takes_the_other_split_of_the_shards_folder(folder: Path, config: Config, tmp_path: Path) -> None:
    found: list[Validated] = []
    for name in ("set", "shards"):
        validator = Validator(folder / name, "val", config)
        assert validator.ids == ("000005", "000006")

        def validate(*arguments: object, validator: Validator = validator) -> Validated | None:
            result = validator(*arguments)  # type: ignore[arg-type]
            if result is not None:
                found.append(result)
            return result

        short_run(config, folder / name, tmp_path / name, 2, val_every=2, validate=validate)
    assert len(found) == 2
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (("--split", "val"), "--split: shards that --data names are all read"),
        (("--val-every", 2), "--val-every: shards that --data names, and simulations, have no --val-split"),
    ],
)
def test_shards_that_are_named_have_no_splits(folder: Path, config: Config, option: tuple[str], said: str) -> None:
    arguments = ["train", "--config", folder / "small.toml", "--data", named(folder), "--out", folder / "out", *option]
    done = CliRunner().invoke(avod, [str(argument) for argument in arguments])
    assert isinstance(done.exception, CadetError)
    assert said in str(done.exception)
    assert not (folder / "out").exists()


def test_a_damaged_shard_is_named(folder: Path, config: Config, tmp_path: Path) -> None:
    convert(folder / "set", tmp_path / "shards", "webdataset", shard_size=2)
    path = tmp_path / "shards" / "train" / "000001.tar"
    path.write_bytes(path.read_bytes()[:5000])
    path.with_suffix(".idx").unlink()
    with pytest.raises(CadetError, match=r"000001\.tar: "):
        TrainingData(tmp_path / "shards", "train", config, 0)
