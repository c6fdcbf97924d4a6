"""What makes a dataset's episodes: processes of this machine (`local_engine`) or a Ray cluster (`ray_engine`)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Protocol

from cadet.errors import CadetError, WorkerError

SILENCE_S: Final = 60.0
"""After so long without a sign of life a line says who is waited for."""


@dataclass(frozen=True)
class Made:
    """A frame was written, or found whole."""

    number: int
    """The frame's."""
    is_new: bool
    """Whether it was written."""
    is_standing: bool
    """Whether the ego stood."""


@dataclass(frozen=True)
class Failed:
    """An episode can't be made: trying again would fail in the same way."""

    message: str
    """One line."""
    is_users: bool
    """Whether the user can fix it: settings, disk. Otherwise it is a bug of ours."""

    def error(self) -> CadetError:
        """Return what to raise."""
        return CadetError(self.message) if self.is_users else WorkerError(self.message)


class Engine(Protocol):
    """Hands the episodes of a dataset out to workers. Which worker makes an episode, and how often, changes no byte."""

    def frames(self) -> Iterator[Made]:
        """Yield each frame once, as it gets written or is found whole, until all are.

        Raises:
            CadetError: a worker met what the user can fix.
            WorkerError: workers died again and again in the same episode, or met a bug.
        """

    def close(self) -> None:
        """End the workers; what they have begun is left."""
