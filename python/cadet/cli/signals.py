"""Signals that end a command: all of them as Ctrl-C does, with one line and no file half-written."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType
from typing import NoReturn

from cadet._util.operating_system import ENDING_SIGNALS

INTERRUPTED = 130
"""The exit code after Ctrl-C; after another signal it is 128 and the signal's number."""


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP.

    Attributes:
        number: the signal's.
    """

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = signal.Signals(number)


@contextlib.contextmanager
def signals_end() -> Iterator[None]:
    """Raise `Terminated` on SIGTERM and SIGHUP meanwhile. Who started us may have had us ignore them: that stays."""
    raised: list[Terminated] = []

    def end(number: int, _: FrameType | None) -> NoReturn:
        raised.append(Terminated(number))
        raise raised[-1]

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard = [number for number in ENDING_SIGNALS if signal.getsignal(number) is signal.SIG_DFL]
    for number in heard:
        signal.signal(number, end)
    try:
        yield
    except KeyboardInterrupt:
        # Ray tells of any signal as of Ctrl-C.
        if raised:
            raise raised[-1] from None
        raise
    finally:
        for number in heard:
            signal.signal(number, signal.SIG_DFL)


def how_ended(error: KeyboardInterrupt) -> str:
    """Name what ended a command: "interrupted", or the signal."""
    return f"ended by {error.number.name}" if isinstance(error, Terminated) else "interrupted"


def exit_code(error: KeyboardInterrupt) -> int:
    """Return the exit code after a signal."""
    return 128 + error.number if isinstance(error, Terminated) else INTERRUPTED
