"""The names of scenes, by which tools that know nuScenes' splits tell training from validation."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Final

from cadet._util.plain_text import toml_from_text
from cadet.formats.exporter import Split

_FILE: Final = Path(__file__).with_name("scenes.toml")


@cache
def scene_names(split: Split) -> tuple[str, ...]:
    """Return the official names of a split's scenes, in their order: 700, 150, and 150."""
    runs = toml_from_text(_FILE.read_bytes(), _FILE.name)[split]
    return tuple(f"scene-{number:04d}" for first, last in runs for number in range(first, last + 1))
