"""The folder or URL that a run writes to: may it, and does it go on with what is there?"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from pathlib import Path

from cadet._util.checks import shown
from cadet._util.plain_text import json_from_text
from cadet._util.sink import Sink
from cadet.errors import CadetError, FileFormatError
from cadet.generate.settings import Settings, differences

RUN = "run.json"
"""What the run was begun with, for `--resume`."""


@contextlib.contextmanager
def open_folder(root: str | Path, settings: Settings, *, resume: bool) -> Iterator[Sink]:
    """Begin a new dataset, or check that an old one's run can go on; hold its folder until the run ends.

    Raises:
        CadetError: the folder has something in it and `resume` is not set; it holds no run; the run was begun with
            other settings, had more frames, or is still going on.
        OSError: the folder can't be made, read or written.
    """
    sink = settings.open(root)
    identity = settings.identity()
    with sink.held():
        if sink.names(""):
            if not resume:
                raise CadetError(f"{sink.location} is not empty: name a new folder, or go on with --resume")
            _check_same_run(sink, identity)
            _check_no_more_frames(sink, settings)
        else:
            _begin(sink, identity)
        sink.remove_partial()
        try:
            yield sink
        finally:
            sink.remove_partial()


def _begin(sink: Sink, identity: dict[str, object]) -> None:
    try:
        sink.put_new(RUN, (json.dumps(identity, separators=(",", ":")) + "\n").encode("ascii"))
    except FileExistsError:
        raise CadetError(f"another cadet-gen has just begun in {sink.location}: let it end first") from None


def _check_same_run(sink: Sink, identity: dict[str, object]) -> None:
    try:
        begun = json_from_text(sink.read(RUN), RUN)
    except (FileNotFoundError, FileFormatError):
        raise CadetError(
            f"{sink.location} holds no run to go on with: there is no {RUN} in it; name a new folder"
        ) from None
    _check_same_version(sink.location, begun, identity)
    # What JSON makes of it, so that tuples and lists compare alike.
    found = [
        f"{name} was {json.dumps(old)}, now {json.dumps(new)}"
        for name, old, new in differences(begun, json.loads(json.dumps(identity)))
    ]
    if found:
        # One difference is enough to tell, and the shortest tells most: a number rather than a table.
        raise CadetError(
            f"{sink.location} was begun with other settings: {min(found, key=len)}; "
            "give the same ones, or name a new folder"
        )


def _check_same_version(location: str, begun: object, identity: dict[str, object]) -> None:
    """Refuse a run of another version: the same settings may mean other bytes there."""
    if not isinstance(begun, dict):
        raise CadetError(f"{location}/{RUN}: expected a JSON object, got {shown(begun)}; name a new folder")
    old, new = (
        f"cadet {run.get('cadet')}, format {run.get('format')}, generator {run.get('generator')}"
        for run in (begun, identity)
    )
    if old != new:
        raise CadetError(
            f"{location} was begun by another version ({' '.join(old.split())[:100]}), this is {new}: "
            "go on with that one, or name a new folder"
        )


def _check_no_more_frames(sink: Sink, settings: Settings) -> None:
    most = max(settings.exporter.written(sink), default=-1)
    if most >= settings.num_frames:
        raise CadetError(f"{sink.location} has frames up to {most:06d} already: give at least -n {most + 1}")
