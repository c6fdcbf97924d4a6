"""A whole run: folder, engine, image sets, manifest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cadet._util.checks import check_kind, check_number, is_one_of, known_names, shown
from cadet._util.notices import notice
from cadet._util.operating_system import free_memory_gb, num_processors
from cadet.errors import CadetError
from cadet.generate.engines.engine import Engine
from cadet.generate.engines.local_engine import LocalEngine
from cadet.generate.engines.ray_engine import RayEngine
from cadet.generate.folder import open_folder
from cadet.generate.manifest import put_manifest
from cadet.generate.object_sink import is_url, open_sink
from cadet.generate.settings import Settings

ENGINES: Final = ("local", "ray")
"""What makes episodes: processes of this machine, or a Ray cluster."""

_WORKER_GB: Final = 0.37
"""Memory of a worker that has met all designs (docs/measurements/performance.md)."""


@dataclass(frozen=True)
class Summary:
    """What a run did."""

    num_new: int
    """Frames written."""
    num_kept: int
    """Frames that were there already, whole."""
    labels: Counter[str]
    """Labels by type in the whole dataset."""
    num_standing: int = 0
    """Frames of it that were taken while the ego stood."""
    standing_episodes: tuple[int, ...] = ()
    """Episodes of several frames in more than half of which it stood."""
    manifest_sha256: str = ""
    """The hash of `manifest.json`, and with it of the whole dataset."""


def generate(
    root: str | Path,
    settings: Settings,
    *,
    workers: int | None = None,
    engine: str = "local",
    address: str | None = None,
    resume: bool = False,
    on_frame: Callable[[bool], None] = lambda is_new: None,
    on_warning: Callable[[str], None] = lambda text: None,
) -> Summary:
    """Write a dataset. The same settings give the same bytes, whatever else is asked.

    Args:
        root: its folder, or the URL of one: `file://`, or an object store's (`s3://bucket/set`).
        settings: everything that decides its bytes.
        workers: processes; if None, one for each processor of the machine or cluster.
        engine: one of `ENGINES`.
        address: of the Ray cluster; if None, that of `RAY_ADDRESS`, or one of this machine alone.
        resume: go on in a folder that a run with the same settings has left.
        on_frame: called for each frame, with whether it was written or had been there.
        on_warning: called with a line about workers that died and were replaced, or have said nothing for a minute.

    Raises:
        CadetError: a folder that is not empty or holds another run, no labeled object to be found, or no cluster.
        WorkerError: workers died again and again; what they wrote is whole, and `resume` goes on.
        OSError: the folder can't be written.
    """
    check_kind("generate", "settings", settings, Settings)
    if not is_one_of(engine, ENGINES):
        raise CadetError(f"unknown engine {shown(engine)}; {known_names(engine, ENGINES)}")
    if address is not None and engine != "ray":
        raise CadetError("generate.address: only for the engine ray")
    if workers is not None:
        check_number("generate", "workers", workers, 1, 1024, whole=True)
    if names := ", ".join(settings.unwritten_sensors):
        notice([f"{settings.format}: not written: {names} (the format nuscenes has every sensor)"], about="sensors")
    num_new = num_kept = 0
    num_standing: Counter[int] = Counter()
    location = open_sink(root).location
    if not is_url(location):
        # Workers of a cluster are at home in folders of their own.
        location = str(Path(location).absolute())
    made_by = _engine(engine, location, settings, None if workers is None else int(workers), address, on_warning)
    with open_folder(root, settings, resume=resume) as sink:
        try:
            for made in made_by.frames():
                num_new += made.is_new
                num_kept += not made.is_new
                num_standing[settings.place(made.number).episode] += made.is_standing
                on_frame(made.is_new)
        finally:
            made_by.close()
        labels, manifest_sha256 = put_manifest(sink, settings, num_standing.total())
        return Summary(
            num_new,
            num_kept,
            labels,
            num_standing.total(),
            _standing_episodes(settings, num_standing),
            manifest_sha256,
        )


def _standing_episodes(settings: Settings, num_standing: Counter[int]) -> tuple[int, ...]:
    return tuple(sorted(one for one, number in num_standing.items() if 2 * number > settings.num_samples(one) > 1))


def _engine(
    name: str,
    location: str,
    settings: Settings,
    workers: int | None,
    address: str | None,
    on_warning: Callable[[str], None],
) -> Engine:
    if name == "ray":
        return RayEngine(location, settings, workers, address, num_processors(), on_warning)
    workers = num_processors() if workers is None else workers
    count, free_gb = min(workers, settings.num_episodes), free_memory_gb()
    if free_gb is not None and free_gb < count * _WORKER_GB:
        what = f"{count} workers take about {count * _WORKER_GB:.1f} GB of memory, and {free_gb:.1f} GB are free"
        notice([f"{what}: workers={max(1, int(free_gb / _WORKER_GB))} fits"], about="memory")
    return LocalEngine(location, settings, workers, max(1, num_processors() // workers), on_warning)
