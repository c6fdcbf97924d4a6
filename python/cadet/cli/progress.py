"""How far a run is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

_SECONDS_BETWEEN_LINES = 10.0


class Reporter(Protocol):
    """Is called for each frame, or whatever is counted."""

    def __enter__(self) -> Reporter:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """End."""

    def advance(self, count: int = 1, *, is_new: bool = True, note: str = "") -> None:
        """Count some; the note stands behind the numbers until the next."""


class Rate:
    """How many a second and what is left. Those that were there already count for neither."""

    def __init__(self, total: int) -> None:
        self.total = total
        self.num_new = 0
        self.num_kept = 0
        self._start_s = time.monotonic()

    def count(self, count: int, is_new: bool) -> None:
        """Count some."""
        if is_new:
            self.num_new += count
        else:
            self.num_kept += count

    @property
    def num_done(self) -> int:
        """How many are there."""
        return self.num_new + self.num_kept

    @property
    def elapsed_s(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._start_s

    @property
    def per_s(self) -> float:
        """New ones a second since the start."""
        return self.num_new / max(self.elapsed_s, 1e-9)

    def left(self) -> str:
        """Return the time left as h:mm:ss, or "?" before the first new one."""
        if self.num_new == 0:
            return "?"
        seconds = round((self.total - self.num_done) / self.per_s)
        return f"{seconds // 3600}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"


class Bar:
    """A bar with count, rate and time left."""

    def __init__(self, console: Console, total: int, text: str) -> None:
        self._rate = Rate(total)
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=None),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[note]}"),
            console=console,
        )
        self._task = self._progress.add_task(text, total=total, rate="", note="")

    def __enter__(self) -> Bar:
        """Show the bar."""
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the bar as it stands."""
        self._progress.stop()

    def advance(self, count: int = 1, *, is_new: bool = True, note: str = "") -> None:
        """Count some."""
        self._rate.count(count, is_new)
        self._progress.update(self._task, advance=count, rate=f"{self._rate.per_s:.1f}/s", note=note)


class Lines:
    """A plain line every ten seconds, for logs."""

    def __init__(self, console: Console, total: int, unit: str) -> None:
        self._console = console
        self._unit = unit
        self._rate = Rate(total)
        self._last_s = 0.0

    def __enter__(self) -> Lines:
        """Say nothing yet."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Say nothing more."""

    def advance(self, count: int = 1, *, is_new: bool = True, note: str = "") -> None:
        """Count some, and say so if it is time."""
        rate = self._rate
        rate.count(count, is_new)
        if rate.elapsed_s - self._last_s >= _SECONDS_BETWEEN_LINES:
            self._last_s = rate.elapsed_s
            line = f"{rate.num_done}/{rate.total} {self._unit}, {rate.per_s:.1f}/s, {rate.left()} left"
            self._console.print(f"{line}, {note}" if note else line, markup=False, soft_wrap=True)


def reporter(console: Console, total: int, *, text: str = "generating", unit: str = "frames") -> Reporter:
    """Return what fits the console: a bar on a terminal, lines elsewhere.

    Args:
        console: where to.
        total: how many there will be.
        text: names the work before the bar.
        unit: names what is counted in the lines.
    """
    return Bar(console, total, text) if console.is_terminal else Lines(console, total, unit)
