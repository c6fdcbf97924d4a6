"""The cells of the experiments: the paper's matrix, and what pre-training is worth by the number of real frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Final

from avod.train import with_steps
from avod.train.checkpoint import Checkpoint, read_checkpoint
from cadet.errors import CadetError
from tools.experiments.cells import GIVEN, LONGER, MIXED, REAL, SIM, TUNED, Cell
from tools.experiments.scales import Scale, tuned_config, with_length

_INPUTS: Final = ("classes", "bev", "image", "anchors", "extractor")


def matrix_cells(
    scale: Scale, classes: Sequence[str], maps: Sequence[str], num_seeds: int, steps: int | None = None
) -> tuple[Cell, ...]:
    """List the cells in the order in which they are run, seed by seed.

    Args:
        scale: their size.
        classes: of the paper's.
        maps: of the paper's configurations.
        num_seeds: seeds 0, 1, ...
        steps: of a training from scratch; tunings and schedules are shortened in proportion. None for the scale's own.
    """
    cells: list[Cell] = []
    for seed, class_name, name in product(range(num_seeds), classes, maps):
        sim = pretraining(scale, class_name, name, seed, steps)
        real = replace(sim, trained=REAL, stops=sim.stops[-1:], tests=(REAL,))
        cells += [sim, real, _tuned(scale, sim)]
    return tuple(cells)


def pretraining(scale: Scale, class_name: str, maps: str, seed: int, steps: int | None) -> Cell:
    """Return the cell that is trained on simulated frames; parameters as for `matrix_cells`."""
    config = scale.config(class_name, maps)
    whole = config.training.steps
    config = config if steps is None else with_length(config, steps)
    end = config.training.steps
    branch = scale.tuning.branch_step
    stops = {end} if branch is None else {proportion(branch, end, whole), end}
    return Cell(
        class_name=class_name,
        maps=maps,
        trained=SIM,
        seed=seed,
        config=config,
        stops=tuple(sorted(stops)),
        tests=(SIM, REAL),
        last=scale.last,
    )


def proportion(count: int, steps: int, of_steps: int) -> int:
    """Shorten a number of steps, 1 or more, as a training of `of_steps` is shortened to `steps`."""
    return max(1, round(count * steps / of_steps))


def _tuned(scale: Scale, sim: Cell) -> Cell:
    config = scale.config(sim.class_name, sim.maps)
    end, tuning = sim.config.training.steps, scale.tuning
    steps = proportion(tuning.steps, end, config.training.steps)
    cell = replace(sim, trained=TUNED, tests=(REAL, SIM), source=sim.name)
    if tuning.branch_step is None:
        return replace(cell, config=with_length(tuned_config(config, tuning), steps), stops=(steps,))
    first = sim.stops[0]
    return replace(cell, config=with_steps(sim.config, first + steps), stops=(first + steps,), branch_step=first)


def few_frame_cells(
    scale: Scale,
    classes: Sequence[str],
    maps: Sequence[str],
    num_seeds: int,
    frames: Sequence[int],
    steps: int | None = None,
    inits: Sequence[Path] = (),
    *,
    mixes: bool = True,
) -> tuple[Cell, ...]:
    """List the cells in the order in which they are run, seed by seed.

    All that is compared has seen equal numbers of steps. For each number of frames there are trainings on the same
    frames, which the seed draws: from scratch, as long as pre-training and tuning together, with the configuration's
    schedule; from pre-trained weights for `few_steps`, with the schedule of the scale's tuning stretched to them; and
    the same by turns with simulated frames. Pre-trained weights that go on with simulated frames alone show what longer
    training is worth. Weights that are given count as if they had been trained here. No checkpoint is chosen: the last
    counts.

    Args:
        scale: their size.
        classes: of the paper's.
        maps: of the paper's configurations.
        num_seeds: seeds 0, 1, ...
        frames: how many real frames each pair of trainings learns from.
        steps: of a training from scratch on all frames; the others are shortened in proportion. None for the scale's.
        inits: pre-trained checkpoints, one or one a seed; none has them trained.
        mixes: there are simulated frames to go on with.

    Raises:
        MissingFileError: no checkpoint there.
        CadetError: checkpoints for another number of seeds, of other inputs, or for several classes or maps.
    """
    given = _given(inits, classes, maps, num_seeds)
    cells: list[Cell] = []
    for seed, class_name, name in product(range(num_seeds), classes, maps):
        whole = scale.config(class_name, name)
        pretrained = pretraining(scale, class_name, name, seed, steps)
        length = pretrained.config.training.steps
        tuned_length = proportion(scale.few_steps, length, whole.training.steps)
        source: str | None = pretrained.name
        init = None
        if given:
            checkpoint = given[seed % len(given)]
            _check_inputs(checkpoint, pretrained)
            source, init = None, checkpoint.path
            pretrained = replace(pretrained, trained=GIVEN, stops=(), tests=(REAL,), init=init, last=1)
        if seed < len(given) or not given:
            cells.append(pretrained)
        tuned = replace(
            pretrained,
            trained=TUNED,
            config=with_length(tuned_config(whole, scale.tuning), tuned_length),
            stops=(tuned_length,),
            source=source,
            init=init,
            tests=(REAL,),
            last=1,
        )
        total = length + tuned_length
        scratch = replace(tuned, trained=REAL, config=with_length(whole, total), stops=(total,), source=None, init=None)
        if mixes:
            cells.append(replace(tuned, trained=LONGER))
        for count in frames:
            cells += [replace(scratch, frames=count), replace(tuned, frames=count)]
            if mixes:
                cells.append(replace(tuned, trained=MIXED, frames=count))
    return tuple(cells)


def _given(inits: Sequence[Path], classes: Sequence[str], maps: Sequence[str], num_seeds: int) -> list[Checkpoint]:
    if inits and (len(classes) > 1 or len(maps) > 1):
        raise CadetError("--init: these weights are of one class and one configuration of the maps: choose one of each")
    if len(inits) not in (0, 1, num_seeds):
        raise CadetError(f"--init: expected one checkpoint, or one for each of {num_seeds} seeds, got {len(inits)}")
    return [read_checkpoint(path) for path in inits]


def _check_inputs(checkpoint: Checkpoint, cell: Cell) -> None:
    for name in _INPUTS:
        if getattr(checkpoint.config, name) != getattr(cell.config, name):
            raise CadetError(f"--init {checkpoint.path}: its configuration has another {name!r} than these experiments")
