"""What a dataset's format must be able to do; `kitti`, `kitti_sequences`, `nuscenes`, `ros_bags` hold some."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, TypeAlias

from cadet._util.sink import Sink
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Sample, Wanted

Split: TypeAlias = Literal["train", "val", "test"]


@dataclass(frozen=True)
class Place:
    """The place of a sample in a dataset."""

    number: int
    """Of all samples, from 0; six digits name its files."""
    episode: int
    """The episode."""
    sample: int
    """The sample within the episode."""
    split: Split
    """The episode's split."""
    rank: int
    """Of the samples of its split, from 0."""

    @property
    def id(self) -> str:
        """The number as six digits."""
        return f"{self.number:06d}"


@dataclass(frozen=True)
class Ending:
    """What a dataset ends with, once all samples are there."""

    files: Mapping[str, bytes]
    """Lists or tables by name, in the order in which they are written."""
    labels: Counter[str]
    """Labeled objects by type."""
    folders: tuple[str, ...] = field(default=())
    """Folders that must be there, be they empty or not."""


@dataclass(frozen=True)
class Finished:
    """A dataset whose files are all there, for those who describe it."""

    head: Mapping[str, Any]
    """What `manifest.json` says besides the hashes of files."""
    manifest_sha256: str
    """Its own hash, in hexadecimal digits."""
    kinds: tuple[str, ...]
    """Kinds of files that a sample has."""
    splits: tuple[Split, ...]
    """Those that hold samples."""
    recipe: str | None
    """The text of its recipe; None where files of the user's are needed to make it."""


class FilesInPlace:
    """What exporters do whose files lie in the dataset's folder as they are."""

    def check_size(self, num_episodes: Mapping[Split, int]) -> None:
        """Refuse nothing."""

    def store(self, sink: Sink, place_of: Callable[[int], Place]) -> Sink:
        """Return the folder as it is."""
        return sink

    def end_episode(self, sink: Sink, places: Iterable[Place]) -> None:
        """Do nothing: each sample stands for itself."""

    def describe(self, dataset: Finished) -> dict[str, bytes]:
        """Return nothing."""
        return {}


class Exporter(Protocol):
    """A format. Every sample has some files and one record, which is written last and carries their hashes."""

    name: str
    """The value of `--format`."""
    extras: tuple[str, ...]
    """Kinds of files that are written on demand."""
    base: tuple[str, ...]
    """Kinds of files that every sample has on every rig."""
    needs_sequence: bool
    """Whether the samples of an episode must follow each other by time."""

    def check(self, rig: Rig, extras: tuple[str, ...]) -> None:
        """Refuse a rig that the format, or what was asked for, has no use for.

        Raises:
            CadetError: in one line.
        """

    def check_size(self, num_episodes: Mapping[Split, int]) -> None:
        """Refuse more episodes of a split than the format has room for.

        Raises:
            CadetError: in one line.
        """

    def wanted(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> Wanted:
        """Return what must be captured, the same of all rigs."""

    def kinds(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> tuple[str, ...]:
        """Return the kinds of files that a sample has."""

    def path(self, place: Place, kind: str) -> str:
        """Return a file's name, relative to the dataset's root; of the record where the kind is "record"."""

    def encode(self, sample: Sample, extras: tuple[str, ...]) -> dict[str, bytes]:
        """Return a sample's files by kind."""

    def record(self, sample: Sample) -> dict[str, Any]:
        """Return what the record says of a sample, besides the hashes: plain values."""

    def record_bytes(self, record: Mapping[str, Any]) -> bytes:
        """Return the record as it is written."""

    def written(self, sink: Sink) -> Iterable[int]:
        """Return the numbers of the samples of which something lies in a dataset."""

    def store(self, sink: Sink, place_of: Callable[[int], Place]) -> Sink:
        """Return what takes the files: the dataset's folder itself, where a name of `path` is that of a file.

        Raises:
            CadetError: the format cannot be written to such a store.
        """

    def end_episode(self, sink: Sink, places: Iterable[Place]) -> None:
        """Do what is to be done once the samples of an episode are whole, in the process that made them."""

    def finish(self, sink: Sink, places: Iterable[Place]) -> Ending:
        """Return what the dataset ends with, from the records and files that are there."""

    def describe(self, dataset: Finished) -> dict[str, bytes]:
        """Return descriptions of the whole dataset by name, for those who look at it without reading it."""
