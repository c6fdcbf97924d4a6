"""The settings of a training besides its configuration."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import torch

from avod.data.mixture import Folders
from cadet._util.checks import check_number


@dataclass(frozen=True, kw_only=True)
class Run:
    """The settings of a training besides its configuration.

    Attributes:
        data: a KITTI folder, a folder of shards, a pattern that names shards, such as `set/train/{000..099}.tar`,
            or "sim:CONFIG.toml", frames of a `cadet.Simulation` without a dataset on disk; or several
            folders, one of which may be a simulation, each with its share of the frames: `(("sim:town.toml", 0.8),
            ("real", 0.2))`.
        out: where `run.json`, `log.csv` and `checkpoints` go: a folder without those of another training, unless
            `resume` is set or `resume_from` is this one's last checkpoint; the logs then keep their rows up to there.
        split: a list of `ImageSets`, or a folder of shards; None for every frame. Shards that are named are all read.
        seed: of weights, order and draws; None for 0, or for that of the training that goes on.
        init: a checkpoint whose weights training begins with, at step 0.
        resume: go on with the training of `out`, as it was begun, from its last checkpoint, or from the start if it
            has none yet.
        resume_from: a checkpoint from which training goes on with optimizer, step and schedule, on the same data or
            other.
        skip_steps: steps that are left out, counted from 0: those whose loss was no number.
        keep: how many checkpoints stay, None for all.
        val_every: steps between two validations; None for none.
        val_split: the list of frames that `validate` takes, for `run.json`.
        device: where the network runs, or its name, such as "cuda": several processes then take one each.
        precision: of the arithmetic of layers, None for float32.
        workers: processes that read samples; 0 reads them in between.
        is_compiled: compile the pyramids.
        has_tensorboard: write TensorBoard's files too.
        bank: of objects that are pasted into frames, as many as the configuration says.
        frames: learn from only this many of the folder's frames, drawn by the seed; fewer are among more; None
            for all that hold enough objects.

    Raises:
        CadetError: a number outside its range.
    """

    data: Folders
    out: str | Path
    split: str | None = "train"
    seed: int | None = None
    init: str | Path | None = None
    resume: bool = False
    resume_from: str | Path | None = None
    skip_steps: tuple[int, ...] = ()
    keep: int | None = None
    val_every: int | None = None
    val_split: str | None = "val"
    device: str | torch.device = "cpu"
    precision: torch.dtype | None = None
    workers: int = 0
    is_compiled: bool = False
    has_tensorboard: bool = False
    bank: str | Path | None = None
    frames: int | None = None

    def __post_init__(self) -> None:
        if self.seed is not None:
            check_number("Run", "seed", self.seed, 0, 2**63 - 1, whole=True)
        for name in ("keep", "val_every", "frames"):
            if getattr(self, name) is not None:
                check_number("Run", name, getattr(self, name), 1, whole=True)
        for step in self.skip_steps:
            check_number("Run", "skip_steps", step, 0, whole=True)
        check_number("Run", "workers", self.workers, 0, 1024, whole=True)
