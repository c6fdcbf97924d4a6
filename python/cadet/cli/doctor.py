"""`cadet doctor`: what is installed, and what this machine makes of it."""

from __future__ import annotations

import platform
import sys
import time
from importlib.util import find_spec
from typing import Final

import click

from cadet import _cadet
from cadet._util.extras import EXTRAS, Extra
from cadet._util.operating_system import free_memory_gb, num_processors
from cadet._util.text_tables import aligned
from cadet.generate import Settings
from cadet.generate.engines.worker import prepare
from cadet.generate.frames import sample_files, samples_at
from cadet.generate.golden_frames import CASES, digest, generator, stored
from cadet.worlds.policy import ResetPolicy

_PROMISED: Final = ("linux", "x86_64")
_CASE: Final = "kitti"
_FRAMES: Final = 1000


@click.command(name="doctor")
def doctor_command() -> int:
    """Tell what is installed, whether frames are the promised ones, and how long 1,000 take; exit 1 if they are others.

    \b
    cadet doctor
    """  # noqa: D301 - click reads the backspace
    prepare(1)
    memory_gb = free_memory_gb()
    left = "" if memory_gb is None else f", {memory_gb:.1f} GB of memory free"
    click.echo(f"cadet {_cadet.__version__}, generator {generator()}, Python {platform.python_version()}")
    click.echo(f"{platform.system()} {platform.machine()}, {num_processors()} processors{left}\n")
    rows = [(name, extra.purpose, _state(name, extra)) for name, extra in EXTRAS.items()]
    click.echo("\n".join(aligned([("EXTRA", "WHAT FOR", "STATE"), *rows], num_left=3)) + "\n")
    is_same = digest(CASES[_CASE].capture()) == stored()[_CASE]
    is_promised = (sys.platform, platform.machine().lower().replace("amd64", "x86_64")) == _PROMISED
    click.echo(f"Bytes: {_of_bytes(is_same=is_same, is_promised=is_promised)}")
    settings = Settings(policy=ResetPolicy.kitti(), num_frames=_FRAMES)
    minutes = _episode_s(settings) * settings.num_episodes / num_processors() / 60.0
    click.echo(f"Speed: cadet-gen -n {_FRAMES} takes about {max(minutes, 0.1):.1f} minutes")
    return 1 if is_promised and not is_same else 0


def _state(name: str, extra: Extra) -> str:
    missing = ", ".join(module for module in extra.modules if find_spec(module) is None)
    return f"missing {missing}: pip install 'cadet-sim[{name}]'" if missing else "installed"


def _of_bytes(*, is_same: bool, is_promised: bool) -> str:
    if is_same:
        return "a seed gives the same frames here as on other machines"
    if is_promised:
        return "a seed gives other frames here than promised for Linux on x86-64: please report it with this text"
    return "a seed gives other frames here than on Linux on x86-64, for which alone they are promised"


def _episode_s(settings: Settings) -> float:
    """Return how long one process takes for an episode, all but writing the files."""
    begin_s = time.monotonic()
    for place, sample in samples_at(settings, settings.places_of(0)):
        sample_files(settings, place, sample)
    return time.monotonic() - begin_s
