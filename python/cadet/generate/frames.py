"""One frame's files in a dataset: written so that a kill at any moment leaves it whole or recognisably not.

`meta/ID.json` is written last and carries the hashes of its fellows, so a frame is whole if its `meta` is there and
every hash fits.
"""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256

from cadet.errors import CadetError
from cadet.frame import Frame
from cadet.generate.settings import Settings
from cadet.kitti import encode_frame, encode_meta
from cadet.kitti.files import SUFFIXES
from cadet.plain_text import json_from_text
from cadet.sink import Sink

_HASHES = "sha256"


def object_name(settings: Settings, folder: str, frame_id: str) -> str:
    """Name a frame's file of a folder, relative to the dataset's root."""
    return f"{settings.part(frame_id)}/{folder}/{frame_id}{SUFFIXES[folder]}"


def put_frame(sink: Sink, settings: Settings, frame_id: str, frame: Frame) -> None:
    """Write a frame's files, `meta` last."""
    wanted = replace(
        frame,
        meta=None,
        depth=frame.depth if "depth" in settings.extras else None,
        instance=frame.instance if "instance" in settings.extras else None,
        semantic=frame.semantic if "semantic" in settings.extras else None,
    )
    files = encode_frame(wanted)
    hashes = {folder: sha256(data).hexdigest() for folder, data in files.items()}
    for folder, data in files.items():
        sink.put(object_name(settings, folder, frame_id), data)
    sink.put(object_name(settings, "meta", frame_id), encode_meta({**(frame.meta or {}), _HASHES: hashes}))


def is_whole(sink: Sink, settings: Settings, frame_id: str) -> bool:
    """Tell whether every file of a frame is there, to the last byte."""
    try:
        recorded = _recorded(sink.read(object_name(settings, "meta", frame_id)))
        if set(recorded) != set(settings.folders):
            return False
        return all(
            sha256(sink.read(object_name(settings, folder, frame_id))).hexdigest() == digest
            for folder, digest in recorded.items()
        )
    except (FileNotFoundError, ValueError):
        return False


def recorded_hashes(sink: Sink, settings: Settings, frame_id: str) -> dict[str, str]:
    """Return the hashes of a whole frame's files by name, `meta`'s own included.

    Raises:
        CadetError: the frame's `meta` was removed or damaged while the dataset was being written.
    """
    name = object_name(settings, "meta", frame_id)
    try:
        data = sink.read(name)
        hashes = {object_name(settings, folder, frame_id): digest for folder, digest in _recorded(data).items()}
    except (FileNotFoundError, ValueError):
        raise CadetError(f"{name} was changed by another program during the run") from None
    return {**hashes, name: sha256(data).hexdigest()}


def _recorded(meta: bytes) -> dict[str, str]:
    """Return the hashes that a `meta` carries, by folder.

    Raises:
        ValueError: it carries none, or something else in their place.
    """
    try:
        recorded = json_from_text(meta, "meta")[_HASHES]
    except (KeyError, TypeError):
        raise ValueError(f"no {_HASHES}") from None
    if not isinstance(recorded, dict) or not all(isinstance(digest, str) for digest in recorded.values()):
        raise ValueError(f"{_HASHES}: expected text by folder")
    if not set(recorded) <= set(SUFFIXES):
        raise ValueError(f"{_HASHES}: unknown folder")
    return recorded
