"""MCAP files of ROS 2's messages as an exporter's."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from cadet._util.plain_text import json_from_text
from cadet._util.sink import LocalSink, Sink, read_each
from cadet.errors import CadetError, FileFormatError
from cadet.formats.exporter import Ending, FilesInPlace, Place
from cadet.formats.packing_sink import PackingSink
from cadet.formats.ros_bags.bag_format import MEMBER, BagFormat
from cadet.formats.ros_bags.message_block import Message, bytes_of_block
from cadet.formats.ros_bags.message_types import check_libraries, encoded
from cadet.formats.ros_bags.messages import messages_of, stamp_ns
from cadet.formats.sequences import seen_agents
from cadet.sensors.rig import Rig
from cadet.sensors.sample import Sample, Wanted

_RECORDS: Final = "records"
_RECORD_NAME: Final = re.compile(r"[0-9]{6}\.json")
_MESSAGES: Final = "messages"
_SENSOR_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


class McapExporter(FilesInPlace):
    """A bag for each episode, with all sensors of the rig; see `cadet.formats.exporter.Exporter`."""

    name = "mcap"
    extras: tuple[str, ...] = ()
    base: tuple[str, ...] = (_MESSAGES,)
    needs_sequence = True

    def check(self, rig: Rig, extras: tuple[str, ...]) -> None:
        """Refuse names of sensors that are no names of topics."""
        for name in (*rig.camera_names, *rig.lidar_names):
            if not _SENSOR_NAME.fullmatch(name):
                raise CadetError(
                    f"cannot write the sensor {name!r} of the rig {rig.name}: ROS has letters, digits, and _"
                )

    def wanted(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> Wanted:
        """Return all sensors, and how much of each agent the images show."""
        return Wanted(sensors=None, maps=False, labels=False, shares=True)

    def kinds(self, rigs: Iterable[Rig], extras: tuple[str, ...]) -> tuple[str, ...]:
        """Return the only kind: the messages."""
        return self.base

    def path(self, place: Place, kind: str) -> str:
        """Return a sample's bag and its name there, or the record's."""
        return f"{_RECORDS}/{place.id}.json" if kind == "record" else f"{_bag(place)}/{place.id}{MEMBER}"

    def encode(self, sample: Sample, extras: tuple[str, ...]) -> dict[str, bytes]:
        """Return the messages."""
        messages = [Message(topic, message.__msgtype__, encoded(message)) for topic, message in messages_of(sample)]
        return {_MESSAGES: bytes_of_block(stamp_ns(sample), messages)}

    def record(self, sample: Sample) -> dict[str, Any]:
        """Return what is known of a sample beside its messages."""
        return {
            **sample.origin,
            "time_s": sample.time_s,
            "map": sample.map,
            "weather": sample.weather,
            "rig": sample.rig.name,
            "ego_speed_mps": sample.ego_speed_mps,
            "types": [agent.type for agent, _ in seen_agents(sample)],
        }

    def record_bytes(self, record: Mapping[str, Any]) -> bytes:
        """Return the record as JSON."""
        return (json.dumps(record, separators=(",", ":"), allow_nan=False) + "\n").encode("ascii")

    def written(self, sink: Sink) -> list[int]:
        """Return the numbers of the samples that have a record."""
        return [int(name[:6]) for name in sink.names(_RECORDS) if _RECORD_NAME.fullmatch(name)]

    def store(self, sink: Sink, place_of: Callable[[int], Place]) -> PackingSink:
        """Return what takes samples' messages and holds them in bags.

        Raises:
            CadetError: no folder of this machine, in which messages can wait for their bag; or a library is missing.
        """
        if not isinstance(sink, LocalSink):
            raise CadetError(f"{sink.location}: bags are packed in a folder; copy them to a store when they are done")
        check_libraries()

        def bag_of(member: str) -> str | None:
            number = member.removesuffix(MEMBER)
            return _bag(place_of(int(number))) if number.isdecimal() else None

        return PackingSink(sink, BagFormat(), bag_of)

    def end_episode(self, sink: Sink, places: Iterable[Place]) -> None:
        """Pack the episode's bag, or mend it if it was there."""
        assert isinstance(sink, PackingSink)
        for bag in dict.fromkeys(map(_bag, places)):
            if not sink.pack(bag):
                sink.mend(bag)

    def finish(self, sink: Sink, places: Iterable[Place]) -> Ending:
        """Count the objects."""
        assert isinstance(sink, PackingSink)
        sink.remove_staging()
        names = [self.path(place, "record") for place in places]
        counts: Counter[str] = Counter()
        for name, data in zip(names, read_each(sink, names), strict=True):
            try:
                counts.update(json_from_text(data, name)["types"])
            except FileFormatError:
                raise CadetError(f"{name} was changed by another program during the run") from None
        return Ending({}, counts)


def _bag(place: Place) -> str:
    return f"{place.split}/{place.episode:06d}{BagFormat.suffix}"
