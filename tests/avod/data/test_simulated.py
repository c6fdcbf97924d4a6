"""Training straight from the simulator: one order of frames, whatever workers, processes, and where it goes on."""

from __future__ import annotations

import dataclasses
import itertools
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import torch
from click.testing import CliRunner

from avod.cli.commands import avod
from avod.config import Config
from avod.data import simulated
from avod.data.dataset import TrainingData, sample_from_frame
from avod.data.frames import SimulatedFrames, open_frames
from avod.data.mixed import MixedData
from avod.data.mixture import shares_of
from avod.data.prefetch import prefetched
from avod.data.sample import Sample
from avod.data.simulated import SimulatedData
from cadet.errors import CadetError
from cadet.formats.kitti import text_from_labels
from cadet.simulation.simulation import Simulation
from detector.runs import StopAfter, assert_same_training, short_run, write_set

BLOCK = 6
STEPS = 8
TEXT = 'seed = 3\nlidar = "vlp16"\nimage_size = [310, 94]\nsamples_per_episode = 2\n'


@pytest.fixture(autouse=True)
def _small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulated, "BLOCK", BLOCK)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("simulated")
    (folder / "town.toml").write_text(TEXT)
    return folder


@pytest.fixture(scope="module")
def name(folder: Path) -> str:
    return f"sim:{folder}/town.toml"


def taken(
    name: str, config: Config, count: int, *, first: int = 0, workers: int = 0, rank: int = 0, world_size: int = 1
) -> list[Sample]:
    with SimulatedData(name, config, 7).samples(first, rank, world_size, workers) as samples:
        return list(itertools.islice(samples, count))


def described(samples: list[Sample]) -> list[tuple[str, bytes, bytes]]:
    return [(s.frame_id, s.image.numpy().tobytes(), s.bev.numpy().tobytes()) for s in samples]


@pytest.fixture(scope="module")
def expected(name: str, config: Config) -> list[tuple[str, bytes, bytes]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulated, "BLOCK", BLOCK)
        return described(taken(name, config, 2 * BLOCK))


@pytest.mark.parametrize(("workers", "first"), [(2, 4), (0, 7)])
def test_the_order_is_the_same_for_any_workers_and_beginning(
    name: str, config: Config, expected: list[tuple[str, bytes, bytes]], workers: int, first: int
) -> None:
    found = taken(name, config, 2 * BLOCK - first, first=first, workers=workers)
    assert described(found) == expected[first:]


def test_samples_are_the_streams_frames_that_hold_objects(name: str, config: Config) -> None:
    plain = dataclasses.replace(config, training=dataclasses.replace(config.training, flip=False, pca_jitter=False))
    samples = {sample.frame_id: sample for sample in taken(name, plain, BLOCK)}
    with Simulation.read(name.removeprefix("sim:")).stream(workers=0) as frames:
        held = {
            f"{number:06d}": frame
            for number, frame in enumerate(itertools.islice(frames, BLOCK))
            if any(label.type in config.class_names for label in frame.labels)
        }
    assert samples.keys() == held.keys()
    for frame_id, sample in samples.items():
        again = sample_from_frame(held[frame_id], frame_id, plain)
        assert torch.equal(sample.bev, again.bev) and torch.equal(sample.image, again.image)


def test_processes_share_the_episodes_without_overlap(name: str, config: Config) -> None:
    by_rank = [taken(name, config, BLOCK, rank=rank, world_size=2) for rank in range(2)]
    for rank, samples in enumerate(by_rank):
        assert {int(sample.frame_id) // 2 % 2 for sample in samples} == {rank}


def test_a_training_that_stops_and_goes_on_equals_one_that_never_stopped(
    name: str, config: Config, tmp_path: Path
) -> None:
    short_run(config, name, tmp_path / "unbroken", STEPS)
    short_run(config, name, tmp_path / "run", STEPS, workers=1, should_stop=StopAfter(4))
    short_run(config, name, tmp_path / "run", STEPS, workers=1, resume=True)
    assert_same_training(tmp_path / "run", tmp_path / "unbroken")


def test_a_frame_is_the_streams_in_any_order_of_reading(folder: Path, name: str) -> None:
    with Simulation.read(folder / "town.toml").stream(workers=0) as stream:
        expected = list(itertools.islice(stream, 2))
    frames = open_frames(name)
    assert isinstance(frames, SimulatedFrames) and frames.first(2) == ("000000", "000001")
    for number in (1, 0):
        found, frame = frames.read_frame(f"{number:06d}"), expected[number]
        assert (found.points_velo == frame.points_velo).all() and (found.image == frame.image).all()
        assert text_from_labels(frames.read_labels(f"{number:06d}")) == text_from_labels(frame.labels)
    with pytest.raises(CadetError, match=r"town\.toml: frame 'last': expected its place in the simulation"):
        frames.read_frame("last")


def test_another_simulation_is_another_training(config: Config, tmp_path: Path) -> None:
    (tmp_path / "town.toml").write_text(TEXT)
    name = f"sim:{tmp_path}/town.toml"
    short_run(config, name, tmp_path / "run", 1)
    (tmp_path / "town.toml").write_text(TEXT.replace("seed = 3", "seed = 4"))
    with pytest.raises(CadetError, match="it would be another training"):
        short_run(config, name, tmp_path / "run", 2, resume=True)


def test_a_block_without_objects_is_an_error(name: str, config: Config) -> None:
    picky = dataclasses.replace(config, training=dataclasses.replace(config.training, min_objects=999))
    with pytest.raises(CadetError, match=r"town\.toml: none of the frames 000000 to 000005 holds 999 of Car"):
        taken(name, picky, 1, workers=1)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_set(tmp_path_factory.mktemp("recorded"), num_train=5)


def test_recorded_frames_and_the_live_simulator_come_in_their_shares(
    name: str, config: Config, recorded: Path, expected: list[tuple[str, bytes, bytes]]
) -> None:
    folders = shares_of(((recorded, 3), (name, 1)))
    folder = TrainingData(recorded, "train", config, 7)

    def mixed(first: int, count: int, workers: int = 0) -> list[Sample]:
        with MixedData(folders, "train", config, 7).samples(first, 0, 1, workers) as samples:
            found = list(itertools.islice(samples, count))
        assert all(isinstance(sample, Sample) for sample in found)
        return found  # type: ignore[return-value]

    whole = mixed(0, 32)
    is_live = [sample.image_size == (310, 94) for sample in whole]
    assert 3 <= sum(is_live) <= 13 and sum(is_live) <= len(expected)
    # Each is what it is without the other.
    assert described([s for s, live in zip(whole, is_live, strict=True) if live]) == expected[: sum(is_live)]
    others = [s for s, live in zip(whole, is_live, strict=True) if not live]
    assert described(others) == described([folder[k] for k in range(len(others))])  # type: ignore[misc]
    for first, workers in ((9, 0), (20, 1)):
        assert described(mixed(first, 4, workers)) == described(whole[first : first + 4])


def test_a_mixed_training_that_stops_and_goes_on_equals_one_that_never_stopped(
    name: str, config: Config, recorded: Path, tmp_path: Path
) -> None:
    data = ((name, 0.5), (recorded, 0.5))
    short_run(config, data, tmp_path / "unbroken", 3)
    short_run(config, data, tmp_path / "run", 3, should_stop=StopAfter(2))
    short_run(config, data, tmp_path / "run", 3, resume=True)
    assert_same_training(tmp_path / "run", tmp_path / "unbroken")
    with pytest.raises(CadetError, match=r"town\.toml: a training has one simulation"):
        short_run(config, (*data, (name, 0.5)), tmp_path / "other", 1)


def test_sizes_of_objects_that_nobody_knows_are_not_changed(name: str, config: Config) -> None:
    sizes = dataclasses.replace(config.augmentation, object_sizes_lwh_m=((3.9, 1.6, 1.5), (0.8, 0.6, 1.7)))
    with pytest.raises(CadetError, match="object_sizes_lwh_m needs the mean sizes of a folder's labels"):
        SimulatedData(name, dataclasses.replace(config, augmentation=sizes), 7)


def test_samples_are_changed_as_the_configuration_says(name: str, config: Config) -> None:
    moved = dataclasses.replace(config.augmentation, translation_m=(5.0, 0.0, 5.0))
    changed, plain = (taken(name, c, 1)[0] for c in (dataclasses.replace(config, augmentation=moved), config))
    assert changed.frame_id == plain.frame_id
    assert not torch.equal(changed.bev, plain.bev)


def test_the_command_knows_its_simulation_when_it_goes_on(folder: Path, config: Config, tmp_path: Path) -> None:
    def call(*arguments: object) -> None:
        done = CliRunner().invoke(avod, [*map(str, arguments)], catch_exceptions=False)
        assert done.exit_code == 0, done.output

    options = ("--out", tmp_path / "run", "--workers", 0)
    call("train", "--config", folder / "small.toml", "--data", f"sim:{folder}/town.toml", "--steps", 1, *options)
    call("train", "--resume", "--steps", 2, *options)
    assert (tmp_path / "run" / "checkpoints" / "000000002").is_dir()
    with pytest.raises(
        CadetError, match="--split: shards that --data names are all read, and a simulation has no splits"
    ):
        call("train", "--resume", "--split", "val", "--steps", 3, *options)


def test_items_are_taken_ahead_and_no_further() -> None:
    seen: list[int] = []

    def count() -> Iterator[int]:
        for number in itertools.count():
            seen.append(number)
            yield number

    with prefetched(count(), 3, threading.Event()) as ahead:
        assert [next(ahead) for _ in range(2)] == [0, 1]
        time.sleep(0.3)
        assert len(seen) == 2 + 3 + 1
    time.sleep(0.3)
    assert len(seen) <= 2 + 3 + 2


def test_an_error_comes_out_in_its_turn() -> None:
    def fail() -> Iterator[int]:
        yield 1
        raise CadetError("later")

    with prefetched(fail(), 3, threading.Event()) as ahead:
        assert next(ahead) == 1
        with pytest.raises(CadetError, match="later"):
            next(ahead)
