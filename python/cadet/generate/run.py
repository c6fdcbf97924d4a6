"""A whole run: folder, workers, image sets, manifest."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cadet.checks import as_path, check_kind, check_number
from cadet.generate.folder import open_folder
from cadet.generate.manifest import put_manifest
from cadet.generate.pool import Pool
from cadet.generate.settings import Settings


@dataclass(frozen=True)
class Summary:
    """What a run did."""

    num_new: int
    """Frames written."""
    num_kept: int
    """Frames that were there already, whole."""
    labels: Counter[str]
    """Labels by type in the whole dataset."""


def num_processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0))


def generate(
    root: str | Path,
    settings: Settings,
    *,
    workers: int | None = None,
    resume: bool = False,
    on_frame: Callable[[bool], None] = lambda is_new: None,
    on_silence: Callable[[str], None] = lambda text: None,
) -> Summary:
    """Write a dataset. The same settings give the same bytes, whatever else is asked.

    Args:
        root: its folder.
        settings: everything that decides its bytes.
        workers: processes; one for each processor if None.
        resume: go on in a folder that a run with the same settings has left.
        on_frame: called for each frame, with whether it was written or had been there.
        on_silence: called with a line about each worker that has said nothing for a minute.

    Raises:
        CadetError: a folder that is not empty or holds another run, or no labeled object to be found.
        WorkerError: a worker died; what it wrote is whole, and `resume` goes on.
        OSError: the folder can't be written.
    """
    check_kind("generate", "settings", settings, Settings)
    folder = as_path("root", root)
    workers = num_processors() if workers is None else workers
    check_number("generate", "workers", workers, 1, 1024, whole=True)
    workers = int(workers)
    num_new = num_kept = 0
    with open_folder(folder, settings, resume=resume) as sink:
        pool = Pool(folder.absolute(), settings, workers, max(1, num_processors() // workers), on_silence)
        try:
            for made in pool.frames():
                num_new += made.is_new
                num_kept += not made.is_new
                on_frame(made.is_new)
        finally:
            pool.close()
        return Summary(num_new, num_kept, put_manifest(settings.exporter.store(sink, settings.place), settings))
