"""Episodes made by processes of this machine."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from typing import Final

from cadet._util.interrupts import interrupts_held
from cadet._util.operating_system import ENDING_SIGNALS
from cadet._util.worker_processes import WorkerContext, WorkerProcess
from cadet.errors import WorkerError
from cadet.generate.engines.engine import SILENCE_S, Failed, Made
from cadet.generate.engines.worker import EpisodeDone, work
from cadet.generate.settings import Settings

_MOST_DEATHS: Final = 2
_POLL_S: Final = 1.0


@dataclass
class _Task:
    """An episode that is worked on."""

    episode: int
    num_deaths: int = 0
    """Of workers, in this episode."""
    reported: set[int] = field(default_factory=set)
    """The numbers of the frames that workers have told of."""


class LocalEngine:
    """Worker processes on a dataset's episodes; see `Engine`.

    A worker that dies is replaced, and the new one makes its episode. Another death in the same episode ends the run.

    Args:
        root: the dataset's folder or URL.
        settings: what to make.
        num_workers: processes.
        num_threads: threads of the core in each.
        on_warning: called with a line about each worker that was replaced, or has sent nothing for `SILENCE_S`.
    """

    def __init__(
        self,
        root: str,
        settings: Settings,
        num_workers: int,
        num_threads: int,
        on_warning: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._arguments = (root, settings, num_threads)
        self._on_warning = on_warning
        self._last_heard_s: dict[Connection, float] = {}
        self._episodes = iter(range(settings.num_episodes))
        self._processes: dict[Connection, WorkerProcess] = {}
        self._working_on: dict[Connection, _Task] = {}
        self._num_workers = min(num_workers, settings.num_episodes)

    def frames(self) -> Iterator[Made]:
        """Yield as frames get written or are found whole, until all are."""
        for conn in [self._start() for _ in range(self._num_workers)]:
            self._give_next(conn)
        while self._working_on:
            ready = set(wait(list(self._working_on), timeout=_POLL_S))
            for conn in [conn for conn in self._working_on if conn in ready]:
                self._last_heard_s[conn] = time.monotonic()
                yield from self._hear(conn)
            self._name_silent()

    def close(self) -> None:
        """End the workers: idle ones exit, busy ones are stopped."""
        for conn, process in self._processes.items():
            if conn in self._working_on:
                process.terminate()
            conn.close()
        for process in self._processes.values():
            process.join(timeout=5.0)
            if process.is_alive():
                process.kill()
                process.join()
        self._processes.clear()

    def _start(self) -> Connection:
        context = WorkerContext()
        with interrupts_held():
            ours, theirs = context.Pipe()
            process = context.Process(target=work, args=(theirs, *self._arguments), daemon=True)
            process.start()
            theirs.close()
            self._processes[ours] = process
        return ours

    def _name_silent(self) -> None:
        for conn, task in self._working_on.items():
            silent_s = time.monotonic() - self._last_heard_s[conn]
            if silent_s >= SILENCE_S:
                pid = self._processes[conn].pid
                self._on_warning(f"worker {pid} has not answered for {silent_s:.0f} s, in episode {task.episode}")
                self._last_heard_s[conn] = time.monotonic()

    def _give_next(self, conn: Connection) -> None:
        episode = next(self._episodes, None)
        if episode is None:
            self._working_on.pop(conn, None)
        self._give(conn, None if episode is None else _Task(episode))

    def _give(self, conn: Connection, task: _Task | None) -> None:
        self._last_heard_s[conn] = time.monotonic()
        if task is not None:
            self._working_on[conn] = task
        try:
            conn.send(None if task is None else task.episode)
        except ConnectionError:
            if task is not None:
                self._replace(conn)

    def _hear(self, conn: Connection) -> Iterator[Made]:
        try:
            message = conn.recv()
        except (EOFError, ConnectionError):
            self._replace(conn)
            return
        if isinstance(message, Made):
            reported = self._working_on[conn].reported
            if message.number not in reported:
                reported.add(message.number)
                yield message
        elif isinstance(message, EpisodeDone):
            self._give_next(conn)
        elif isinstance(message, Failed):
            raise message.error()

    def _replace(self, conn: Connection) -> None:
        """Start a worker in a dead one's place, on the same episode."""
        how = self._how_it_died(conn)
        task = self._working_on.pop(conn)
        task.num_deaths += 1
        if task.num_deaths >= _MOST_DEATHS:
            raise WorkerError(f"a worker died {how} in episode {task.episode}, as the one before it did")
        self._on_warning(f"a worker died {how} in episode {task.episode}: another one continues")
        del self._processes[conn], self._last_heard_s[conn]
        conn.close()
        self._give(self._start(), task)

    def _how_it_died(self, conn: Connection) -> str:
        process = self._processes[conn]
        process.join(timeout=5.0)
        code = process.exitcode
        if code is not None and -code in ENDING_SIGNALS:
            # A signal to the whole group is ours to answer: it may come a moment later than to the worker.
            time.sleep(0.5)
        return f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
