"""One sample's files in a dataset: written so that a kill at any moment leaves it whole or recognizably incomplete.

The record is written last and carries the hashes of the others, so a sample is whole if its record is there and every
hash fits.
"""

from __future__ import annotations

from hashlib import sha256

from cadet.errors import CadetError
from cadet.exporter import Place
from cadet.generate.settings import Settings
from cadet.plain_text import json_from_text
from cadet.sample import Sample
from cadet.sink import Sink

_HASHES = "sha256"


def put_sample(sink: Sink, settings: Settings, place: Place, sample: Sample) -> None:
    """Write a sample's files, the record last."""
    exporter = settings.exporter
    files = exporter.encode(sample, settings.extras)
    hashes = {kind: sha256(data).hexdigest() for kind, data in files.items()}
    sink.put_all({exporter.path(place, kind): data for kind, data in files.items()})
    record = {**exporter.record(sample), _HASHES: hashes}
    sink.put(exporter.path(place, "record"), exporter.record_bytes(record))


def is_whole(sink: Sink, settings: Settings, place: Place) -> bool:
    """Tell whether every file of a sample is there, to the last byte."""
    path = settings.exporter.path
    try:
        recorded = _recorded(sink.read(path(place, "record")), settings)
        if set(recorded) != set(settings.kinds):
            return False
        found = sink.read_all([path(place, kind) for kind in recorded])
        return all(sha256(data).hexdigest() == digest for data, digest in zip(found, recorded.values(), strict=True))
    except (FileNotFoundError, ValueError):
        return False


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
        hashes = {path(place, kind): digest for kind, digest in _recorded(data, settings).items()}
    except ValueError:
        raise CadetError(f"{name} was changed by another program during the run") from None
    return {**hashes, name: sha256(data).hexdigest()}


def _recorded(record: bytes, settings: Settings) -> dict[str, str]:
    """Return the hashes that a record carries, by the kind of file.

    Raises:
        ValueError: it carries none, or something else in their place.
    """
    try:
        recorded = json_from_text(record, "record")[_HASHES]
    except (KeyError, TypeError):
        raise ValueError(f"no {_HASHES}") from None
    if not isinstance(recorded, dict) or not all(isinstance(digest, str) for digest in recorded.values()):
        raise ValueError(f"{_HASHES}: expected text by kind of file")
    if not set(recorded) <= {*settings.kinds, *settings.exporter.extras}:
        raise ValueError(f"{_HASHES}: unknown kind of file")
    return recorded
