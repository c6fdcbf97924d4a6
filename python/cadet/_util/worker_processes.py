"""Worker processes that compute with one thread and do not import the caller's script, which may be a notebook."""

from __future__ import annotations

import contextlib
import os
import pickle
import sys
import threading
from collections.abc import Iterator
from multiprocessing import current_process
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType
from typing import Final

from cadet.errors import CadetError

_NUM_THREADS: Final = ("OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", "OMP_NUM_THREADS")
"""By which OpenBLAS, which most builds of NumPy bring, is told how many threads to start."""
_STARTS: Final = threading.Lock()
"""Held while a process starts: what it is not to see is hidden from this whole process meanwhile."""


def may_start_workers() -> bool:
    """Tell whether this process can have children: the daemons among `multiprocessing`'s can't."""
    return not current_process().daemon


class WorkerProcess(SpawnProcess):
    """A spawned process that knows modules, but not the script that was started."""

    def start(self) -> None:
        """Start it.

        Raises:
            CadetError: it was to be handed what only the script defines, or this process may start none.
        """
        if not may_start_workers():
            raise CadetError(
                "a process that is itself a worker, such as a data loader's, can start none: "
                "pass workers=0 to a stream, and run all else in the main process"
            )
        with _STARTS, _script_hidden(), _openblas_without_threads():
            try:
                super().start()
            except pickle.PicklingError as error:
                text = " ".join(str(error).split())
                raise CadetError(
                    f"workers do not import the script that was started: define what they need in a module ({text})"
                ) from None


class WorkerContext(SpawnContext):
    """What `multiprocessing.get_context` returns, for `WorkerProcess`."""

    Process = WorkerProcess


@contextlib.contextmanager
def _script_hidden() -> Iterator[None]:
    """Let `multiprocessing` find no script that a new process would run again: it would begin the same work."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


@contextlib.contextmanager
def _openblas_without_threads() -> Iterator[None]:
    """Let a new process's NumPy start no threads, which spin for a while, unless the user says how many it may."""
    if any(name in os.environ for name in _NUM_THREADS):
        yield
        return
    os.environ[_NUM_THREADS[0]] = "1"
    try:
        yield
    finally:
        del os.environ[_NUM_THREADS[0]]
