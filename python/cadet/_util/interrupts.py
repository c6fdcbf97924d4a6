"""Ctrl-C while processes start."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from multiprocessing import resource_tracker

from cadet._util.operating_system import interrupts_blocked


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """Hold Ctrl-C back while processes start: they ignore it from their start, and the parent handles it afterwards."""
    # Its own start would let interrupts through.
    resource_tracker.ensure_running()
    held: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    # Blocked signals may still come by way of another thread.
    before = signal.signal(signal.SIGINT, lambda number, _: held.append(number)) if is_main else None
    try:
        with interrupts_blocked():
            yield
    finally:
        if is_main:
            signal.signal(signal.SIGINT, before)
    if held and callable(before):
        before(signal.SIGINT, None)
