"""Several sets in fixed shares: how often each comes, that each is seen whole, and exact resuming."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from avod.cli.commands import avod
from avod.cli.options import parse_data
from avod.config import TrainingConfig
from avod.data.dataset import TrainingData
from avod.data.mixture import Mixture, set_seed, shares_of
from avod.data.order import Order
from avod.data.sample import Sample
from avod.train.settings import read_record
from cadet.datasets.object_bank import cut_objects, write_bank
from cadet.errors import CadetError, CadetWarning
from detector.runs import StopAfter, assert_same_training, short_run, small_config, write_set
from synthetic import make_frame

PLAIN = TrainingConfig(flip=False, pca_jitter=False)


def mixture(sizes: tuple[int, ...], shares: tuple[float, ...], seed: int = 0) -> Mixture:
    orders = [Order(size, PLAIN, set_seed(seed, k, len(sizes))) for k, size in enumerate(sizes)]
    return Mixture(orders, shares, seed)


def test_each_set_comes_as_often_as_its_share_says() -> None:
    mixed = mixture((7, 5, 3), (0.7, 0.2015, 0.0985))
    for block in range(3):
        counts = Counter(mixed.entry(1000 * block + place)[0] for place in range(1000))
        assert counts[0] == 700 and counts[1] in (201, 202) and sum(counts.values()) == 1000
    # Well mixed, not one after the other.
    numbers = [mixed.entry(index)[0] for index in range(1000)]
    assert all(2 < numbers[first : first + 50].count(1) < 20 for first in range(0, 1000, 50))


def test_every_set_is_seen_whole_before_any_frame_comes_again() -> None:
    mixed = mixture((70, 9), (0.8, 0.2))
    seen: dict[int, list[int]] = {0: [], 1: []}
    for index in range(3000):
        number, entry = mixed.entry(index)
        seen[number].append(entry.frame)
    for number, size in ((0, 70), (1, 9)):
        frames = seen[number]
        epochs = [frames[first : first + size] for first in range(0, len(frames) - size, size)]
        assert len(epochs) > 30 and all(sorted(epoch) == list(range(size)) for epoch in epochs)


def test_the_order_follows_from_the_seed_and_the_place_alone() -> None:
    first, again, other = (mixture((70, 9), (0.5, 0.5), seed) for seed in (1, 1, 2))
    places = [2999, 0, 17, 1500]
    assert [first.entry(p) for p in places] == [again.entry(p) for p in reversed(places)][::-1]
    assert [first.entry(p) for p in range(50)] != [other.entry(p) for p in range(50)]
    seeds = {first.entry(p)[1].augmentation.seed for p in range(2000)}
    assert len(seeds) == 2000, "no two samples draw the same"


def test_one_folder_is_ordered_as_it_always_was() -> None:
    order = Order(11, TrainingConfig(), 5)
    alone = Mixture([Order(11, TrainingConfig(), set_seed(5, 0, 1))], (1.0,), 5)
    assert [alone.entry(i) for i in range(90)] == [(0, order.entry(i)) for i in range(90)]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ((), "data: expected at least one folder, got none"),
        ((("a", 1.0), ("b", 0.0005)), "b: its share 0.0005 of 1.0005 is less than one in 1000"),
        ((("a", 0.0),), "a: its share 0 of 0 is less than one in 1000"),
        ((("a", -1.0),), "data: share: expected a number from 0 to 1e+06, got -1.0"),
        (("a", "b"), "data: expected pairs (folder, share), got 'a'"),
    ],
)
def test_shares_that_are_none_are_refused(data: Any, message: str) -> None:
    with pytest.raises(CadetError) as error:
        shares_of(data)
    assert str(error.value) == message


def test_shares_are_read_from_the_command_line(tmp_path: Path) -> None:
    odd = tmp_path / "a:0.5"
    odd.mkdir()
    assert parse_data(["set"]) == ((Path("set"), 1.0),)
    assert parse_data(["set:0.8", "kitti:0.2"]) == ((Path("set"), 0.8), (Path("kitti"), 0.2))
    assert parse_data([str(odd)]) == ((odd, 1.0),), "a folder of that name is there"
    with pytest.raises(CadetError, match="--data kitti: several folders need a share each"):
        parse_data(["set:0.8", "kitti"])


def test_frames_of_several_folders_are_told_apart(tmp_path: Path) -> None:
    config = small_config(tmp_path)
    one, two = write_set(tmp_path / "one", 2), write_set(tmp_path / "two", 1)
    data = TrainingData(((one, 0.5), (two, 0.5)), "train", config, 0)
    assert data.ids == ("0/000000", "0/000001", "1/000000")
    (two / "training" / "velodyne" / "000000.bin").write_bytes(bytes(5))
    with pytest.warns(CadetWarning, match=rf"^frame {two}/000000 is left out, .*velodyne/000000\.bin: truncated"):
        errors = {str(item) for index in range(40) if isinstance(item := data[index], CadetError)}
    assert any("velodyne/000000.bin: truncated" in error for error in errors)
    names = {item.frame_id for index in range(40) if isinstance(item := data[index], Sample)}
    assert names == {f"{one}/000000", f"{one}/000001"}


def test_a_mixed_training_goes_on_as_if_it_had_not_stopped(tmp_path: Path) -> None:
    config = small_config(tmp_path)
    sets = (write_set(tmp_path / "one"), 3.0), (write_set(tmp_path / "two", 2), 1.0)
    short_run(config, sets, tmp_path / "unbroken", 7)
    out = tmp_path / "run"
    short_run(config, sets, out, 7, should_stop=StopAfter(4))
    found = json.loads((out / "run.json").read_text())
    assert found["data"] == [str(folder) for folder, _ in sets] and found["shares"] == [0.75, 0.25]
    assert found["num_frames"] == 5
    command = ["train", "--out", str(out), "--resume", "--threads", "1", "--workers", "0"]
    done = CliRunner().invoke(avod, command, catch_exceptions=False, standalone_mode=False)
    assert done.return_value == 0, done.output
    assert_same_training(out, tmp_path / "unbroken")
    assert read_record(out).folders == ((sets[0][0], 0.75), (sets[1][0], 0.25))


def test_other_shares_are_another_training(tmp_path: Path) -> None:
    config = small_config(tmp_path)
    one, two = write_set(tmp_path / "one"), write_set(tmp_path / "two", 2)
    out = tmp_path / "run"
    short_run(config, ((one, 0.75), (two, 0.25)), out, 1)
    with pytest.raises(
        CadetError, match=r"its training has shares = \(0.75, 0.25\), and is to go on with \(0.5, 0.5\)"
    ):
        short_run(config, ((one, 0.5), (two, 0.5)), out, 2, resume=True)
    record = out / "run.json"
    record.write_text(record.read_text().replace("0.75,", ""))
    with pytest.raises(CadetError, match="shares: expected one for each of 2 folders"):
        read_record(out)


def test_sizes_and_bank_are_recorded(tmp_path: Path) -> None:
    config = small_config(tmp_path)
    data = write_set(tmp_path / "set")
    write_bank(tmp_path / "bank", cut_objects(make_frame(), ("Car",), "set"))
    file = tmp_path / "pasting.toml"
    file.write_text(f'base = "{tmp_path / "small.toml"}"\n[augmentation]\npasted_objects = 2\n')
    out = tmp_path / "run"
    command = ["train", "--config", str(file), "--data", str(data), "--out", str(out), "--steps", "1"]
    command += ["--bank", str(tmp_path / "bank"), "--sizes-from", str(data), "--threads", "1", "--workers", "0"]
    CliRunner().invoke(avod, command, catch_exceptions=False, standalone_mode=False)
    record = read_record(out)
    # Of the two cars and the pedestrian that are in every frame.
    assert record.config.augmentation.object_sizes_lwh_m == ((4.0, 1.65, 1.45), (0.8, 0.6, 1.8))
    assert record.config.augmentation.pasted_objects == 2
    assert record.config.class_names == config.class_names
    assert record.bank == str(tmp_path / "bank") and isinstance(record.bank_crc32, int)
