"""What differs between operating systems: processors, the signals that end a program, and locks on folders."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

ENDING_SIGNALS: Final = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if isinstance(getattr(signal, name, None), signal.Signals)
)
"""What asks a program to end, besides Ctrl-C."""


class FolderInUseError(Exception):
    """Another process holds the folder."""


def num_processors() -> int:
    """Return how many processors this process may use; where that can't be asked, how many there are."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def free_memory_gb(root: Path = Path("/")) -> float | None:
    """Return how much memory is left for more processes, GB; None where that can't be asked.

    Args:
        root: of the system's files.
    """
    try:
        lines = (root / "proc/meminfo").read_text().splitlines()
        free = [1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:")]
        group = root / "sys/fs/cgroup"
        if (group / "memory.max").is_file() and (most := (group / "memory.max").read_text().strip()) != "max":
            free.append(int(most) - int((group / "memory.current").read_text()))
    except (OSError, ValueError):
        return None
    return min(free) / 1e9 if free else None


@contextlib.contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Let processes that start meanwhile ignore Ctrl-C; Windows has no such mask."""
    if sys.platform == "win32":
        yield
        return
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


@contextlib.contextmanager
def locked_folder(root: Path, lock_file: Path, *, waits: bool = False) -> Iterator[None]:
    """Hold a folder: the lock goes with the process, however it ends.

    Args:
        root: the folder. It is locked itself where that is possible, which no file's replacing changes.
        lock_file: what is locked in its place on Windows; made, with its folder, if it is not there.

        waits: for another process to let it go.

    Raises:
        FolderInUseError: another process holds it.
        OSError: it can't be locked.
    """
    if sys.platform == "win32":
        import msvcrt

        lock_file.parent.mkdir(parents=True, exist_ok=True)
        with lock_file.open("a+b") as file:
            try:
                msvcrt.locking(file.fileno(), msvcrt.LK_LOCK if waits else msvcrt.LK_NBLCK, 1)
            except OSError:
                raise FolderInUseError from None
            yield
        return
    import fcntl

    folder = os.open(root, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX if waits else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(folder)
        raise FolderInUseError from None
    except OSError as error:
        os.close(folder)
        raise OSError(error.errno, f"cannot be locked: {error.strerror}", str(root)) from None
    try:
        yield
    finally:
        os.close(folder)
