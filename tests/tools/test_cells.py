"""The cells of the experiments: which there are, in which order, and how long they train."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from avod.config import Config
from avod.train.checkpoint import read_checkpoint
from cadet.errors import CadetError, MissingFileError
from tools.experiments.plans import few_frame_cells, matrix_cells
from tools.experiments.scales import CLASSES, MAPS, SCALES


def test_the_matrix_has_every_way_of_training_for_each_class_maps_and_seed() -> None:
    cells = matrix_cells(SCALES["full"], tuple(CLASSES), MAPS, 2)
    assert len({cell.name for cell in cells}) == len(cells) == 2 * 3 * 3 * 2
    assert [cell.name for cell in cells[:4]] == [
        "car-default-sim-seed0",
        "car-default-real-seed0",
        "car-default-tuned-seed0",
        "car-max3_density3-sim-seed0",
    ]
    names = [cell.name for cell in cells]
    for cell in cells:
        # Sources come first, and are of the same seed, class and maps.
        source = f"{cell.name.split('-tuned')[0]}-sim-seed{cell.seed}" if cell.trained == "tuned" else None
        assert cell.source == source and (source is None or names.index(source) < names.index(cell.name))
        assert cell.tests == {"sim": ("sim", "real"), "real": ("real",), "tuned": ("real", "sim")}[cell.trained]
        short = {"Car": "car", "Pedestrian": "ped"}[cell.class_name]
        expected = Config.named(f"{short}_{cell.maps}")
        assert dataclasses.replace(cell.config, training=expected.training) == expected


def test_the_full_scale_is_the_papers() -> None:
    sim, real, tuned = matrix_cells(SCALES["full"], ("Car",), ("default",), 1)
    assert (sim.stops, real.stops, tuned.stops) == ((90_000, 120_000), (120_000,), (150_000,))
    assert (tuned.branch_step, tuned.num_steps, tuned.first_step) == (90_000, 60_000, 90_000)
    assert sim.config == real.config == Config.named("car_default")
    # A tuning of its own begins with the rate that the schedule has come to.
    training = sim.config.training
    rate = training.learning_rate * training.decay_factor ** (90_000 // training.decay_steps)
    assert SCALES["full"].tuning.learning_rate == pytest.approx(rate)
    assert [cell.last for cell in (sim, real, tuned)] == [20] * 3


def test_the_tiny_scale_tunes_as_its_configuration_does() -> None:
    sim, _, tuned = matrix_cells(SCALES["tiny"], ("Car",), ("default",), 1)
    assert sim.config == Config.named("tiny_car") and sim.stops == (3_000,)
    assert tuned.config == Config.named("tiny_car_tune")
    assert (tuned.stops, tuned.branch_step, tuned.last) == ((350,), None, 1)


@pytest.mark.parametrize(
    ("name", "steps", "stops"),
    [
        ("full", 1_200, ((900, 1_200), (1_200,), (1_500,))),
        ("full", 3, ((2, 3), (3,), (4,))),
        ("full", 1, ((1,), (1,), (2,))),
        ("tiny", 300, ((300,), (300,), (35,))),
        ("tiny", 1, ((1,), (1,), (1,))),
    ],
)
def test_fewer_steps_shorten_all_in_proportion(name: str, steps: int, stops: tuple[tuple[int, ...], ...]) -> None:
    cells = matrix_cells(SCALES[name], ("Car",), ("default",), 1, steps)
    assert tuple(cell.stops for cell in cells) == stops
    whole = SCALES[name].config("Car", "default")
    for cell in cells[:2]:
        assert cell.config.training.decay_steps == max(
            1, round(whole.training.decay_steps * steps / whole.training.steps)
        )
        share = steps / whole.training.steps
        assert cell.config.second_stage.truth_steps == round(whole.second_stage.truth_steps * share)


@pytest.mark.parametrize("name", ["tiny", "full", "center"])
def test_all_that_is_compared_has_as_many_steps(name: str) -> None:
    scale = SCALES[name]
    cells = few_frame_cells(scale, ("Car",), ("default",), 2, (10, 40))
    assert [cell.name for cell in cells[:8]] == [
        "car-default-sim-seed0",
        "car-default-longer-seed0",
        "car-default-real-10frames-seed0",
        "car-default-tuned-10frames-seed0",
        "car-default-mixed-10frames-seed0",
        "car-default-real-40frames-seed0",
        "car-default-tuned-40frames-seed0",
        "car-default-mixed-40frames-seed0",
    ]
    assert len(cells) == 16
    (pretrained, longer, *rest) = cells[:8]
    whole = scale.config("Car", "default")
    assert pretrained == matrix_cells(scale, ("Car",), ("default",), 1)[0]
    assert (longer.data, longer.frames) == (("sim",), None)
    for scratch, tuned, mixed in zip(rest[::3], rest[1::3], rest[2::3], strict=True):
        assert (scratch.data, tuned.data, mixed.data) == (("real",), ("real",), ("sim", "real"))
        for after in (longer, tuned, mixed):
            assert scratch.num_steps == pretrained.num_steps + after.num_steps
            assert (after.stops, after.last, after.source) == ((scale.few_steps,), 1, pretrained.name)
            assert after.config == tuned.config
        assert (scratch.seed, scratch.frames, scratch.last, scratch.source) == (tuned.seed, tuned.frames, 1, None)
        assert mixed.frames == tuned.frames
        # As often as in the scale's tuning, the rate falls.
        falls = scale.tuning.steps / scale.tuning.decay_steps
        assert tuned.config.training.steps / tuned.config.training.decay_steps == pytest.approx(falls, rel=0.01)
        assert tuned.config.training.learning_rate == scale.tuning.learning_rate < whole.training.learning_rate


def test_given_weights_take_the_place_of_the_pretraining() -> None:
    cells = few_frame_cells(SCALES["tiny"], ("Car",), ("default",), 2, (10,), inits=(Path("tiny_car"),), mixes=False)
    assert [cell.name for cell in cells] == [
        "car-default-given-seed0",
        "car-default-real-10frames-seed0",
        "car-default-tuned-10frames-seed0",
        "car-default-real-10frames-seed1",
        "car-default-tuned-10frames-seed1",
    ]
    given, scratch, tuned = cells[:3]
    assert given.stops == () and given.num_steps == 0 and given.tests == ("real",)
    assert tuned.init == given.init == read_checkpoint("tiny_car").path and scratch.init is None
    with pytest.raises(CadetError, match="--init: expected one checkpoint, or one for each of 3 seeds, got 2"):
        few_frame_cells(SCALES["tiny"], ("Car",), ("default",), 3, (10,), inits=(Path("tiny_car"),) * 2)
    with pytest.raises(CadetError, match="--init: these weights are of one class"):
        few_frame_cells(SCALES["tiny"], tuple(CLASSES), ("default",), 1, (10,), inits=(Path("tiny_car"),))
    with pytest.raises(CadetError, match=r"--init \S+tiny_car: its configuration has another 'classes'"):
        few_frame_cells(SCALES["tiny"], ("Pedestrian",), ("default",), 1, (10,), inits=(Path("tiny_car"),))
    with pytest.raises(MissingFileError, match="nothing: not a checkpoint"):
        few_frame_cells(SCALES["tiny"], ("Car",), ("default",), 1, (10,), inits=(Path("nothing"),))
