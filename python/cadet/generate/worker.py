"""A process that makes whole episodes."""

from __future__ import annotations

import os
import signal
import warnings
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from cadet.episode import Episode
from cadet.errors import CadetError, CadetWarning, InternalError
from cadet.generate.frames import is_whole, put_sample
from cadet.generate.settings import Settings
from cadet.sink import LocalSink, Sink


@dataclass(frozen=True)
class Made:
    """A frame was written, or found whole."""

    is_new: bool


@dataclass(frozen=True)
class EpisodeDone:
    """All frames of the episode are there: the worker waits for the next."""


@dataclass(frozen=True)
class Failed:
    """The worker gives up."""

    message: str
    """One line."""
    is_users: bool
    """Whether the user can fix it: settings, disk. Otherwise it is a bug of ours."""


def make_episode(sink: Sink, settings: Settings, episode: int, conn: Connection) -> None:
    """Write the frames of an episode that are not whole yet, telling `conn` of each."""
    places = settings.places_of(episode)
    missing = [place.sample for place in places if not is_whole(sink, settings, place)]
    for _ in range(len(places) - len(missing)):
        conn.send(Made(is_new=False))
    if missing:
        _make_samples(sink, settings, episode, missing, conn)
    settings.exporter.end_episode(sink, places)


def _make_samples(sink: Sink, settings: Settings, episode: int, missing: list[int], conn: Connection) -> None:
    places = settings.places_of(episode)
    views = Episode(settings.policy, settings.seed, episode, wanted=settings.exporter.wanted(settings.extras))
    # Driving leads from view to view, so frames that are there already are seen again, but not written.
    for number in range(missing[-1] + 1):
        sample = views.next_sample(number)
        if number in missing:
            put_sample(sink, settings, places[number], sample)
            conn.send(Made(is_new=True))


def work(conn: Connection, root: Path, settings: Settings, num_threads: int) -> None:
    """Make the episodes whose numbers come in, until None comes or the parent is gone."""
    # Ctrl-C reaches the whole process group; the parent decides what happens then.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # The core's threads times the workers should be the processors; read when the core first uses them.
    os.environ.setdefault("RAYON_NUM_THREADS", str(num_threads))
    # The process that started this one has said what is to be said of maps.
    warnings.simplefilter("ignore", CadetWarning)
    sink = settings.exporter.store(LocalSink(root), settings.place)
    try:
        while (episode := conn.recv()) is not None:
            conn.send(_outcome(sink, settings, episode, conn))
    except (EOFError, ConnectionError):
        return


def _outcome(sink: Sink, settings: Settings, episode: int, conn: Connection) -> EpisodeDone | Failed:
    try:
        make_episode(sink, settings, episode, conn)
    except ConnectionError:
        raise
    except InternalError as error:
        return Failed(f"{error} (episode {episode})", is_users=False)
    except CadetError as error:
        return Failed(str(error), is_users=True)
    except OSError as error:
        text = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        return Failed(text, is_users=True)
    except BaseException as error:  # noqa: BLE001 - a panic of the core is none of Exception's kind
        text = " ".join(str(error).split()) or "no message"
        return Failed(f"{type(error).__name__} in episode {episode}: {text}", is_users=False)
    return EpisodeDone()
