"""Runs a target on made-up inputs in a child process with limits on time and memory, and tells what went wrong."""

from __future__ import annotations

import os
import random
import resource
import signal
import struct
import sys
import time
import traceback
import warnings
from dataclasses import dataclass

from cadet.errors import CadetError, CadetWarning
from fuzz.target import Input, Target

SECONDS_AN_INPUT = 20.0
"""Of processor time."""
BYTES = 3 << 30
"""Of memory beyond what the child begins with."""


@dataclass(frozen=True)
class Failure:
    """An input that was neither read nor refused."""

    target: str
    number: int
    """Names the input: see `input_of`."""
    what: str


def input_of(target: Target, number: int) -> Input:
    """Return the input of a number: the same one on every machine."""
    return target.make(random.Random(f"{target.name} {number}"))


def fuzz(target: Target, seconds: float, *, first: int = 0, count: int = 1 << 60) -> tuple[int, list[Failure]]:
    """Feed a target with inputs from number `first` on, for so many seconds or so many inputs.

    Returns:
        How many inputs there were, and the failures, at most one of each kind.
    """
    failures: dict[str, Failure] = {}
    end, number = time.monotonic() + seconds, first
    while time.monotonic() < end and number < first + count:
        number, what = _run_child(target, number, first + count, end)
        if what:
            failures.setdefault(what, Failure(target.name, number, what))
            number += 1
    return number - first, list(failures.values())


def outcome(target: Target, value: Input) -> str:
    """Return what went wrong with an input; nothing if it was read or refused in one line."""
    try:
        target.read(value)
    except CadetWarning:  # what is assumed where a file says nothing
        return ""
    except CadetError as error:
        if "internal error" in str(error) or "\n" in str(error):
            return f"refused with {str(error)[:300]!r}"
    except BaseException as error:  # noqa: BLE001 - whatever else comes is what we look for
        frames = traceback.extract_tb(error.__traceback__)
        return f"{type(error).__name__} in {os.path.basename(frames[-1].filename)}:{frames[-1].lineno}"  # noqa: PTH119
    return ""


def _run_child(target: Target, first: int, last: int, end: float) -> tuple[int, str]:
    """Run inputs up to `last` until one fails or the time is over: the number reached, and what was wrong with it."""
    from_child, to_parent = os.pipe()
    sys.stdout.flush()
    with warnings.catch_warnings():
        # The core's threads and OpenCV's stay behind, and no reader waits for them.
        warnings.simplefilter("ignore", DeprecationWarning)
        pid = os.fork()
    if pid == 0:
        try:
            os.close(from_child)
            _be_child(target, first, last, end, to_parent)
        finally:
            os._exit(0)
    os.close(to_parent)
    with os.fdopen(from_child, "rb") as pipe:
        records = pipe.read()
    _, status = os.waitpid(pid, 0)
    at = records.rfind(b"\0INPUT ")
    number = struct.unpack_from("<q", records, at + 7)[0] if at >= 0 else first
    what = records[at + 15 :].decode("utf-8", "replace") if at >= 0 else ""
    if os.WIFSIGNALED(status):
        died = signal.Signals(os.WTERMSIG(status)).name
        return number, f"took more than {SECONDS_AN_INPUT:g} s" if died == "SIGPROF" else f"died by {died}"
    return (number, what) if what else (number + 1, "")


def _be_child(target: Target, first: int, last: int, end: float, to_parent: int) -> None:
    used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()  # noqa: PTH123, SIM115
    resource.setrlimit(resource.RLIMIT_AS, (used + BYTES, used + BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    number = first
    while number < last and time.monotonic() < end:
        os.write(to_parent, b"\0INPUT " + struct.pack("<q", number))
        signal.setitimer(signal.ITIMER_PROF, SECONDS_AN_INPUT)
        what = outcome(target, input_of(target, number))
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        if what:
            os.write(to_parent, what.encode())
            break
        number += 1
