"""The folder that a run writes to: may it, and does it go on with what is there?"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Iterator
from pathlib import Path

from cadet.checks import shown
from cadet.errors import CadetError, FileFormatError
from cadet.generate.settings import Settings, differences
from cadet.plain_text import json_from_text
from cadet.sink import LocalSink

RUN = "run.json"
"""What the run was begun with, for `--resume`."""


@contextlib.contextmanager
def open_folder(root: Path, settings: Settings, *, resume: bool) -> Iterator[LocalSink]:
    """Make a new dataset's folder, or check that an old one's run can go on; hold it until the run ends.

    Raises:
        CadetError: the folder has something in it and `resume` is not set; it holds no run; the run was begun with
            other settings, had more frames, or is still going on.
        OSError: the folder can't be made, read or written.
    """
    sink = LocalSink(root)
    identity = settings.identity()
    root.mkdir(parents=True, exist_ok=True)
    with _locked(root):
        if any(path.name != ".partial" for path in root.iterdir()):
            if not resume:
                raise CadetError(f"{root} is not empty: name a new folder, or go on with --resume")
            _check_same_run(root, identity)
            _check_no_more_frames(root, settings)
        else:
            sink.put(RUN, (json.dumps(identity, separators=(",", ":")) + "\n").encode("ascii"))
        sink.remove_partial()
        try:
            yield sink
        finally:
            sink.remove_partial()


@contextlib.contextmanager
def _locked(root: Path) -> Iterator[None]:
    """Hold a folder: the lock is on the folder itself, which no file's replacing changes, and goes with the process."""
    folder = os.open(root, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(folder)
        raise CadetError(f"another cadet-gen is writing to {root}: let it end first") from None
    except OSError as error:
        os.close(folder)
        raise OSError(error.errno, f"cannot be locked: {error.strerror}", str(root)) from None
    try:
        yield
    finally:
        os.close(folder)


def _check_same_run(root: Path, identity: dict[str, object]) -> None:
    try:
        begun = json_from_text((root / RUN).read_bytes(), RUN)
    except (FileNotFoundError, FileFormatError):
        raise CadetError(f"{root} holds no run to go on with: there is no {RUN} in it; name a new folder") from None
    _check_same_version(root, begun, identity)
    # What JSON makes of it, so that tuples and lists compare alike.
    found = [
        f"{name} was {json.dumps(old)}, now {json.dumps(new)}"
        for name, old, new in differences(begun, json.loads(json.dumps(identity)))
    ]
    if found:
        # One difference is enough to tell, and the shortest tells most: a number rather than a table.
        raise CadetError(
            f"{root} was begun with other settings: {min(found, key=len)}; give the same ones, or name a new folder"
        )


def _check_same_version(root: Path, begun: object, identity: dict[str, object]) -> None:
    """Refuse a run of another version: the same settings may mean other bytes there."""
    if not isinstance(begun, dict):
        raise CadetError(f"{root / RUN}: expected a JSON object, got {shown(begun)}; name a new folder")
    old, new = (f"cadet {run.get('cadet')}, format {run.get('format')}" for run in (begun, identity))
    if old != new:
        raise CadetError(
            f"{root} was begun by another version ({' '.join(old.split())[:100]}), this is {new}: "
            "go on with that one, or name a new folder"
        )


def _check_no_more_frames(root: Path, settings: Settings) -> None:
    most = max(settings.exporter.written(root), default=-1)
    if most >= settings.num_frames:
        raise CadetError(f"{root} has frames up to {most:06d} already: give at least -n {most + 1}")
