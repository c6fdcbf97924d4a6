"""What a training was begun with: `run.json` in its folder. Going on with anything else is refused or said."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any, Final

from avod.config import Config
from avod.config_file import config_from_table, table_from_config
from avod.train.made_with import made_with
from cadet._util.plain_text import json_from_text
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.folder import write_whole

_NAME: Final = "run.json"
_FORMAT: Final = "avod-training"
_VERSION: Final = 1
# How far a training goes and how often it is written down changes no step; detection is no part of training.
_FREE: Final = ("training.steps", "training.checkpoint_steps", "detection.")
_REFUSED: Final = ("seed", "split", "shares", "num_frames", "frames_crc32", "bank_crc32", "init")
_WHAT: Final = {
    "num_frames": "frames to learn from",
    "frames_crc32": "a checksum of its frames' ids",
    "bank_crc32": "a checksum of its bank's objects",
}
_SAID: Final = ("data", "bank", "num_processes", "device", "precision", "is_compiled")


@dataclass(frozen=True, kw_only=True)
class Record:
    """The settings that decide a training's numbers.

    Attributes:
        config: of the detector and its training.
        seed: of all that is drawn.
        data: the KITTI folder, shards or simulation, or several folders.
        split: the list of its `ImageSets`; None for every frame.
        num_frames: frames that are learned from; 0 of a simulation, which has no end.
        frames_crc32: checksum of their ids, whose order matters, or of all that a simulation's frames follow from.
        init: the checkpoint whose weights it began with, or None.
        num_processes: how many share a step.
        device: kind of device.
        precision: of the arithmetic of layers, None for float32.
        is_compiled: whether the pyramids are compiled.
        skipped_steps: steps that are left out, in order.
        keep: how many checkpoints stay, None for all.
        val_every: steps between two validations, None for none.
        val_split: the list of frames for those; None for every frame.
        shares: of the folders, where there are several.
        bank: of the objects that are pasted into frames, or None.
        bank_crc32: checksum of its list.
        frames: how many of the folder's frames were drawn to learn from, None for all.
        resume_from: the checkpoint of another training that it went on from, or None.
    """

    config: Config
    seed: int
    data: str | tuple[str, ...]
    split: str | None
    num_frames: int
    frames_crc32: int
    init: str | None = None
    num_processes: int = 1
    device: str = "cpu"
    precision: str | None = None
    is_compiled: bool = False
    skipped_steps: tuple[int, ...] = ()
    keep: int | None = None
    val_every: int | None = None
    val_split: str | None = None
    shares: tuple[float, ...] | None = None
    bank: str | None = None
    bank_crc32: int | None = None
    frames: int | None = None
    resume_from: str | None = None

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
    config = config_from_table(table.get("config"), f"{path}: config")
    values: dict[str, Any] = {"config": config}
    for item in fields(Record):
        if item.name != "config":
            value = table.get(item.name)
            value = tuple(value) if isinstance(value, list) else value
            if not _is_of_kind(value, str(item.type)):
                raise CadetError(f"{path}: {item.name}: expected {item.type}, got {value!r:.40}")
            values[item.name] = value
    num_folders = len(values["data"]) if isinstance(values["data"], tuple) else 0
    if num_folders != len(values["shares"] or ()):
        raise CadetError(
            f"{path}: shares: expected one for each of {num_folders} folders, got {values['shares']!r:.40}"
        )
    return Record(**values)


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
        if not name.startswith(_FREE):
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


def differences(old: object, new: object, path: str = "") -> Iterator[tuple[str, object, object]]:
    """Yield the path, the old and the new value of each entry that differs between two tables."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in {**old, **new}:
            yield from differences(old.get(key), new.get(key), f"{path}.{key}" if path else str(key))
    elif old != new:
        yield path, old, new


def _is_of_kind(value: object, kind: str) -> bool:
    if value is None:
        return kind.endswith("None")
    if isinstance(value, tuple):
        item = next((name for name in ("int", "float", "str") if f"tuple[{name}, ...]" in kind), None)
        return item is not None and all(_is_of_kind(entry, item) for entry in value)
    if kind.startswith("tuple"):
        return False
    if kind == "float":
        return isinstance(value, float) and 0.0 <= value <= 1.0
    if kind == "bool":
        return isinstance(value, bool)
    if kind.startswith("int"):
        return isinstance(value, int) and not isinstance(value, bool) and value >= 0
    return isinstance(value, str)
