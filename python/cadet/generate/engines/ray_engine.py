"""Episodes made as tasks of a Ray cluster, or of a Ray of this machine's own."""

from __future__ import annotations

import os
import re
import signal
import socket
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any, Final

from cadet import _cadet
from cadet._util.extras import load_extra
from cadet._util.sink import Sink
from cadet.errors import CadetError, WorkerError
from cadet.generate.engines.engine import SILENCE_S, Failed, Made
from cadet.generate.engines.worker import make_episode, outcome, prepare
from cadet.generate.folder import RUN
from cadet.generate.settings import Settings

_MOST_DEATHS: Final = 4
"""Nodes that are rented by the minute go more often than processes crash."""
_POLL_S: Final = 1.0
_TASKS_PER_PROCESSOR: Final = 2
"""One runs and one waits, so that processors go on and new nodes find work; more would only fill memory."""
_CONNECT_S: Final = 10.0
_LEAST_STORE_BYTES: Final = 100 * 2**20


class RayEngine:
    """Ray tasks on a dataset's episodes, one processor each; see `Engine`.

    Ray hands a task to whichever processor is free. An episode whose worker or node dies is handed out again, three
    times at most.

    Args:
        root: the dataset's folder, which all nodes must have under this path, or its URL.
        settings: what to make.
        num_workers: most tasks at a time; if None, as many as the cluster has processors.
        address: the cluster's, as `ray.init` takes it; if None, that of `RAY_ADDRESS`, or "local", which starts a Ray
            of this machine's own for the run. Ignored in a program that has called `ray.init` itself.
        num_processors: of a Ray that is started here.
        on_warning: called with a line about each episode that was handed out again, and when none ends for `SILENCE_S`.
    """

    def __init__(
        self,
        root: str,
        settings: Settings,
        num_workers: int | None,
        address: str | None,
        num_processors: int,
        on_warning: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._ray = load_extra("ray", "cluster", "--engine ray")
        self._root = root
        self._settings = settings
        self._num_workers = num_workers
        self._address = address or os.environ.get("RAY_ADDRESS") or "local"
        _check_answers(self._address)
        self._num_processors = num_processors
        self._on_warning = on_warning
        self._is_ours = False
        self._running: dict[Any, int] = {}
        """The episode of each task that was handed out."""

    def frames(self) -> Iterator[Made]:
        """Yield the frames of each episode as it ends."""
        self._connect()
        run = self._ray.remote(num_cpus=1, max_retries=0)(run_episode)
        settings = self._ray.put(self._settings)
        episodes = iter(range(self._settings.num_episodes))
        num_deaths: Counter[int] = Counter()
        last_heard_s = time.monotonic()

        def hand_out(episode: int) -> None:
            task = run.options(name=f"cadet episode {episode}")
            self._running[task.remote(self._root, settings, _cadet.__version__, episode)] = episode

        while True:
            for episode in islice(episodes, max(0, self._most_tasks() - len(self._running))):
                hand_out(episode)
            if not self._running:
                return
            done, _ = self._ray.wait(list(self._running), timeout=_POLL_S)
            for ref in done:
                last_heard_s = time.monotonic()
                episode = self._running.pop(ref)
                frames = self._frames_of(ref, episode, num_deaths)
                if frames is None:
                    hand_out(episode)
                else:
                    yield from frames
            if time.monotonic() - last_heard_s >= SILENCE_S:
                self._on_warning(f"no episode has ended for {SILENCE_S:.0f} s; Ray has {self._cluster()}")
                last_heard_s = time.monotonic()

    def close(self) -> None:
        """Cancel what runs, and end a Ray that was started here."""
        if not self._ray.is_initialized():
            return
        for ref in self._running:
            self._ray.cancel(ref, force=True)
        self._running.clear()
        if self._is_ours:
            self._ray.shutdown()
            self._is_ours = False

    def _connect(self) -> None:
        if self._ray.is_initialized():
            return
        options: dict[str, Any] = {"log_to_driver": False, "logging_level": "error"}
        if self._address == "local":
            # Who runs one command asked for no reports to Ray's makers, no web page, and no third of the memory.
            os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
            options |= {"num_cpus": self._num_workers or self._num_processors, "include_dashboard": False}
            options |= {"object_store_memory": _LEAST_STORE_BYTES}
        # Ray would answer SIGTERM itself.
        is_main = threading.current_thread() is threading.main_thread()
        before = signal.getsignal(signal.SIGTERM)
        try:
            self._ray.init(address=self._address, **options)
        except (OSError, RuntimeError, ValueError) as error:
            raise CadetError(f"no Ray at {self._address!r}: {_first_line(error)}") from None
        finally:
            if is_main:
                signal.signal(signal.SIGTERM, before)
        self._is_ours = True

    def _most_tasks(self) -> int:
        if self._num_workers is not None:
            return self._num_workers
        return max(1, _TASKS_PER_PROCESSOR * int(self._ray.cluster_resources().get("CPU", 0)))

    def _frames_of(self, ref: Any, episode: int, num_deaths: Counter[int]) -> list[Made] | None:
        """Return an episode's frames; None if its worker died and it must be handed out again."""
        errors = self._ray.exceptions
        try:
            ended: list[Made] | Failed = self._ray.get(ref)
        except (errors.RayTaskError, errors.RuntimeEnvSetupError) as error:
            raise WorkerError(f"episode {episode}: {_last_line(error)}") from None
        except errors.RayError as error:
            num_deaths[episode] += 1
            if num_deaths[episode] >= _MOST_DEATHS:
                raise WorkerError(
                    f"a worker died in episode {episode}, as the {_MOST_DEATHS - 1} before it did: {_first_line(error)}"
                ) from None
            self._on_warning(f"a worker died in episode {episode}: another one makes it ({type(error).__name__})")
            return None
        if isinstance(ended, Failed):
            raise ended.error()
        return ended

    def _cluster(self) -> str:
        total, free = self._ray.cluster_resources(), self._ray.available_resources()
        num_nodes = sum(name.startswith("node:") and not name.startswith("node:__") for name in total)
        return f"{num_nodes} nodes, and {free.get('CPU', 0):.0f} of {total.get('CPU', 0):.0f} processors are free"


def _check_answers(address: str) -> None:
    """Refuse an address that nobody listens at; Ray itself would try for minutes.

    Raises:
        CadetError: in one line.
    """
    match = re.fullmatch(r"(?:ray://)?([^:/]+):([0-9]{1,5})", address)
    if match is None:
        return
    try:
        socket.create_connection((match[1], int(match[2])), timeout=_CONNECT_S).close()
    except (OSError, OverflowError) as error:
        raise CadetError(f"no Ray at {address!r}: {error}") from None


def run_episode(root: str, settings: Settings, version: str, episode: int) -> list[Made] | Failed:
    """Make an episode on a node of the cluster, and return its frames."""
    made: list[Made] = []

    def make() -> None:
        _check_version(version)
        make_episode(_open(root, settings), settings, episode, made.append)

    prepare(num_threads=1)
    ended = outcome(episode, make)
    return ended if isinstance(ended, Failed) else made


def _check_version(version: str) -> None:
    if version != _cadet.__version__:
        raise CadetError(
            f"the node {socket.gethostname()} has cadet {_cadet.__version__}, expected {version}, "
            "which the run was started with"
        )


def _open(root: str, settings: Settings) -> Sink:
    """Open the dataset, and see whether this node sees the same one as who has begun it."""
    sink = settings.open(root)
    try:
        sink.read(RUN)
    except FileNotFoundError:
        raise CadetError(
            f"the node {socket.gethostname()} has no {RUN} in {root}: name a folder that all nodes share, or a URL"
        ) from None
    return sink


def _first_line(error: BaseException) -> str:
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[0] if lines else 'no reason given'}"[:300]


def _last_line(error: BaseException) -> str:
    """Return where a traceback of Ray's ends: at the error itself."""
    lines = str(error).strip().splitlines()
    return (lines[-1] if lines else type(error).__name__)[:300]
