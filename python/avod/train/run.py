"""A training from its first step to its last."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from torch import Tensor, nn

from avod.config import Config
from avod.data.dataset import TrainingData
from avod.data.frames import PREFIX, is_simulation
from avod.data.loading import batches, whole
from avod.data.mixed import MixedData
from avod.data.mixture import shares_of
from avod.data.sample import Sample
from avod.data.simulated import SimulatedData
from avod.device import Processes, name_of_process, resolve_device
from avod.model.network import AnyNetwork
from avod.train.checkpoint import forget_old, remove_partial, save_checkpoint
from avod.train.log import TrainingLog, Validated, ValidationLog
from avod.train.settings import Record, Run, check_resumed, with_skipped, write_record
from avod.train.start import Start, begin
from avod.train.step import NonFiniteLossError, learning_rate, train_mode, training_step
from cadet.datasets.object_bank import ObjectBank
from cadet.errors import CadetError, CadetWarning

__all__ = ["OnStep", "Run", "Validate", "train", "with_steps"]

OnStep = Callable[[int, dict[str, Tensor]], None]
Validate = Callable[[AnyNetwork, int, Processes], Validated | None]
"""Judges a network after so many steps; None if it was told to stop."""

BEST: str = "best_val"
"""The folder, beside `checkpoints`, of the checkpoint that did best on the frames of validation."""


def train(
    config: Config,
    run: Run,
    *,
    on_step: OnStep | None = None,
    validate: Validate | None = None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Path:
    """Train a detector and return its last checkpoint.

    Steps, frames and draws follow from seed and step, so a training that was stopped and goes on from a checkpoint
    gives the same numbers as one that was not.

    Args:
        config: the detector and its training.
        run: data, folders, device.
        on_step: called after each step with its number and losses; no losses for one that was skipped.
        validate: judges the network every `run.val_every` steps and after the last; `avod.validate.Validator` does.
        should_stop: called after each step; on True training writes a checkpoint and ends.

    Raises:
        CadetError: bad data or checkpoints, a device that cannot be used, or a loss that is not a number.
    """
    named = name_of_process(run.device) if isinstance(run.device, str) else run.device
    with Processes.joined(resolve_device(named)) as processes:
        training = _Training(config, run, validate, processes)
        return training.go_on(on_step, should_stop)


def with_steps(config: Config, steps: int | None) -> Config:
    """Return the configuration with another number of steps; None changes nothing."""
    return config if steps is None else replace(config, training=replace(config.training, steps=steps))


def _data(config: Config, run: Run, seed: int, bank: ObjectBank | None) -> TrainingData | SimulatedData | MixedData:
    folders = shares_of(run.data)
    if not any(is_simulation(name) for name, _ in folders):
        return TrainingData(run.data, run.split, config, seed, bank, run.num_frames)
    if run.num_frames is not None:
        raise CadetError(f"--num-frames {run.num_frames}: the frames of a simulation have no end to draw from")
    if len(folders) == 1:
        return SimulatedData(str(folders[0][0]), config, seed, bank)
    return MixedData(folders, run.split, config, seed, bank)


def _full_name(data: Path) -> str:
    name = str(data)
    if is_simulation(name):
        return PREFIX + str(Path(name.removeprefix(PREFIX)).resolve())
    return str(data.resolve())


def _text(path: str | Path | None) -> str | None:
    return None if path is None else str(path)


class _Training:
    def __init__(self, config: Config, run: Run, validate: Validate | None, processes: Processes) -> None:
        self.config, self.run, self.processes = config, run, processes
        if run.val_every is not None and validate is None:
            raise CadetError("Run.val_every: expected None without a function that validates")
        self.validate = None if run.val_every is None else validate
        self.out = Path(run.out)
        self.start = start = begin(config, run, processes.device, is_first=processes.is_first)
        if len(steps := set(processes.gathered(start.step))) > 1:
            raise CadetError(f"{run.out}: the processes found different last steps there: {sorted(steps)}")
        self.bank = None if run.bank is None else ObjectBank(run.bank)
        self.data = _data(config, run, start.seed, self.bank)
        record = self._record(start)
        self.skipped = frozenset(record.skipped_steps)
        self.notes = {"data": record.data, "split": record.split}
        self.network, self.optimizer = start.network, start.optimizer
        self.average = start.average
        self.network.precision = run.precision
        if self.average is not None:
            self.average.network.precision = run.precision
        train_mode(self.network, config.training)
        if run.compile:
            for extractor in self.network.extractors():
                extractor.compile(dynamic=False)
        self.folder = self.out / "checkpoints"
        self.last = self.folder / f"{start.step:09d}"
        self.log: TrainingLog | None = None
        self.validations: ValidationLog | None = None
        if processes.is_first:
            self.out.mkdir(parents=True, exist_ok=True)
            write_record(self.out, record)
            remove_partial(self.folder)
            self.log = TrainingLog(
                self.out, start.step, self.network.terms, pending=start.pending, tensorboard=run.tensorboard
            )
            if self.validate is not None:
                self.validations = ValidationLog(self.out, start.step, self.network.terms, config.class_names)

    def go_on(self, on_step: OnStep | None, should_stop: Callable[[], bool]) -> Path:
        config, first, processes = self.config.training, self.start.step, self.processes
        wrapped = processes.wrap(self.network)
        if self.start.goes_on and self._is_unvalidated(first):
            self._validate(first)  # It was killed meanwhile.
        with batches(self.data, config, first, processes, self.run.workers) as samples_of_steps:
            for step, samples in zip(range(first, config.steps), samples_of_steps, strict=True):
                losses: dict[str, Tensor] = {}
                if step not in self.skipped:
                    losses = processes.mean(self._step(wrapped, step, whole(samples, processes.device)))
                    if self.average is not None:
                        self.average.update(self.network, step)
                done = step + 1
                is_last = done == config.steps
                if self.log is not None:
                    self.log.on_step(done, losses, learning_rate(step, config), is_last=is_last)
                if done % config.checkpoint_steps == 0 or is_last:
                    self._save(done)
                if on_step is not None:
                    on_step(done, losses)
                if self.validate is not None and (is_last or done % (self.run.val_every or 1) == 0):
                    self._validate(done)
                if processes.any(should_stop()):
                    if self.last.name != f"{done:09d}":
                        self._save(done)
                    break
        processes.any(False)  # Nobody goes on before the first has written.
        return self.last

    def _step(self, wrapped: nn.Module, step: int, samples: list[Sample]) -> dict[str, Tensor]:
        seed, rank = self.start.seed, self.processes.rank
        try:
            return training_step(wrapped, self.optimizer, samples, self.config, step=step, seed=seed, rank=rank)
        except NonFiniteLossError as error:
            raise NonFiniteLossError(
                f"{error}; look at its labels and points, or go on without this step by "
                f"--out {self.out} --resume --skip-steps {step}"
            ) from None

    def _save(self, step: int) -> None:
        if self.log is not None:
            notes = {**self.notes, "pending": self.log.pending}
            self._write(self.folder, step, notes, has_optimizer=True)
            forget_old(self.folder, self.run.keep)
        self.last = self.folder / f"{step:09d}"

    def _write(self, folder: Path, step: int, notes: dict[str, Any], *, has_optimizer: bool) -> None:
        save_checkpoint(
            folder,
            self.network,
            self.optimizer if has_optimizer else None,
            self.config,
            step=step,
            seed=self.start.seed,
            average=None if self.average is None else self.average.network,
            notes=notes,
            name=None if has_optimizer else BEST,
        )

    def _is_unvalidated(self, step: int) -> bool:
        every = self.run.val_every
        is_due = self.validate is not None and step > 0 and every is not None and step % every == 0
        return self.processes.any(is_due and self.validations is not None and step not in self.validations.steps)

    def _validate(self, step: int) -> None:
        assert self.validate is not None
        judged = self.network if self.average is None else self.average.network
        self.processes.share_buffers(judged)
        found = self.validate(judged, step, self.processes)
        train_mode(self.network, self.config.training)
        if found is None or self.validations is None or self.log is None:
            return
        if self.validations.add(step, found):
            notes = {**self.notes, "validated": {"ap": found.ap, "loss": found.losses["total"]}}
            self._write(self.out, step, notes, has_optimizer=False)
        scalars = {f"val/{name}": value for name, value in found.losses.items()}
        self.log.add_scalars(step, scalars | {"val/ap": found.ap})

    def _record(self, start: Start) -> Record:
        run, begun = self.run, start.begun
        folders = shares_of(run.data)
        names = tuple(_full_name(folder) for folder, _ in folders)
        record = Record(
            config=self.config,
            seed=start.seed,
            data=names[0] if len(names) == 1 else names,
            shares=None if len(names) == 1 else tuple(share for _, share in folders),
            split=run.split,
            num_used=self.data.num_frames,
            frames_crc32=self.data.checksum,
            init=_text(begun.init),
            init_refinement=_text(begun.init_refinement),
            num_processes=self.processes.world_size,
            device=self.processes.device.type,
            precision=None if run.precision is None else str(run.precision).removeprefix("torch."),
            compile=run.compile,
            keep=run.keep,
            val_every=run.val_every,
            val_split=run.val_split,
            bank=None if self.bank is None else str(self.bank.root.resolve()),
            bank_crc32=None if self.bank is None else self.bank.crc32,
            num_frames=run.num_frames,
            resume_from=_text(begun.resume_from),
        )
        for step in run.skip_steps:
            if step < start.step:
                raise CadetError(f"--skip-steps {step}: {start.step} steps are done, and training goes on from there")
        if run.resume and isinstance(begun, Record):
            for line in check_resumed(self.out, begun, record):
                if self.processes.is_first:
                    warnings.warn(line, CadetWarning, stacklevel=4)
        earlier = begun.skipped_steps if isinstance(begun, Record) else ()
        return with_skipped(record, (*earlier, *run.skip_steps))
