"""The weather presets: one state of air, sky and ground for both sensors."""

from __future__ import annotations

from cadet import _cadet
from cadet.errors import CadetError


def weather_names() -> tuple[str, ...]:
    """Return the names of the presets, as `Scene.random(weather=...)` and `cadet-gen --weather` take them."""
    return tuple(_cadet.weather_names())


def check_weather(name: object) -> str:
    """Return `name` if it names a preset.

    Raises:
        CadetError: it does not; the message lists those that exist.
    """
    names = weather_names()
    if not isinstance(name, str) or name not in names:
        raise CadetError(f"unknown weather {name!r}; known: {', '.join(names)}")
    return name
