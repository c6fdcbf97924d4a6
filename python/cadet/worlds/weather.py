"""One weather for both sensors, and the same fog, rain and snow for scans that were recorded without."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import IntEnum
from numbers import Integral, Real
from typing import Annotated, Any, Final, Literal, NamedTuple, TypeAlias, get_origin, get_type_hints, overload

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.arrays import check_array
from cadet._util.checks import Limits, check_number, check_text, is_one_of, known_names, plain_number, shown
from cadet._util.summary import summary
from cadet.errors import CadetError, NonFiniteError, ShapeError
from cadet.worlds.config import SceneConfig
from cadet.worlds.draws import Draws


class Fate(IntEnum):
    """What became of a point of a scan that `apply` put weather on."""

    KEPT = 0
    """Still there: dimmer and a little noisier in range."""
    LOST = 1
    """Below the detection threshold."""
    SCATTERED = 2
    """Fog, a drop, or a flake in front of it gave the return: the point moved toward the sensor on its ray."""


class Air(NamedTuple):
    """What a preset has in its air and on its ground; its fields are keywords of `apply`."""

    fog: float
    """Attenuation, 1/m: ln 20 over the meteorological optical range."""
    rain: float
    """mm/h."""
    snow: float
    """mm/h of water."""
    wetness: float
    """Share of paved ground under a film of water."""


_Number: TypeAlias = float | tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Weather:
    """A weather in numbers; a pair of them is a range, from which each episode of a policy draws its own.

    The presets of `weather_names()` are such numbers: `Weather.preset("snow")`.

    Raises:
        CadetError: a number outside its range.
    """

    name: str = "custom"
    """For the metadata."""
    rain_mm_h: Annotated[_Number, Limits(0, 1000)] = 0.0
    """Rain rate, mm/h."""
    fog_visibility_m: Annotated[_Number | None, Limits(1, 100_000)] = None
    """Meteorological optical range of the fog alone, ln 20 over its attenuation; None for none."""
    snow_mm_h: Annotated[_Number, Limits(0, 100)] = 0.0
    """Snow rate, mm/h of water; where snow falls it also lies."""
    wetness: Annotated[_Number, Limits(0, 1)] = 0.0
    """Share of paved ground under a film of water."""
    cloud_cover: Annotated[_Number, Limits(0, 1)] = 0.1
    """0 is a clear sky, 1 an overcast one without shadows."""
    wind_mps: Annotated[_Number, Limits(0, 60)] = 0.0
    """Wind, with which drops and flakes go in images; its direction is drawn by the seed."""
    sun_elevation_deg: Annotated[_Number | None, Limits(-90, 90)] = None
    """The sun's height over the horizon, below 0 at night; None for one of 20 to 45 degrees, drawn by the seed."""
    sun_azimuth_deg: Annotated[_Number | None, Limits(-360, 360)] = None
    """Its direction, counter-clockwise from east; drawn by the seed if None, south in `Scene.empty`."""

    def __repr__(self) -> str:
        return summary(self, name=self.name, **self.numbers())

    def __post_init__(self) -> None:
        check_text("Weather", "name", self.name)
        for name, limits in _LIMITS.items():
            value = getattr(self, name)
            if value is None and name in _MAY_LACK:
                continue
            ends = value if isinstance(value, (list, tuple)) else (value,)
            for end in ends:
                check_number("Weather", name, end, *limits)
            if len(ends) not in (1, 2) or ends[0] > ends[-1]:
                raise CadetError(f"Weather.{name}: expected a number, or two that rise, got {shown(value)}")
            plain = tuple(map(float, ends))
            object.__setattr__(self, name, plain if isinstance(value, (list, tuple)) else plain[0])

    @classmethod
    def preset(cls, name: str) -> Weather:
        """Return the numbers of a preset.

        Raises:
            CadetError: no preset of that name.
        """
        rain, visibility_m, snow, wetness, cloud_cover, elevation_deg = _cadet.weather_preset(check_weather(name))
        return cls(
            name=name,
            rain_mm_h=rain,
            fog_visibility_m=visibility_m,
            snow_mm_h=snow,
            wetness=wetness,
            cloud_cover=cloud_cover,
            sun_elevation_deg=elevation_deg if elevation_deg < _LEAST_DRAWN_SUN_DEG else None,
        )

    def _drawn(self, draws: Draws) -> Weather:
        """Return the weather with a number in place of each range."""
        ranges = {name: value for name in _LIMITS if isinstance(value := getattr(self, name), tuple)}
        drawn: dict[str, Any] = {name: draws.between(*ends) for name, ends in ranges.items()}
        return replace(self, **drawn)

    def numbers(self) -> dict[str, Any]:
        """Return what differs from a clear noon, in plain values."""
        values = {name: getattr(self, name) for name in _LIMITS if getattr(self, name) != getattr(Weather, name)}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}

    def _sun_of(self, config: SceneConfig) -> SceneConfig:
        """Return a scene's configuration with the weather's sun, where it says more than the configuration.

        What is too low for `SceneConfig` is in the core's weather.
        """
        azimuth, elevation = self.sun_azimuth_deg, self.sun_elevation_deg
        sun: dict[str, Any] = {}
        if azimuth is not None and config.sun_azimuth_deg is None:
            sun["sun_azimuth_deg"] = azimuth
        if isinstance(elevation, float) and elevation >= _LEAST_DRAWN_SUN_DEG and config.sun_elevation_deg is None:
            sun["sun_elevation_deg"] = elevation
        return replace(config, **sun)

    def _to_native(self) -> _cadet.Weather:
        """Return the core's weather.

        Raises:
            CadetError: a number is still a range.
        """
        numbers = {name: getattr(self, name) for name in _LIMITS}
        if ranges := [name for name, value in numbers.items() if isinstance(value, tuple)]:
            raise CadetError(f"Weather.{ranges[0]}: a range is for policies; expected a number")
        return _cadet.Weather(self.name, **numbers)


_LIMITS: Final[dict[str, Limits]] = {
    name: hint.__metadata__[0]
    for name, hint in get_type_hints(Weather, include_extras=True).items()
    if get_origin(hint) is Annotated
}
_MAY_LACK: Final = {name for name in _LIMITS if getattr(Weather, name) is None}
_LEAST_DRAWN_SUN_DEG: Final = 15.0
"""The height of a sun that lies higher is drawn by the seed, unless it is given (`Weather::with_sun_turned`)."""


def weather_names() -> tuple[str, ...]:
    """Return the names of the presets, as `Scene.random(weather=...)` and `cadet gen --weathers` take them."""
    return tuple(_cadet.weather_names())


def check_weather(name: object) -> str:
    """Return `name` if it names a preset.

    Raises:
        CadetError: it does not; the message lists those that exist.
    """
    names = weather_names()
    if not is_one_of(name, names):
        raise CadetError(f"unknown weather {shown(name)}; {known_names(name, names)}")
    return str(name)


def as_weather(weather: object) -> Weather:
    """Return a weather, or the preset of a name.

    Raises:
        CadetError: neither.
    """
    return weather if isinstance(weather, Weather) else Weather.preset(check_weather(weather))


def table_of_weathers(weathers: Iterable[tuple[Weather, float]]) -> dict[str, Any]:
    """Return the weight of each preset by its name; of other weathers their numbers, too."""
    return {
        weather.name: weight
        if is_one_of(weather.name, weather_names()) and weather == Weather.preset(weather.name)
        else {"weight": weight, **weather.numbers()}
        for weather, weight in weathers
    }


def air_of(name: str) -> Air:
    """Return what a preset has in its air, for `apply(points_velo, **air_of("dense_fog")._asdict())`.

    Raises:
        CadetError: no preset of that name.
    """
    rain, visibility_m, snow, wetness, *_ = _cadet.weather_preset(check_weather(name))
    return Air(0.0 if visibility_m is None else math.log(20.0) / visibility_m, rain, snow, wetness)


@overload
def apply(
    points_velo: NDArray[np.float32],
    *,
    fog: float = ...,
    rain: float = ...,
    snow: float = ...,
    wetness: float = ...,
    seed: int = ...,
    sensor_height_m: float = ...,
    return_fate: Literal[False] = ...,
) -> NDArray[np.float32]: ...


@overload
def apply(
    points_velo: NDArray[np.float32],
    *,
    fog: float = ...,
    rain: float = ...,
    snow: float = ...,
    wetness: float = ...,
    seed: int = ...,
    sensor_height_m: float = ...,
    return_fate: Literal[True],
) -> tuple[NDArray[np.float32], NDArray[np.int8]]: ...


def apply(
    points_velo: NDArray[np.float32],
    *,
    fog: float = 0.0,
    rain: float = 0.0,
    snow: float = 0.0,
    wetness: float = 0.0,
    seed: int = 0,
    sensor_height_m: float = 1.73,
    return_fate: bool = False,
) -> NDArray[np.float32] | tuple[NDArray[np.float32], NDArray[np.int8]]:
    """Put fog, rain or snow on a scan that was recorded in clear air.

    The physics is that of generated scans (docs/weather.md). Kept points lose intensity by `exp(-2 alpha range)`, and
    move along their rays by the noise of a weaker echo. Scattered points stand where fog, a drop or a flake gave the
    return, between the sensor and the point, with that return's intensity. Lost points, left below the detection
    threshold, are left out. Intensities are not rounded to 0.01.

    A point's fate depends on itself, on the weather and on `seed`, not on the rest of the array, so a scan may be cut
    in pieces. Rows keep their order. With no weather the points come back bit for bit, in a new array.

    Args:
        points_velo: (N, 4) float32: x, y, z in meters from the sensor, intensity in 0..1. Not changed. May be empty.
            Other sensors' scans: the first four columns, rows that are not finite left out, intensities scaled to 1.
        fog: attenuation alpha, 1/m, 0 to 10; 0.06 is seen through for 50 m.
        rain: mm/h, 0 to 1000.
        snow: mm/h of water, 0 to 100.
        wetness: share of the ground under a film of water, 0 to 1; ground is what lies within 0.2 m and 1 % of the
            range of the level plane `sensor_height_m` below the sensor.
        seed: names the drops and flakes, 0 to 2**64 - 1; take another for each scan.
        sensor_height_m: height over the road; KITTI's.
        return_fate: return the fates too.

    Returns:
        (M, 4) float32 with M <= N; with `return_fate` also (N,) int8, the `Fate` of each given point.

    Raises:
        ShapeError: not (N, 4) float32.
        NonFiniteError: NaN or infinity.
        CadetError: a rate, an intensity or a seed outside its range.
    """
    _check_scan(points_velo)
    numbers = {"fog": fog, "rain": rain, "snow": snow, "wetness": wetness, "sensor_height_m": sensor_height_m}
    if not isinstance(seed, Integral) or isinstance(seed, bool) or not 0 <= seed < 2**64:
        raise CadetError(f"seed: expected a whole number from 0 to 2**64 - 1, got {shown(seed)}")
    left, fate = _cadet.weather_recorded_scan(
        points_velo, **{name: _number(name, value) for name, value in numbers.items()}, seed=int(seed)
    )
    return (left, fate) if return_fate else left


def _check_scan(points_velo: NDArray[np.float32]) -> None:
    """Refuse what other sensors' scans have otherwise, with what to do."""
    if np.ndim(points_velo) == 2 and np.shape(points_velo)[1] > 4:
        given = f"{points_velo.shape} {points_velo.dtype}"
        raise ShapeError(f"points_velo: expected (N, 4) float32, got {given}: give the first four, as points[:, :4]")
    try:
        check_array(points_velo, "points_velo", ("N", 4), np.float32, finite=True)
    except NonFiniteError as error:
        remedy = "leave such points out, as in points[np.isfinite(points).all(axis=1)]"
        raise NonFiniteError(f"{error}: {remedy}") from None
    most = float(points_velo[:, 3].max(initial=0.0))
    if most > 1.0:
        raise CadetError(f"intensity of points_velo is {most:g}, expected 0 to 1: scale it, as in points[:, 3] /= 255")


def _number(name: str, value: object) -> float:
    if not isinstance(value, Real) or isinstance(value, bool):
        raise CadetError(f"{name}: expected a number, got {shown(value)}")
    if not abs(plain_number(value)) <= sys.float_info.max:
        raise NonFiniteError(f"{name}: not finite: {shown(value)}")
    return float(value)
