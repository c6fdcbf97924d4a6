"""Makes whole episodes, in whatever process an engine runs it."""

from __future__ import annotations

import os
import signal
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Final

from cadet._util.sink import Sink
from cadet.errors import CadetError, CadetWarning, InternalError
from cadet.generate.engines.engine import Failed, Made
from cadet.generate.frames import put_sample, samples_at, whole_record
from cadet.generate.settings import Settings

_STANDING_MPS: Final = 0.1


@dataclass(frozen=True)
class EpisodeDone:
    """All frames of the episode are there: the worker waits for the next."""


def prepare(num_threads: int) -> None:
    """Set a process up for episodes, before the core is first used in it."""
    # The core's threads times the workers should be the processors; read when the core first uses them.
    os.environ.setdefault("RAYON_NUM_THREADS", str(num_threads))
    # The process that started this one has said what is to be said of maps.
    warnings.simplefilter("ignore", CadetWarning)


def make_episode(sink: Sink, settings: Settings, episode: int, report: Callable[[Made], None]) -> None:
    """Write the frames of an episode that are not whole yet, reporting each of its frames."""
    places = settings.places_of(episode)
    missing = []
    for place in places:
        record = whole_record(sink, settings, place)
        if record is None:
            missing.append(place)
        else:
            report(Made(place.number, is_new=False, is_standing=_is_standing(record)))
    if missing:
        for place, sample in samples_at(settings, missing):
            record = put_sample(sink, settings, place, sample)
            report(Made(place.number, is_new=True, is_standing=_is_standing(record)))
    settings.exporter.end_episode(sink, places)


def _is_standing(record: dict[str, Any]) -> bool:
    """Tell whether the ego stood: every format's record has its speed."""
    return bool(record["ego_speed_mps"] < _STANDING_MPS)


def outcome(episode: int, make: Callable[[], None]) -> EpisodeDone | Failed:
    """Make an episode and return how it ended: no error but a lost connection to who listens gets out."""
    try:
        make()
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


def work(conn: Connection, root: str, settings: Settings, num_threads: int) -> None:
    """Make the episodes whose numbers come in, until None comes or the parent is gone."""
    # Ctrl-C reaches the whole process group; the parent decides what happens then.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    prepare(num_threads)
    try:
        sink = settings.open(root)
        while (episode := conn.recv()) is not None:
            conn.send(outcome(episode, partial(make_episode, sink, settings, episode, conn.send)))
    except (EOFError, ConnectionError):
        return
