"""The files that a dataset ends with: `ImageSets` and `manifest.json`."""

from __future__ import annotations

import errno
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from hashlib import sha256
from typing import Any

from cadet.generate.frames import object_name, recorded_hashes
from cadet.generate.settings import Settings
from cadet.kitti import ImageSet
from cadet.kitti.files import REQUIRED
from cadet.sink import Sink

MANIFEST = "manifest.json"
_NOT_ALLOWED = (errno.EROFS, errno.EACCES, errno.EPERM)


def put_manifest(sink: Sink, settings: Settings) -> Counter[str]:
    """Write the image sets and the manifest of a dataset whose frames are all there.

    The manifest holds no time, host, path or worker count: the same settings give the same bytes.

    Returns:
        How many labels of each type there are.
    """
    hashes: dict[str, str] = {}
    for split, image_set in _image_sets(settings).items():
        data = image_set.to_text().encode("ascii")
        name = f"ImageSets/{split}.txt"
        _put_unless_same(sink, name, lambda data=data: data)  # type: ignore[misc]
        hashes[name] = sha256(data).hexdigest()
    # Tools of others list these folders, be there a test frame or none.
    for folder in REQUIRED:
        sink.make_folder(f"testing/{folder}")
    types: Counter[str] = Counter()
    for frame_id in _frame_ids(settings):
        lines = sink.read(object_name(settings, "label_2", frame_id)).decode("ascii").splitlines()
        types.update(line.split(" ", 1)[0] for line in lines)
    head = {
        **settings.identity(),
        "counts": {
            "frames": settings.num_frames,
            "episodes": settings.num_episodes,
            "labels": dict(sorted(types.items())),
        },
    }
    _put_unless_same(sink, MANIFEST, lambda: _chunks(head, hashes, sink, settings))
    return types


def _put_unless_same(sink: Sink, name: str, make: Callable[[], bytes | Iterator[bytes]]) -> None:
    """Write an object; where that is not allowed, see whether it is there already: a whole set may be only to read."""
    try:
        sink.put(name, make())
    except OSError as error:
        made = make()
        if error.errno not in _NOT_ALLOWED or not _is_there(sink, name, [made] if isinstance(made, bytes) else made):
            raise


def _is_there(sink: Sink, name: str, wanted: Iterable[bytes]) -> bool:
    try:
        there = memoryview(sink.read(name))
    except OSError:
        return False
    at = 0
    for chunk in wanted:
        if there[at : at + len(chunk)] != chunk:
            return False
        at += len(chunk)
    return at == len(there)


def _chunks(head: dict[str, Any], hashes: dict[str, str], sink: Sink, settings: Settings) -> Iterator[bytes]:
    """Yield the manifest frame by frame, so that its size does not bound the dataset's."""
    yield json.dumps(head, indent=1, allow_nan=False)[:-2].encode("ascii") + b',\n "sha256": {\n'
    yield _lines(hashes)
    for frame_id in _frame_ids(settings):
        yield b",\n" + _lines(recorded_hashes(sink, settings, frame_id))
    yield b"\n }\n}\n"


def _lines(hashes: dict[str, str]) -> bytes:
    return ",\n".join(f'  "{name}": "{digest}"' for name, digest in hashes.items()).encode("ascii")


def _frame_ids(settings: Settings) -> Iterator[str]:
    return (f"{number:06d}" for number in range(settings.num_frames))


def _image_sets(settings: Settings) -> dict[str, ImageSet]:
    ids: dict[str, list[str]] = {"train": [], "val": [], "trainval": [], "test": []}
    for episode in range(settings.num_episodes):
        members = [settings.frame_id(episode, sample) for sample in range(settings.num_samples(episode))]
        split = settings.split(episode)
        ids[split] += members
        if split != "test":
            ids["trainval"] += members
    return {split: ImageSet(tuple(members)) for split, members in ids.items()}
