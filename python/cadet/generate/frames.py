"""One sample's files in a dataset: written so that a kill at any moment leaves it whole or recognizably incomplete.

The record is written last and carries the hashes of the others and of itself, so a sample is whole if its record is
there and every hash fits.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from hashlib import sha256
from typing import Any

from cadet._util.plain_text import json_from_text
from cadet._util.sink import Sink
from cadet.errors import CadetError
from cadet.formats.exporter import Place
from cadet.formats.record_seal import BLANK, SEAL, is_intact, sealed
from cadet.generate.settings import Settings
from cadet.sensors.sample import Sample
from cadet.simulation.episode import Episode

_HASHES = "sha256"


def samples_at(settings: Settings, places: Sequence[Place]) -> Iterator[tuple[Place, Sample]]:
    """Drive an episode to the last of some of its places, and yield each with its sample.

    Driving leads from view to view, so what lies between them is seen too.
    """
    views = Episode(settings.policy, settings.seed, places[0].episode, wanted=settings.wanted)
    wanted = {place.sample: place for place in places}
    for number in range(places[-1].sample + 1):
        sample = views.next_sample(number)
        if number in wanted:
            yield wanted[number], sample


def sample_files(settings: Settings, place: Place, sample: Sample) -> tuple[dict[str, bytes], dict[str, Any]]:
    """Return a sample's files by name, the record's last, and the record."""
    exporter = settings.exporter
    files = exporter.encode(sample, settings.write)
    hashes = {kind: sha256(data).hexdigest() for kind, data in files.items()}
    record = {**exporter.record(sample), _HASHES: {**hashes, SEAL: BLANK}}
    named = {exporter.path(place, kind): data for kind, data in files.items()}
    return {**named, exporter.path(place, "record"): sealed(exporter.record_bytes(record))}, record


def put_sample(sink: Sink, settings: Settings, place: Place, sample: Sample) -> dict[str, Any]:
    """Write a sample's files, the record last, and return the record."""
    files, record = sample_files(settings, place, sample)
    last = files.popitem()
    sink.put_all(files)
    sink.put(*last)
    return record


def whole_record(sink: Sink, settings: Settings, place: Place) -> dict[str, Any] | None:
    """Return a sample's record if every file of it, the record too, is there to the last byte; else None."""
    path = settings.exporter.path
    try:
        record, hashes = _parsed(sink.read(path(place, "record")), settings)
        if set(hashes) != set(settings.kinds):
            return None
        found = sink.read_all([path(place, kind) for kind in hashes])
    except (FileNotFoundError, ValueError):
        return None
    is_whole = all(sha256(data).hexdigest() == digest for data, digest in zip(found, hashes.values(), strict=True))
    return record if is_whole else None


def recorded_hashes(settings: Settings, place: Place, data: bytes) -> dict[str, str]:
    """Return the hashes of a whole sample's files by name, the record's own included.

    Args:
        settings: the dataset's.
        place: the sample's.
        data: its record.

    Raises:
        CadetError: the record was damaged while the dataset was being written.
    """
    path = settings.exporter.path
    name = path(place, "record")
    try:
        hashes = {path(place, kind): digest for kind, digest in _parsed(data, settings)[1].items()}
    except ValueError:
        raise CadetError(f"{name} was changed by another program during the run") from None
    return {**hashes, name: sha256(data).hexdigest()}


def _parsed(data: bytes, settings: Settings) -> tuple[dict[str, Any], dict[str, str]]:
    """Return a record, and the hashes that it carries of other files, by their kind.

    Raises:
        ValueError: it is not as it was written, or no record.
    """
    record = json_from_text(data, "record")
    hashes = dict(record[_HASHES]) if isinstance(record, dict) and isinstance(record.get(_HASHES), dict) else {}
    if not is_intact(data, hashes.pop(SEAL, None)):
        raise ValueError("not as it was written")
    if not set(hashes) <= {*settings.kinds, *settings.exporter.extras}:
        raise ValueError(f"{_HASHES}: unknown kind of file")
    return record, hashes
