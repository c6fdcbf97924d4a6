"""Where a training begins: new, with another's weights, or where it or another one stopped."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import torch

from avod.config import Config
from avod.config.tables import differences, table_from_config
from avod.model.network import AnyNetwork
from avod.train.checkpoint import Checkpoint, checkpoints, load_network, load_optimizer, read_checkpoint
from avod.train.log import read_log
from avod.train.settings import Record, Run, has_record, read_record
from avod.train.step import WeightAverage, make_optimizer, new_network
from cadet.errors import CadetError, CadetWarning


@dataclass(frozen=True)
class Start:
    """The first step and all that it needs.

    Attributes:
        step: how many steps are done.
        seed: of the training.
        network: with its weights, on its device.
        optimizer: with its averages.
        begun: the settings that it was begun with, those of the folder's record if its training goes on.
        pending: sums of the log's next row.
        goes_on: whether the training of this very folder goes on.
        average: of the weights, if the configuration asks for one.
    """

    step: int
    seed: int
    network: AnyNetwork
    optimizer: torch.optim.Optimizer
    begun: Run | Record
    pending: Mapping[str, float] = field(default_factory=dict)
    goes_on: bool = False
    average: WeightAverage | None = None


def begin(config: Config, run: Run, device: torch.device, *, is_first: bool) -> Start:
    """Make or load what a training begins with.

    Args:
        config: the detector and its training.
        run: says which of the ways it is.
        device: of the network.
        is_first: whether this process is the one that writes, and so looks at what the folder holds.

    Raises:
        CadetError: several ways at once, a folder that holds another training or none, a checkpoint of another
            detector, another seed, or a training that is done.
    """
    ways = [run.init is not None or run.init_refinement is not None, run.resume_from is not None, run.resume]
    if sum(ways) > 1:
        raise CadetError(
            "a training begins with checkpoints' weights (--init, --init-refinement), goes on from one "
            "(--resume-from), or goes on in its own folder (--resume), not both"
        )
    out = Path(run.out)
    if run.resume:
        return _own(config, run, device, out)
    if run.resume_from is not None:
        return _from(config, run, device, out, is_first)
    start = _new(config, 0 if run.seed is None else run.seed, device, run)
    if is_first:
        _check_unused(out, None)
    return start


def _new(config: Config, seed: int, device: torch.device, begun: Run | Record) -> Start:
    network = new_network(config, seed).to(device)
    if begun.init is not None:
        load_network(read_checkpoint(begun.init), network)
    if begun.init_refinement is not None:
        if network.refinement is None:
            raise CadetError("--init-refinement: the configuration has no last stage: its refinement.max_points is 0")
        load_network(read_checkpoint(begun.init_refinement), network, "refinement.")
    optimizer = make_optimizer(network, config.training)
    return Start(0, seed, network, optimizer, begun, average=_average(network, config))


def _average(network: AnyNetwork, config: Config) -> WeightAverage | None:
    decay = config.training.average_decay
    return WeightAverage(network, decay) if decay else None


def _own(config: Config, run: Run, device: torch.device, out: Path) -> Start:
    written = checkpoints(out / "checkpoints")
    record: Record | None
    if not written:
        # Killed before its first checkpoint: from the start, as it was begun.
        record = read_record(out)
        _check_seed(run, record.seed, out)
        if record.resume_from is None:
            start = _new(config, record.seed, device, record)
        else:
            start = _continued(config, run, device, read_checkpoint(record.resume_from))
    else:
        record = read_record(out) if has_record(out) else None
        start = _continued(config, run, device, read_checkpoint(written[-1]))
    return replace(start, begun=record or run, goes_on=True)


def _from(config: Config, run: Run, device: torch.device, out: Path, is_first: bool) -> Start:
    assert run.resume_from is not None
    checkpoint = read_checkpoint(run.resume_from)
    start = _continued(config, run, device, checkpoint)
    goes_on = _is_of(checkpoint, out)
    if is_first:
        _check_unused(out, checkpoint)
        for name, was, now in differences(table_from_config(checkpoint.config), table_from_config(config)):
            if name not in ("training.steps", "training.checkpoint_steps"):
                text = f"{checkpoint.path} was trained with {name} = {was!r}, and training goes on with {now!r}"
                warnings.warn(text, CadetWarning, stacklevel=4)
    begun = read_record(out) if goes_on and has_record(out) else replace(run, resume_from=checkpoint.path)
    return replace(start, begun=begun, goes_on=goes_on)


def _continued(config: Config, run: Run, device: torch.device, checkpoint: Checkpoint) -> Start:
    _check_same_detector(checkpoint, config)
    _check_seed(run, checkpoint.seed, checkpoint.path)
    network = new_network(config, checkpoint.seed).to(device)
    optimizer = make_optimizer(network, config.training)
    load_network(checkpoint, network)
    average = _average(network, config)
    load_optimizer(checkpoint, network, optimizer)
    # A training that is done may be resumed: nothing is left to do.
    if checkpoint.step >= config.training.steps + int(run.resume):
        raise CadetError(
            f"{run.resume_from or checkpoint.path}: {checkpoint.step} steps are done, and training ends at "
            f"{config.training.steps}"
        )
    return Start(checkpoint.step, checkpoint.seed, network, optimizer, run, checkpoint.pending, average=average)


def _check_seed(run: Run, seed: int, where: Path) -> None:
    if run.seed is not None and run.seed != seed:
        raise CadetError(f"{where}: trained with seed {seed}, which --seed {run.seed} cannot change: leave it out")


def _is_of(checkpoint: Checkpoint, out: Path) -> bool:
    return checkpoint.path.resolve().parent == (out / "checkpoints").resolve()


def _check_unused(out: Path, resumed: Checkpoint | None) -> None:
    """Refuse a folder that holds another training's log or checkpoints: two in one could not be told apart."""
    present, log = checkpoints(out / "checkpoints"), out / "log.csv"
    if resumed is not None and _is_of(resumed, out):
        if present[-1].name != resumed.path.name:
            raise CadetError(
                f"{out} holds checkpoints up to {present[-1].name}, and training is to go on from {resumed.path.name}: "
                f"go on from the last with --out {out} --resume, or name a new folder with --out"
            )
    elif present:
        raise CadetError(
            f"{out} holds another training: name a new folder with --out, or go on with this one by "
            f"--out {out} --resume"
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
