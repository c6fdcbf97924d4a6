"""The settings of a training: what is asked for (`Run`), and what it was begun with (`run.json` in its folder)."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Final

import torch

from avod.config import Config
from avod.config.tables import differences, table_from_config
from avod.data.mixture import Folders
from cadet import __version__
from cadet._util.checks import MAX_SEED, Limits, check_fields
from cadet._util.plain_tables import object_of_table
from cadet._util.plain_text import json_from_text
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.folder import write_whole

_NAME: Final = "run.json"
_FORMAT: Final = "avod-training"
_VERSION: Final = 1
_HEAD: Final = ("format", "version", "made_with")
# How often a training is written down changes no step; detection is no part of training. How far it goes changes none
# either, unless the schedule spans it.
_FREE: Final = {
    "steps": ("training.steps", "training.checkpoint_steps", "detection."),
    "one_cycle": ("training.checkpoint_steps", "detection."),
}
_REFUSED: Final = ("seed", "split", "shares", "num_used", "frames_crc32", "bank_crc32", "init", "init_refinement")
_WHAT: Final = {
    "num_used": "frames to learn from",
    "frames_crc32": "a checksum of its frames' ids",
    "bank_crc32": "a checksum of its bank's objects",
}
_SAID: Final = ("data", "bank", "num_processes", "device", "precision", "compile")
_PACKAGE = Path(__file__).parents[1]


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
        init_refinement: a checkpoint, perhaps of another network, whose last stage training begins with.
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
        compile: compile the pyramids.
        tensorboard: write TensorBoard's files too.
        bank: of objects that are pasted into frames, as many as the configuration says.
        num_frames: learn from only this many of the folder's frames, or of the last folder's, drawn by the seed; fewer
            are among more; None for all that hold enough objects.

    Raises:
        CadetError: a number outside its range.
    """

    data: Folders
    out: str | Path
    split: str | None = "train"
    seed: Annotated[int | None, Limits(0, MAX_SEED)] = None
    init: str | Path | None = None
    init_refinement: str | Path | None = None
    resume: bool = False
    resume_from: str | Path | None = None
    skip_steps: Annotated[tuple[int, ...], Limits(0)] = ()
    keep: Annotated[int | None, Limits(1)] = None
    val_every: Annotated[int | None, Limits(1)] = None
    val_split: str | None = "val"
    device: str | torch.device = "cpu"
    precision: torch.dtype | None = None
    workers: Annotated[int, Limits(0, 1024)] = 0
    compile: bool = False
    tensorboard: bool = False
    bank: str | Path | None = None
    num_frames: Annotated[int | None, Limits(1)] = None

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, kw_only=True)
class Record:
    """The settings that decide a training's numbers.

    Attributes:
        config: of the detector and its training.
        seed: of all that is drawn.
        data: the KITTI folder, shards or simulation, or several folders.
        split: the list of its `ImageSets`; None for every frame.
        num_used: frames that are learned from; 0 of a simulation, which has no end.
        frames_crc32: checksum of their ids, whose order matters, or of all that a simulation's frames follow from.
        init: the checkpoint whose weights it began with, or None.
        init_refinement: the checkpoint whose last stage it began with, or None.
        num_processes: how many share a step.
        device: kind of device.
        precision: of the arithmetic of layers, None for float32.
        compile: whether the pyramids are compiled.
        skipped_steps: steps that are left out, in order.
        keep: how many checkpoints stay, None for all.
        val_every: steps between two validations, None for none.
        val_split: the list of frames for those; None for every frame.
        shares: of the folders, where there are several.
        bank: of the objects that are pasted into frames, or None.
        bank_crc32: checksum of its list.
        num_frames: how many of the folder's frames were drawn to learn from, None for all.
        resume_from: the checkpoint of another training that it went on from, or None.

    Raises:
        CadetError: a number outside its range, or not as many shares as folders.
    """

    config: Config
    seed: Annotated[int, Limits(0)]
    data: str | tuple[str, ...]
    split: str | None
    num_used: Annotated[int, Limits(0)]
    frames_crc32: Annotated[int, Limits(0)]
    init: str | None = None
    init_refinement: str | None = None
    num_processes: Annotated[int, Limits(1)] = 1
    device: str = "cpu"
    precision: str | None = None
    compile: bool = False
    skipped_steps: Annotated[tuple[int, ...], Limits(0)] = ()
    keep: Annotated[int | None, Limits(1)] = None
    val_every: Annotated[int | None, Limits(1)] = None
    val_split: str | None = None
    shares: tuple[float, ...] | None = None
    bank: str | None = None
    bank_crc32: Annotated[int | None, Limits(0)] = None
    num_frames: Annotated[int | None, Limits(1)] = None
    resume_from: str | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        num_folders = len(self.data) if isinstance(self.data, tuple) else 0
        if num_folders != len(self.shares or ()):
            raise CadetError(f"shares: expected one for each of {num_folders} folders, got {self.shares!r:.40}")

    @property
    def folders(self) -> tuple[tuple[Path, float], ...]:
        """The folders of frames, and their shares."""
        if isinstance(self.data, str):
            return ((Path(self.data), 1.0),)
        return tuple((Path(name), share) for name, share in zip(self.data, self.shares or (), strict=True))


def write_record(out: Path, record: Record) -> None:
    """Write `run.json`, whole or not at all."""
    table = {"format": _FORMAT, "version": _VERSION, "made_with": made_with(), **asdict(record)}
    table["config"] = table_from_config(record.config)
    write_whole({out / _NAME: (json.dumps(table, indent=1) + "\n").encode()})


def has_record(out: Path) -> bool:
    """Tell whether a training was begun in a folder."""
    return (out / _NAME).is_file()


def read_record(out: Path) -> Record:
    """Read `run.json`.

    Raises:
        MissingFileError: there is none: nothing was begun in this folder.
        CadetError: a damaged one, or one of another version.
    """
    path = out / _NAME
    if not has_record(out):
        raise MissingFileError(f"{path}: no such file: {out} holds no training that --resume could go on with")
    table = json_from_text(path.read_bytes(), str(path))
    if not isinstance(table, dict) or table.get("format") != _FORMAT:
        raise CadetError(f"{path}: not a record of an avod training")
    if table.get("version") != _VERSION:
        raise CadetError(f"{path}: version {table.get('version')!r}, expected {_VERSION}")
    own = {key: value for key, value in table.items() if key not in _HEAD}
    try:
        return object_of_table(Record, own, Path())
    except CadetError as error:
        raise CadetError(f"{path}: {error}") from None


def check_resumed(out: Path, old: Record, new: Record) -> Iterator[str]:
    """Compare how a training goes on with how it began.

    Args:
        out: its folder, for messages.
        old: what it was begun with.
        new: what it is to go on with.

    Yields:
        A line for each change that may change numbers and is allowed.

    Raises:
        CadetError: another setting that training follows from; it is named with both values.
    """
    for name, was, now in differences(table_from_config(old.config), table_from_config(new.config)):
        if not name.startswith(_FREE[old.config.training.schedule]):
            raise CadetError(
                f"{out}: its training has {name} = {was!r}, and is to go on with {now!r}: "
                "change nothing, or begin another with --init or --resume-from"
            )
    for name in _REFUSED:
        was, now = getattr(old, name), getattr(new, name)
        if was != now:
            what = _WHAT.get(name, name)
            raise CadetError(
                f"{out}: its training has {what} = {was!r}, and is to go on with {now!r}: it would be another training"
            )
    for name in _SAID:
        was, now = getattr(old, name), getattr(new, name)
        if was != now:
            yield f"{out}: {name} was {was!r} and is {now!r}: numbers may differ from an unbroken training's"


def with_skipped(record: Record, steps: Sequence[int]) -> Record:
    """Return the record with further steps that are left out."""
    return replace(record, skipped_steps=tuple(sorted({*record.skipped_steps, *steps})))


def made_with() -> dict[str, str | None]:
    """Return the versions of the package and of PyTorch, and the commit if the package lies in its own working copy."""
    return {"cadet": __version__, "torch": torch.__version__, "commit": commit(_PACKAGE)}


@lru_cache(maxsize=4)
def commit(folder: Path) -> str | None:
    """Return the git commit of a folder, with "+changes" if files there differ from it.

    None where git is missing or does not track the folder's files: an installed package inside somebody else's
    repository is not of that repository's commit.
    """
    if _git(folder, "ls-files", "--error-unmatch", "__init__.py") is None:
        return None
    head = _git(folder, "rev-parse", "HEAD")
    if not head:
        return None
    return head if _git(folder, "status", "--porcelain", "--untracked-files=no", ".") == "" else f"{head}+changes"


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        done = subprocess.run(
            ["git", "-C", str(folder), *arguments], capture_output=True, text=True, timeout=10, check=False
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() if done.returncode == 0 else None
