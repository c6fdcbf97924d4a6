"""The paper's matrix: trained on simulated frames, on real ones, and on both, for each configuration of the maps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

from avod.experiments.cells import REAL, SIM, TUNED, Cell
from avod.experiments.scales import Scale, tuned_config, with_length
from avod.train import with_steps


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
