"""How far a run is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

_SECONDS_BETWEEN_LINES = 10.0


class Reporter(Protocol):
    """Hears of each frame."""

    def __enter__(self) -> Reporter:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """End."""

    def on_frame(self, is_new: bool) -> None:
        """Count a frame."""


class Rate:
    """Frames a second and what is left. Frames that were there already count for neither."""

    def __init__(self, total: int) -> None:
        self.total = total
        self.num_new = 0
        self.num_kept = 0
        self._start_s = time.monotonic()

    def count(self, is_new: bool) -> None:
        """Count a frame."""
        if is_new:
            self.num_new += 1
        else:
            self.num_kept += 1

    @property
    def num_done(self) -> int:
        """Frames that are there."""
        return self.num_new + self.num_kept

    @property
    def elapsed_s(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._start_s

    @property
    def per_s(self) -> float:
        """New frames a second since the start."""
        return self.num_new / max(self.elapsed_s, 1e-9)

    def left(self) -> str:
        """Return the time left as h:mm:ss, or "?" before the first new frame."""
        if self.num_new == 0:
            return "?"
        seconds = round((self.total - self.num_done) / self.per_s)
        return f"{seconds // 3600}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"


class Bar:
    """A bar with count, rate and time left."""

    def __init__(self, console: Console, total: int) -> None:
        self._rate = Rate(total)
        self._progress = Progress(
            TextColumn("generating"),
            BarColumn(bar_width=None),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=console,
        )
        self._task = self._progress.add_task("generating", total=total, rate="")

    def __enter__(self) -> Bar:
        """Show the bar."""
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the bar as it stands."""
        self._progress.stop()

    def on_frame(self, is_new: bool) -> None:
        """Count a frame."""
        self._rate.count(is_new)
        self._progress.update(self._task, advance=1, rate=f"{self._rate.per_s:.1f}/s")


class Lines:
    """A plain line every ten seconds, for logs."""

    def __init__(self, console: Console, total: int) -> None:
        self._console = console
        self._rate = Rate(total)
        self._last_s = 0.0

    def __enter__(self) -> Lines:
        """Say nothing yet."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Say nothing more."""

    def on_frame(self, is_new: bool) -> None:
        """Count a frame, and say so if it is time."""
        rate = self._rate
        rate.count(is_new)
        if rate.elapsed_s - self._last_s >= _SECONDS_BETWEEN_LINES:
            self._last_s = rate.elapsed_s
            self._console.print(f"{rate.num_done}/{rate.total} frames, {rate.per_s:.1f}/s, {rate.left()} left")


def reporter(console: Console, total: int) -> Reporter:
    """Return what fits the console: a bar on a terminal, lines elsewhere."""
    return Bar(console, total) if console.is_terminal else Lines(console, total)
