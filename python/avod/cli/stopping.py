"""What ends a training before its last step: a signal, or the end of its time."""

from __future__ import annotations

import signal
import threading
import time
from types import FrameType, TracebackType
from typing import Final

from cadet._util.operating_system import ENDING_SIGNALS
from cadet.cli.signals import INTERRUPTED, Terminated

OUT_OF_TIME: Final = 75
"""The exit code when `--max-minutes` are over: sysexits.h's "try again later"."""

_SIGNALS: Final = (signal.SIGINT, *ENDING_SIGNALS)


class Stopping:
    """Hears of signals meanwhile, and of the time; a second signal ends the command at once.

    Args:
        max_minutes: None for no limit.
    """

    def __init__(self, max_minutes: float | None) -> None:
        self.signal: int | None = None
        self.is_out_of_time = False
        self._end_s = None if max_minutes is None else time.monotonic() + 60.0 * max_minutes
        self._before: dict[int, object] = {}

    def __enter__(self) -> Stopping:
        """Take the signals over. Who started us may have had us ignore them: that stays."""
        if threading.current_thread() is threading.main_thread():
            for number in _SIGNALS:
                if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                    self._before[number] = signal.signal(number, self._hear)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Give the signals back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]

    def __call__(self) -> bool:
        """Say whether the training should stop."""
        if self._end_s is not None and time.monotonic() >= self._end_s:
            self.is_out_of_time = True
        return self.signal is not None or self.is_out_of_time

    @property
    def reason(self) -> str:
        """What was heard, for a message."""
        if self.signal is None:
            return "the time is up" if self.is_out_of_time else "another process of the training was told to stop"
        return "interrupted" if self.signal == signal.SIGINT else f"ended by {signal.Signals(self.signal).name}"

    @property
    def exit_code(self) -> int:
        """The exit code that tells what was heard."""
        if self.signal is None:
            return OUT_OF_TIME
        return INTERRUPTED if self.signal == signal.SIGINT else 128 + self.signal

    def _hear(self, number: int, _: FrameType | None) -> None:
        if self.signal is not None:
            raise KeyboardInterrupt if number == signal.SIGINT else Terminated(number)
        self.signal = number
