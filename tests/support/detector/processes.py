"""One of the processes that `tests/avod/train/test_processes.py` starts: `python processes.py FOLDER`."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import torch
from safetensors.torch import save_file

from avod.config import Config
from avod.data.dataset import TrainingData
from avod.data.sample import Sample
from avod.device import Processes
from avod.train.step import make_optimizer, training_step
from avod.validate import Validator
from detector.runs import Frozen, StopAfter, short_run, small_config

STEPS = 5


def without_draws(config: Config) -> Config:
    """Let mini-batches hold everything, so that nothing depends on what a process draws."""
    rpn = dataclasses.replace(config.rpn, batch_size=65_536, dropout_keep=1.0)
    second = dataclasses.replace(config.second_stage, batch_size=4096, dropout_keep=1.0)
    # Gradients are averaged before they are clipped, in one process and in two.
    return dataclasses.replace(config, rpn=rpn, second_stage=second)


def steps_of(config: Config, data: Path, processes: Processes, frames_per_step: int) -> dict[str, torch.Tensor]:
    """Train three steps, and return the weights and each step's mean losses."""
    config = without_draws(config)
    torch.manual_seed(0)
    network = Frozen(config).train()
    wrapped = processes.wrap(network)
    optimizer = make_optimizer(network, config.training)
    frames = TrainingData(data, "train", config, 0)
    found: dict[str, torch.Tensor] = {}
    for step in range(3):
        first = (step * processes.world_size + processes.rank) * frames_per_step
        samples = [frames[index] for index in range(first, first + frames_per_step)]
        assert all(isinstance(sample, Sample) for sample in samples)
        losses = training_step(wrapped, optimizer, samples, config, step=step, seed=0, rank=processes.rank)  # type: ignore[arg-type]
        found |= {f"losses.{step}.{name}": value for name, value in processes.mean(losses).items()}
    return found | dict(network.state_dict())


def main() -> None:
    """Train in several ways, all with the other processes."""
    folder = Path(sys.argv[1])
    torch.set_num_threads(1)
    config, data = small_config(folder / f"config{sys.argv[2]}"), folder / "set"
    with Processes.joined(torch.device("cpu")) as processes:
        weights = steps_of(config, data, processes, 1)
        save_file({name: value.contiguous() for name, value in weights.items()}, folder / f"rank{processes.rank}")
        assert processes.gathered(processes.rank) == [0, 1]
        assert processes.any(processes.rank == 1) and not processes.any(False)
        validator = Validator(data, "val", config)
        short_run(config, data, folder / "unbroken", STEPS, val_every=2, validate=validator)
        # One process hears that it should stop, and all do.
        stop = StopAfter(2 if processes.rank == 1 else 10**6)
        last = short_run(config, data, folder / "parts", STEPS, val_every=2, validate=validator, should_stop=stop)
        assert last.name == "000000002"
        short_run(config, data, folder / "parts", STEPS, val_every=2, validate=validator, resume=True)


if __name__ == "__main__":
    main()
