"""Hands episodes to worker processes and collects reports of their frames."""

from __future__ import annotations

import contextlib
import multiprocessing
import signal
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Final

from cadet.errors import CadetError
from cadet.generate.settings import Settings
from cadet.generate.worker import EpisodeDone, Failed, Made, work

SILENCE_S: Final = 60.0
"""A worker that says nothing for so long is named."""
_POLL_S: Final = 1.0


class WorkerError(CadetError):
    """A worker died or met a bug; the frames written so far are whole."""


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """Hold Ctrl-C back while processes start: they ignore it from their start, and the parent handles it afterwards."""
    # Its own start would let interrupts through.
    resource_tracker.ensure_running()
    held: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    # Blocked signals may still come by way of another thread.
    before = signal.signal(signal.SIGINT, lambda number, _: held.append(number)) if is_main else None
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if is_main:
            signal.signal(signal.SIGINT, before)
    if held and callable(before):
        before(signal.SIGINT, None)


class Pool:
    """Worker processes on a dataset's episodes.

    Args:
        root: the dataset's folder.
        settings: what to make.
        num_workers: processes.
        num_threads: threads of the core in each.
        on_silence: called with a line about a worker that has sent nothing for `SILENCE_S`, repeated after as long.
    """

    def __init__(
        self,
        root: Path,
        settings: Settings,
        num_workers: int,
        num_threads: int,
        on_silence: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._on_silence = on_silence
        self._last_heard_s: dict[Connection, float] = {}
        self._episodes = iter(range(settings.num_episodes))
        self._processes: dict[Connection, SpawnProcess] = {}
        self._working_on: dict[Connection, int] = {}
        context = multiprocessing.get_context("spawn")
        with interrupts_held():
            for _ in range(min(num_workers, settings.num_episodes)):
                ours, theirs = context.Pipe()
                process = context.Process(target=work, args=(theirs, root, settings, num_threads), daemon=True)
                process.start()
                theirs.close()
                self._processes[ours] = process

    def frames(self) -> Iterator[Made]:
        """Yield as frames get written or are found whole, until all are.

        Raises:
            CadetError: a worker met what the user can fix.
            WorkerError: a worker died or met a bug.
        """
        for conn in list(self._processes):
            self._give(conn)
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

    def _name_silent(self) -> None:
        for conn, episode in self._working_on.items():
            silent_s = time.monotonic() - self._last_heard_s[conn]
            if silent_s >= SILENCE_S:
                pid = self._processes[conn].pid
                self._on_silence(f"worker {pid} has not answered for {silent_s:.0f} s, in episode {episode}")
                self._last_heard_s[conn] = time.monotonic()

    def _give(self, conn: Connection) -> None:
        self._last_heard_s[conn] = time.monotonic()
        episode = next(self._episodes, None)
        if episode is None:
            self._working_on.pop(conn, None)
        else:
            self._working_on[conn] = episode
        try:
            conn.send(episode)
        except ConnectionError:
            self._report_death(conn)

    def _hear(self, conn: Connection) -> Iterator[Made]:
        try:
            message = conn.recv()
        except (EOFError, ConnectionError):
            self._report_death(conn)
        if isinstance(message, Made):
            yield message
        elif isinstance(message, EpisodeDone):
            self._give(conn)
        elif isinstance(message, Failed):
            raise CadetError(message.message) if message.is_users else WorkerError(message.message)

    def _report_death(self, conn: Connection) -> None:
        process = self._processes[conn]
        process.join(timeout=5.0)
        code = process.exitcode
        if code in (-signal.SIGTERM, -signal.SIGHUP):
            # A signal to the whole group is ours to answer: it may come a moment later than to the worker.
            time.sleep(0.5)
        how = f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
        raise WorkerError(f"a worker died {how} in episode {self._working_on.get(conn, 0)}")
