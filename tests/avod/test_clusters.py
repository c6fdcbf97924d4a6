"""Anchor sizes fitted to labels: the best there are, and a configuration that can be read."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from avod.cli.commands import avod
from avod.clusters import anchor_sizes, k_means, toml_of
from avod.config_file import load_config
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti import write_frame
from synthetic import make_calib, make_frame, make_label


def cost(points: np.ndarray, centers: np.ndarray) -> float:
    return float(((points[:, None] - centers) ** 2).sum(axis=2).min(axis=1).sum())


@pytest.mark.parametrize("count", [1, 2, 3])
def test_no_other_division_is_much_better(count: int) -> None:
    rng = np.random.default_rng(count)
    points = rng.uniform(0, 5, (8, 3))
    best = min(
        cost(points, np.stack([points[np.array(division) == k].mean(axis=0) for k in range(count)]))
        for division in itertools.product(range(count), repeat=8)
        if len(set(division)) == count
    )
    # Lloyd's iteration ends where no center moves, which need not be the very best.
    assert best * (1 - 1e-9) <= cost(points, k_means(points, count)) <= best * 1.02


def test_clusters_far_apart_are_found_whatever_their_sizes() -> None:
    rng = np.random.default_rng(0)
    truths = np.array([[0.8, 0.6, 1.8], [4.0, 1.6, 1.5], [10.0, 2.6, 3.4], [17.0, 2.6, 3.8]])
    points = np.concatenate([rng.normal(t, 0.05, (n, 3)) for t, n in zip(truths, (1000, 300, 20, 4), strict=True)])
    found = k_means(points, 4)
    np.testing.assert_allclose(found[np.argsort(found[:, 0])], truths, atol=0.1)
    np.testing.assert_array_equal(k_means(points, 4), found)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    calib = make_calib()
    for index in range(6):
        length = (3.5, 3.6, 4.4)[index % 3]
        boxes = [("Car", (-2.0, 1.65, 14.0, length, 1.6, 1.5, 1.5)), ("Cyclist", (2.0, 1.65, 9.0, 1.8, 0.6, 1.7, 0.0))]
        labels = tuple(make_label(kind, box, calib) for kind, box in boxes)
        write_frame(tmp_path / "set", index, make_frame(labels=labels), split="train" if index < 3 else "val")
    return tmp_path / "set"


def test_the_command_prints_a_configuration(data: Path, tmp_path: Path) -> None:
    arguments = ["clusters", str(data), "--class", "Car=2", "--class", "Cyclist=1"]
    result = CliRunner().invoke(avod, arguments, catch_exceptions=False)
    assert result.exit_code == 0
    file = tmp_path / "mine.toml"
    file.write_text('base = "car_default"\n' + result.output)
    car, cyclist = load_config(str(file)).classes
    assert (car.name, cyclist.name) == ("Car", "Cyclist")
    assert car.anchor_sizes_lwh_m == ((3.55, 1.6, 1.5), (4.4, 1.6, 1.5))
    assert cyclist.anchor_sizes_lwh_m == ((1.8, 0.6, 1.7),)
    assert toml_of(anchor_sizes(data, "train", {"Car": 2, "Cyclist": 1})) == result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--class", "Car"], "--class: expected a type of labels and a count, such as Car=2, got 'Car'"),
        (["--class", "1.5=1"], "got '1.5=1'"),
        (["--class", "Bus=1"], "expected labels of Bus in at least 1 sizes, got 0 among 0 labels of 3 frames"),
        (["--class", "Car=0"], "--class: expected 1 to 64 sizes, got 'Car=0'"),
        (["--class", "Car=4"], "expected labels of Car in at least 4 sizes, got 3 among 3 labels of 3 frames"),
        (["--class", "Van=1"], "expected labels of Van in at least 1 sizes, got 0 among 0 labels of 3 frames"),
    ],
)
def test_mistakes_are_named(data: Path, arguments: list[str], message: str) -> None:
    with pytest.raises(CadetError) as error:
        CliRunner().invoke(avod, ["clusters", str(data), *arguments], catch_exceptions=False)
    assert message in str(error.value)


def test_a_folder_without_the_usual_lists_says_where_they_belong(data: Path) -> None:
    for file in (data / "ImageSets").iterdir():
        file.unlink()
    with pytest.raises(MissingFileError) as error:
        CliRunner().invoke(avod, ["clusters", str(data)], catch_exceptions=False)
    assert str(error.value).startswith(
        f"{data}/ImageSets/train.txt: no such split: --split all takes every frame; KITTI's"
    )
    assert "3,712" in str(error.value) and str(error.value).endswith(f"put them into {data}/ImageSets")
