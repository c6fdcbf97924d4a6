"""What a dataset is made from."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import InitVar, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from cadet import _cadet
from cadet._util.checks import as_seed, as_tuple, check_kind, check_number, is_one_of, known_names, make_plain, shown
from cadet._util.sink import Sink
from cadet.errors import CadetError
from cadet.formats.exporter import Exporter, Place, Split
from cadet.formats.kitti.exporter import KittiExporter
from cadet.formats.kitti_sequences import KittiRawExporter, KittiTrackingExporter
from cadet.formats.nuscenes.exporter import NuscenesExporter
from cadet.formats.parquet import ParquetExporter
from cadet.formats.ros_bags import McapExporter
from cadet.formats.webdataset.exporter import WebdatasetExporter
from cadet.generate.golden_frames import generator
from cadet.generate.object_sink import open_sink
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Wanted
from cadet.worlds.policy import ResetPolicy

FORMAT_VERSION = 2
"""Rises with every change of a dataset's files; `golden_frames.generator` names what frames the same settings give."""
_ALL: Final[tuple[Exporter, ...]] = (
    KittiExporter(),
    KittiTrackingExporter(),
    KittiRawExporter(),
    NuscenesExporter(),
    WebdatasetExporter(),
    ParquetExporter(),
    McapExporter(),
)
EXPORTERS: Final = {exporter.name: exporter for exporter in _ALL}
"""The formats by name."""
EXTRAS = tuple(dict.fromkeys(extra for exporter in _ALL for extra in exporter.extras))
"""Files that some format writes on demand."""
_VAL_EPISODE: Final = 1
_TEST_EPISODE: Final = 2
_LEAST_FRACTION: Final = 1e-6


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Everything that decides a dataset's bytes. Workers, order and resuming don't.

    Raises:
        CadetError: a number outside its range, or what no format writes.
    """

    seed: int = 0
    """Names every random draw."""
    num_frames: int = 20
    """Frames 0 to this; a larger number never changes a frame."""
    policy: ResetPolicy
    """Draws worlds and rigs. A preset's name stands for it when settings are made."""
    rig: InitVar[Rig | None] = None
    """The sensors of every episode, in place of those that the policy draws. Not kept: `policy` then draws this rig."""
    format: str = "kitti"
    """One of `EXPORTERS`."""
    write: tuple[str, ...] = ()
    """What to write besides what every sample of the format has."""
    shard_size: int | None = None
    """Samples of a shard, for a format that has shards; None for its own."""
    val_fraction: float = 0.2
    """Share of the episodes that are validation, 0 to 0.5: the second of every round(1 / val_fraction)."""
    test_fraction: float = 0.0
    """Share of the episodes that are test, 0 to 0.34: the third of every round(1 / test_fraction)."""

    def __post_init__(self, rig: Rig | None) -> None:
        as_seed(self.seed)
        if isinstance(self.policy, str):
            object.__setattr__(self, "policy", ResetPolicy.named(self.policy))
        check_kind("Settings", "policy", self.policy, ResetPolicy)
        if rig is not None:
            object.__setattr__(self, "policy", self.policy.with_rig(rig))
        check_number("Settings", "num_frames", self.num_frames, 1, 1_000_000, whole=True)
        for name, most in (("val_fraction", 0.5), ("test_fraction", 0.34)):
            check_number("Settings", name, getattr(self, name), 0, most)
            if 0.0 < getattr(self, name) < _LEAST_FRACTION:
                least = f"{_LEAST_FRACTION:g}"
                raise CadetError(f"Settings.{name}: expected 0 or at least {least}, got {getattr(self, name):g}")
        object.__setattr__(self, "write", as_tuple("Settings", "write", self.write, "folders' names"))
        if not is_one_of(self.format, EXPORTERS):
            raise CadetError(f"unknown format {shown(self.format)}; {known_names(self.format, EXPORTERS)}")
        if self.exporter.needs_sequence and self.policy.time_step_s is None:
            raise CadetError(f"{self.format}: expected a sequence (--hz, or ResetPolicy.as_sequence)")
        if self.shard_size is not None:
            check_number("Settings", "shard_size", self.shard_size, 1, 10_000, whole=True)
            if not isinstance(EXPORTERS[self.format], WebdatasetExporter):
                raise CadetError(f"Settings.shard_size: the format {self.format} has no shards")
        for extra in self.write:
            if not is_one_of(extra, self.exporter.extras):
                raise CadetError(
                    f"Settings.write: cannot write {shown(extra)}; {known_names(extra, self.exporter.extras)}"
                )
        for rig, _ in self.policy.rigs:
            self.exporter.check(rig, self.write)
        self.exporter.check_size(Counter(map(self.split, range(self.num_episodes))))
        make_plain(self)

    @property
    def exporter(self) -> Exporter:
        """The format."""
        exporter = EXPORTERS[self.format]
        if isinstance(exporter, WebdatasetExporter) and self.shard_size is not None:
            return replace(exporter, shard_size=self.shard_size)
        if isinstance(exporter, NuscenesExporter) and self.policy.time_step_s is not None:
            return exporter.at_time_step(self.policy.time_step_s)
        return exporter

    def open(self, root: str | Path) -> Sink:
        """Return what takes the dataset's files.

        Raises:
            CadetError: no folder and no URL, or one that the format cannot be written to.
        """
        return self.exporter.store(open_sink(root), self.place)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of files that each sample has, besides its record."""
        return self.exporter.kinds([rig for rig, _ in self.policy.rigs], self.write)

    @property
    def wanted(self) -> Wanted:
        """What must be captured of each sample."""
        return self.exporter.wanted([rig for rig, _ in self.policy.rigs], self.write)

    @property
    def unwritten_sensors(self) -> tuple[str, ...]:
        """Names of sensors of the rigs that the format has no room for."""
        wanted = self.wanted.sensors
        names = {mounted.name for rig, _ in self.policy.rigs for mounted in rig.more}
        return () if wanted is None else tuple(sorted(names - {*wanted}))

    @property
    def num_episodes(self) -> int:
        """Episodes begun."""
        return -(-self.num_frames // self.policy.samples_per_episode)

    def num_samples(self, episode: int) -> int:
        """Return how many samples of an episode are wanted: the last one's are cut."""
        per_episode = self.policy.samples_per_episode
        return min(per_episode, self.num_frames - episode * per_episode)

    def place(self, number: int) -> Place:
        """Return which sample of the dataset a number means."""
        episode, sample = divmod(number, self.policy.samples_per_episode)
        rank = self.policy.samples_per_episode * _num_before(episode, *self._periods) + sample
        return Place(number, episode, sample, self.split(episode), rank)

    def places(self) -> Iterator[Place]:
        """Yield every sample's place."""
        return (self.place(number) for number in range(self.num_frames))

    def places_of(self, episode: int) -> list[Place]:
        """Return the places of an episode's samples."""
        first = episode * self.policy.samples_per_episode
        return [self.place(first + sample) for sample in range(self.num_samples(episode))]

    def split(self, episode: int) -> Split:
        """Return the split of an episode: a function of its number alone, so that more frames move none."""
        return _split(episode, *self._periods)

    @property
    def _periods(self) -> tuple[int, int]:
        """Every how many episodes one is validation, and test; 0 for none."""
        val, test = (round(1.0 / share) if share > 0.0 else 0 for share in (self.val_fraction, self.test_fraction))
        return val, test

    def identity(self) -> dict[str, Any]:
        """Return what must not change between a run and its resumption, in plain values: all but `num_frames`."""
        rigs = [rig for rig, _ in self.policy.rigs]
        # Every run was KITTI's once.
        format_name: dict[str, Any] = {} if self.format == "kitti" else {"dataset_format": self.format}
        if isinstance(self.exporter, WebdatasetExporter):
            format_name["shard_size"] = self.exporter.shard_size
        return {
            "format": FORMAT_VERSION,
            **format_name,
            "cadet": _cadet.__version__,
            "generator": generator(),
            "seed": self.seed,
            "write": list(self.kinds),
            "val_fraction": self.val_fraction,
            "test_fraction": self.test_fraction,
            "policy": self.policy.to_dict(),
            "rig": rigs[0].to_dict(),
            "other_rigs": {rig.name: rig.sha256() for rig in rigs[1:]},
        }


def _split(episode: int, val_period: int, test_period: int) -> Split:
    if test_period > 0 and episode % test_period == _TEST_EPISODE:
        return "test"
    return "val" if val_period > 0 and episode % val_period == _VAL_EPISODE else "train"


def _num_before(episode: int, val_period: int, test_period: int) -> int:
    """Count the episodes before one that are of its split."""
    test = _num_below(episode, _TEST_EPISODE, test_period)
    # Of what would be both, test has the precedence.
    val = _num_below(episode, _VAL_EPISODE, val_period) - _num_below(episode, *_both(val_period, test_period))
    return {"test": test, "val": val, "train": episode - test - val}[_split(episode, val_period, test_period)]


def _num_below(end: int, first: int, period: int) -> int:
    """Count the numbers first, first + period, ... that are below `end`; a period of 0 has none."""
    return max(-((first - end) // period), 0) if period > 0 else 0


@lru_cache(maxsize=8)
def _both(val_period: int, test_period: int) -> tuple[int, int]:
    """Return the first episode that is of both kinds, and their common period, 0 if there is none."""
    if not (val_period and test_period):
        return 0, 0
    period = math.lcm(val_period, test_period)
    first = next((k for k in range(_VAL_EPISODE, period, val_period) if k % test_period == _TEST_EPISODE), None)
    return (0, 0) if first is None else (first, period)


def differences(old: object, new: object, path: str = "") -> list[tuple[str, object, object]]:
    """List where two trees of plain values differ: (path, old, new) each."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        keys = sorted({*old, *new})
        return [
            difference
            for key in keys
            for difference in differences(old.get(key), new.get(key), f"{path}.{key}" if path else str(key))
        ]
    return [] if old == new else [(path, old, new)]
