"""The files that a dataset ends with: the format's lists or tables, `manifest.json`, recipe, and description."""

from __future__ import annotations

import errno
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from hashlib import sha256
from typing import Any, get_args

from cadet._util.sink import Sink, read_each
from cadet.errors import CadetError
from cadet.formats.exporter import Finished, Split
from cadet.generate.frames import recorded_hashes
from cadet.generate.recipe import RECIPE, Recipe, is_recipe_of
from cadet.generate.settings import Settings

MANIFEST = "manifest.json"
_NOT_ALLOWED = (errno.EROFS, errno.EACCES, errno.EPERM)


def put_manifest(sink: Sink, settings: Settings, num_standing: int) -> tuple[Counter[str], str]:
    """Write the lists or tables, the manifest, recipe, and description of a dataset whose frames are all there.

    The manifest holds no time, host, path or worker count: the same settings give the same bytes.

    Args:
        sink: where the frames are.
        settings: what they were made from.
        num_standing: how many of them were taken while the ego stood.

    Returns:
        How many labels of each type there are, and the manifest's hash.

    Raises:
        CadetError: a file was removed or damaged while the dataset was being written.
        OSError: one can't be read or written.
    """
    try:
        return _put_ending(sink, settings, num_standing)
    except FileNotFoundError as error:
        raise CadetError(f"{error.filename} was removed by another program during the run") from None


def _put_ending(sink: Sink, settings: Settings, num_standing: int) -> tuple[Counter[str], str]:
    ending = settings.exporter.finish(sink, settings.places())
    hashes: dict[str, str] = {}
    for name, data in ending.files.items():
        _put_unless_same(sink, name, lambda data=data: data)  # type: ignore[misc]
        hashes[name] = sha256(data).hexdigest()
    for folder in ending.folders:
        sink.make_folder(folder)
    head = {
        **settings.identity(),
        "counts": {
            "frames": settings.num_frames,
            "episodes": settings.num_episodes,
            "standing": num_standing,
            "labels": dict(sorted(ending.labels.items())),
        },
    }
    _put_unless_same(sink, MANIFEST, lambda: _chunks(head, hashes, sink, settings))
    digest = sha256(sink.read(MANIFEST)).hexdigest()
    recipe = Recipe(settings, digest).to_toml() if is_recipe_of(settings) else None
    if recipe is not None:
        _put_unless_same(sink, RECIPE, lambda: recipe.encode("utf-8"))
    found = set(map(settings.split, range(settings.num_episodes)))
    splits = tuple(split for split in get_args(Split) if split in found)
    dataset = Finished(head, digest, settings.kinds, splits, recipe)
    for name, data in settings.exporter.describe(dataset).items():
        _put_unless_same(sink, name, lambda data=data: data)  # type: ignore[misc]
    return ending.labels, digest


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
    lead = json.dumps(head, indent=1, allow_nan=False)[:-2].encode("ascii") + b',\n "sha256": {\n'
    if hashes:
        yield lead + _lines(hashes)
        lead = b",\n"
    records = read_each(sink, (settings.exporter.path(place, "record") for place in settings.places()))
    for place, record in zip(settings.places(), records, strict=True):
        yield lead + _lines(recorded_hashes(settings, place, record))
        lead = b",\n"
    yield b"\n }\n}\n"


def _lines(hashes: dict[str, str]) -> bytes:
    return ",\n".join(f'  "{name}": "{digest}"' for name, digest in hashes.items()).encode("ascii")
