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


def object_name(folder: str, frame_id: str) -> str:
    """Name a frame's file of a folder, relative to the dataset's root."""
    return f"training/{folder}/{frame_id}{SUFFIXES[folder]}"


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
        sink.put(object_name(folder, frame_id), data)
    sink.put(object_name("meta", frame_id), encode_meta({**(frame.meta or {}), _HASHES: hashes}))


def is_whole(sink: Sink, settings: Settings, frame_id: str) -> bool:
    """Tell whether every file of a frame is there, to the last byte."""
    try:
        name = object_name("meta", frame_id)
        recorded = json_from_text(sink.read(name), name)[_HASHES]
        if not isinstance(recorded, dict) or set(recorded) != set(settings.folders):
            return False
        return all(
            sha256(sink.read(object_name(folder, frame_id))).hexdigest() == digest
            for folder, digest in recorded.items()
        )
    except (FileNotFoundError, ValueError, KeyError, TypeError):
        return False


def recorded_hashes(sink: Sink, frame_id: str) -> dict[str, str]:
    """Return the hashes of a whole frame's files by name, `meta`'s own included.

    Raises:
        CadetError: the frame's `meta` was removed or damaged while the dataset was being written.
    """
    name = object_name("meta", frame_id)
    try:
        data = sink.read(name)
        hashes = {
            object_name(folder, frame_id): digest for folder, digest in json_from_text(data, name)[_HASHES].items()
        }
    except (FileNotFoundError, ValueError, KeyError, TypeError, AttributeError):
        raise CadetError(f"{name} was changed by another program during the run") from None
    return {**hashes, name: sha256(data).hexdigest()}
