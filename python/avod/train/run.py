"""A training from its first step to its last."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn
from torch.utils.data import DataLoader

from avod.config import Config
from avod.data.dataset import TrainingData
from avod.data.order import StepSampler
from avod.data.sample import Sample
from avod.train.checkpoint import (
    Checkpoint,
    checkpoints,
    load_network,
    load_optimizer,
    read_checkpoint,
    save_checkpoint,
)
from avod.train.log import TrainingLog, read_log
from avod.train.processes import Processes
from avod.train.step import learning_rate, make_optimizer, new_network, training_step
from cadet.errors import CadetError

OnStep = Callable[[int, dict[str, Tensor]], None]


@dataclass(frozen=True, kw_only=True)
class Run:
    """The settings of a training besides its configuration.

    Attributes:
        data: a KITTI folder.
        out: where `log.csv` and `checkpoints` go: a folder without those of another training, unless `resume_from` is
            this one's last checkpoint; the log then keeps its rows up to that step.
        split: a list of `ImageSets`; None for every frame.
        seed: of weights, order and draws; a resumed training keeps its own.
        init: a checkpoint whose weights training begins with, at step 0.
        resume_from: a checkpoint from which training goes on with optimizer, step and schedule, on the same data or
            other.
        device: where the network runs.
        precision: of the arithmetic of layers, None for float32.
        workers: processes that read samples; 0 reads them in between.
        is_compiled: compile the pyramids.
        has_tensorboard: write TensorBoard's files too.
    """

    data: str | Path
    out: str | Path
    split: str | None = "train"
    seed: int = 0
    init: str | Path | None = None
    resume_from: str | Path | None = None
    device: torch.device = torch.device("cpu")
    precision: torch.dtype | None = None
    workers: int = 0
    is_compiled: bool = False
    has_tensorboard: bool = False


def train(config: Config, run: Run, *, on_step: OnStep | None = None) -> Path:
    """Train a detector and return its last checkpoint.

    Steps, frames and draws follow from seed and step, so a training that was stopped and goes on from a checkpoint
    gives the same numbers as one that was not.

    Args:
        config: the detector and its training.
        run: data, folders, device.
        on_step: hears of each step that is done, and its losses.

    Raises:
        CadetError: bad data or checkpoints, or a loss that is no number.
    """
    if run.init is not None and run.resume_from is not None:
        raise CadetError("a training either begins with a checkpoint's weights or goes on from one, not both")
    processes = Processes.current()
    first_step, seed = 0, run.seed
    checkpoint = None
    network = new_network(config, seed).to(run.device)
    optimizer = make_optimizer(network, config.training)
    if run.init is not None:
        load_network(read_checkpoint(run.init), network)
    if run.resume_from is not None:
        checkpoint = read_checkpoint(run.resume_from)
        _check_same_detector(checkpoint, config)
        load_network(checkpoint, network)
        load_optimizer(checkpoint, network, optimizer)
        first_step, seed = checkpoint.step, checkpoint.seed
    out = Path(run.out)
    _check_unused(out, checkpoint, processes)
    if first_step >= config.training.steps:
        raise CadetError(
            f"{run.resume_from}: {first_step} steps are done, and training ends at {config.training.steps}"
        )
    data = TrainingData(run.data, run.split, config, seed)
    network.precision = run.precision
    network.train()
    if run.is_compiled:
        for pyramid in (network.bev_pyramid, network.image_pyramid):
            pyramid.compile(dynamic=False)
    folder = out / "checkpoints"
    log = None
    if processes.is_first:
        out.mkdir(parents=True, exist_ok=True)
        log = TrainingLog(out, first_step, has_tensorboard=run.has_tensorboard)
    wrapped: nn.Module = processes.wrap(network)
    last = folder / f"{config.training.steps:09d}"
    steps = range(first_step, config.training.steps)
    for step, samples in zip(steps, _batches(data, config, run, first_step, processes), strict=True):
        losses = training_step(
            wrapped, optimizer, _on_device(samples, run.device), config, step=step, seed=seed, rank=processes.rank
        )
        done = step + 1
        if log is not None:
            is_last = done == config.training.steps
            log.on_step(done, losses, learning_rate(step, config.training), is_last=is_last)
            if done % config.training.checkpoint_steps == 0 or is_last:
                last = save_checkpoint(folder, network, optimizer, config, step=done, seed=seed)
        if on_step is not None:
            on_step(done, losses)
    return last


def _check_unused(out: Path, resumed: Checkpoint | None, processes: Processes) -> None:
    """Refuse a folder that holds another training's log or checkpoints: two in one could not be told apart."""
    if not processes.is_first:
        return  # The first process may have begun to write.
    present, log = checkpoints(out / "checkpoints"), out / "log.csv"
    if resumed is not None and resumed.path.resolve().parent == (out / "checkpoints").resolve():
        if present[-1].name != resumed.path.name:
            raise CadetError(
                f"{out} holds checkpoints up to {present[-1].name}, and training is to go on from {resumed.path.name}: "
                f"go on from the last with --resume-from {out}, or name a new folder with --out"
            )
    elif present:
        raise CadetError(
            f"{out} holds another training: name a new folder with --out, or go on with this one by --resume-from {out}"
        )
    elif log.is_file() and read_log(log):
        raise CadetError(f"{out} holds the log of another training: name a new folder with --out")


def _check_same_detector(checkpoint: Checkpoint, config: Config) -> None:
    """Refuse to go on with a network that was made for other inputs or classes: its weights might fit all the same."""
    for name in ("classes", "bev", "image", "anchors", "extractor"):
        if getattr(checkpoint.config, name) != getattr(config, name):
            raise CadetError(
                f"{checkpoint.path}: its configuration has another {name!r}; take its weights alone with --init"
            )


def with_steps(config: Config, steps: int | None) -> Config:
    """Return the configuration with another number of steps; None changes nothing."""
    return config if steps is None else replace(config, training=replace(config.training, steps=steps))


def _batches(
    data: TrainingData, config: Config, run: Run, first_step: int, processes: Processes
) -> Iterable[list[Sample | CadetError]]:
    training = config.training
    sampler = StepSampler(first_step, training.steps, training.frames_per_step, processes.rank, processes.world_size)
    loader: DataLoader[Any] = DataLoader(
        data,
        batch_sampler=sampler,
        num_workers=run.workers,
        collate_fn=list,
        pin_memory=run.device.type == "cuda",
        persistent_workers=run.workers > 0,
    )
    return loader


def _on_device(samples: list[Sample | CadetError], device: torch.device) -> list[Sample]:
    moved = []
    for sample in samples:
        if isinstance(sample, CadetError):
            raise sample
        moved.append(sample.to(device))
    return moved
