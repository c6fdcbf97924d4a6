"""Tar shards of KITTI's files as an exporter's."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import tee
from typing import Any

from cadet._util.sink import LocalSink, Sink, read_each
from cadet.errors import CadetError
from cadet.formats.exporter import Ending, Finished, Place, Split
from cadet.formats.kitti.exporter import KittiExporter, ending
from cadet.formats.packing_sink import ArchiveFormat, PackingSink
from cadet.formats.webdataset.dataset_card import CARD, dataset_card
from cadet.formats.webdataset.member_names import member_name, parse_member_name
from cadet.formats.webdataset.shard_format import ShardFormat
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Sample, Wanted

SHARD_SIZE = 1000
"""Samples of a shard, if nothing else is asked for: some 2 GB of KITTI's rig."""
_KITTI = KittiExporter()


@dataclass
class WebdatasetExporter:
    """Shards for each split, whose members are the files of a KITTI folder; see `cadet.formats.exporter.Exporter`."""

    shard_size: int = SHARD_SIZE
    """Samples of each shard but a split's last."""
    name: str = "webdataset"
    extras: tuple[str, ...] = _KITTI.extras
    base: tuple[str, ...] = _KITTI.base
    needs_sequence: bool = False

    def check(self, rig: Rig, extras: tuple[str, ...]) -> None:
        """Refuse what KITTI's exporter refuses."""
        _KITTI.check(rig, extras)

    def check_size(self, num_episodes: Mapping[Split, int]) -> None:
        """Refuse what KITTI's exporter refuses."""
        _KITTI.check_size(num_episodes)

    def wanted(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> Wanted:
        """Return what the files need."""
        return _KITTI.wanted(rigs, extras)

    def kinds(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> tuple[str, ...]:
        """Return the kinds of files."""
        return _KITTI.kinds(rigs, extras)

    def path(self, place: Place, kind: str) -> str:
        """Return a file's shard and its name there."""
        return f"{self.shard(place)}/{member_name(place.id, 'meta' if kind == 'record' else kind)}"

    def shard(self, place: Place) -> str:
        """Return the shard of a sample."""
        return f"{place.split}/{place.rank // self.shard_size:06d}.tar"

    def shards(self, split: Split) -> str:
        """Return a pattern of the shards of a split."""
        return f"{split}/*.tar"

    def columns(self, kinds: Iterable[str]) -> str:
        """Return what a sample holds, for the dataset's card."""
        names = (f"`{member_name('0', kind).removeprefix('0.')}`" for kind in (*kinds, "meta"))
        return f"KITTI's files, by their kind: {', '.join(names)}."

    def archives(self) -> ArchiveFormat:
        """Return what shards are written by."""
        return ShardFormat()

    def encode(self, sample: Sample, extras: tuple[str, ...]) -> dict[str, bytes]:
        """Return the files by kind, byte for byte KITTI's."""
        return _KITTI.encode(sample, extras)

    def record(self, sample: Sample) -> dict[str, Any]:
        """Return the `meta` of a sample."""
        return _KITTI.record(sample)

    def record_bytes(self, record: Mapping[str, Any]) -> bytes:
        """Return the `meta` file."""
        return _KITTI.record_bytes(record)

    def store(self, sink: Sink, place_of: Callable[[int], Place]) -> PackingSink:
        """Return what takes samples' files and holds them in shards.

        Raises:
            CadetError: no folder of this machine, in which files can wait for their shard.
        """
        if not isinstance(sink, LocalSink):
            raise CadetError(f"{sink.location}: shards are packed in a folder; copy them to a store when they are done")

        def shard_of(member: str) -> str | None:
            parsed = parse_member_name(member)
            return None if parsed is None else self.shard(place_of(int(parsed[0])))

        return PackingSink(sink, self.archives(), shard_of)

    def end_episode(self, sink: Sink, places: Iterable[Place]) -> None:
        """Pack the shards that an episode has filled."""
        assert isinstance(sink, PackingSink)
        for shard in dict.fromkeys(self.shard(place) for place in places):
            sink.pack(shard, lambda names: sum(map(_is_record, names)) >= self.shard_size)

    def written(self, sink: Sink) -> set[int]:
        """Return the numbers of the samples of which something lies in a shard or aside."""
        assert isinstance(sink, PackingSink)
        parsed = map(parse_member_name, sink.member_names())
        return {int(name[0]) for name in parsed if name is not None}

    def finish(self, sink: Sink, places: Iterable[Place]) -> Ending:
        """Pack what is left, and return `ImageSets` and the number of labels."""
        assert isinstance(sink, PackingSink)
        for shard in sink.archives():
            sink.pack(shard)
            sink.mend(shard)
        sink.remove_staging()
        places, same = tee(places)
        return ending(places, read_each(sink, (self.path(place, "label_2") for place in same)))

    def describe(self, dataset: Finished) -> dict[str, bytes]:
        """Return the dataset's card."""
        shards = {split: self.shards(split) for split in dataset.splits}
        return {CARD: dataset_card(dataset.head, shards, self.columns(dataset.kinds), dataset.recipe)}


def _is_record(member: str) -> bool:
    parsed = parse_member_name(member)
    return parsed is not None and parsed[1] == "meta"
