"""Frames made again: one of a dataset alone, or some to compare with those that are there."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from itertools import groupby
from pathlib import Path

from cadet._util.checks import as_seed, check_kind, check_number
from cadet._util.process_map import process_map
from cadet._util.sink import Sink
from cadet.errors import CadetError, FrameExistsError, MissingFileError
from cadet.formats.exporter import Place
from cadet.formats.kitti.exporter import KittiExporter
from cadet.generate.frames import sample_files, samples_at
from cadet.generate.manifest import MANIFEST
from cadet.generate.object_sink import open_sink
from cadet.generate.recipe import Recipe
from cadet.generate.settings import Settings


@dataclass(frozen=True)
class Comparison:
    """What was found of a dataset and its recipe.

    Attributes:
        num_frames: frames that were made again.
        num_files: files of them, and the manifest if the recipe has its hash.
        differing: the names of those that are other bytes than the recipe gives.
        missing: the names of those that are not there.
    """

    num_frames: int
    num_files: int
    differing: tuple[str, ...]
    missing: tuple[str, ...]


def generate_frame(root: str | Path, settings: Settings, frame: int) -> tuple[str, ...]:
    """Write the files of one frame, as the whole dataset has them, and return their names.

    Args:
        root: the folder or URL that they go to; they may not be there yet.
        settings: the dataset's.
        frame: its number. Its episode is driven from the beginning to it.

    Raises:
        CadetError: there is no such frame, or the format keeps frames together: sequences, shards, bags.
        FrameExistsError: one of its files is there.
        OSError: the folder can't be written.
    """
    check_kind("generate_frame", "settings", settings, Settings)
    check_number("", "frame", frame, 0, settings.num_frames - 1, whole=True)
    if not isinstance(settings.exporter, KittiExporter):
        raise CadetError(f"frame: only kitti has all of a frame in files of its own, {settings.format} does not")
    ((place, sample),) = samples_at(settings, [settings.place(frame)])
    files, _ = sample_files(settings, place, sample)
    sink = open_sink(root)
    with sink.held():
        try:
            for name, data in files.items():
                sink.put_new(name, data)
        except FileExistsError:
            raise FrameExistsError(f"{sink.location}/{name} is there: name another folder") from None
        finally:
            sink.remove_partial()
    return tuple(files)


def compare(root: str | Path, recipe: Recipe, *, num_frames: int = 20, seed: int = 0, workers: int = 1) -> Comparison:
    """Make some frames of a dataset again, and compare them with its files, byte for byte.

    Args:
        root: its folder or URL.
        recipe: what it is said to be made from.
        num_frames: how many; all if it has fewer.
        seed: draws which.
        workers: processes.

    Raises:
        MissingFileError: there is no dataset.
        OSError: a file can't be read.
    """
    check_kind("compare", "recipe", recipe, Recipe)
    check_number("compare", "num_frames", num_frames, 1, 1_000_000, whole=True)
    settings = recipe.settings
    sink = settings.open(root)
    if MANIFEST not in sink.names(""):
        raise MissingFileError(f"{sink.location}: no dataset of cadet-gen's: there is no {MANIFEST} in it")
    count = min(num_frames, settings.num_frames)
    chosen = sorted(random.Random(as_seed(seed)).sample(range(settings.num_frames), count))
    places = map(settings.place, chosen)
    episodes = [list(of_episode) for _, of_episode in groupby(places, lambda place: place.episode)]
    wanted = {} if recipe.manifest_sha256 is None else {MANIFEST: recipe.manifest_sha256}
    for hashes in process_map(partial(_hashes, settings), episodes, workers=workers, at_once=1):
        wanted.update(hashes)
    found = {name: _hash_there(sink, name) for name in wanted}
    missing = tuple(name for name, digest in found.items() if digest is None)
    differing = tuple(name for name, digest in found.items() if digest not in (None, wanted[name]))
    return Comparison(count, len(wanted), differing, missing)


def _hash_there(sink: Sink, name: str) -> str | None:
    try:
        return sha256(sink.read(name)).hexdigest()
    except FileNotFoundError:
        return None


def _hashes(settings: Settings, places: Sequence[Place]) -> dict[str, str]:
    """Return the hashes, by name, of all files of some frames of one episode."""
    return {
        name: sha256(data).hexdigest()
        for place, sample in samples_at(settings, places)
        for name, data in sample_files(settings, place, sample)[0].items()
    }
