"""One weather for both sensors: its presets, and the same fog, rain and snow for scans that were recorded without."""

from __future__ import annotations

import sys
from enum import IntEnum
from numbers import Integral, Real
from typing import Literal, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.arrays import check_array
from cadet._util.checks import is_one_of, plain_number, shown
from cadet.errors import CadetError, NonFiniteError, ShapeError


class Fate(IntEnum):
    """What became of a point of a scan that `apply` put weather on."""

    KEPT = 0
    """Still there: dimmer and, where rain or snow falls, a little noisier in range."""
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


def weather_names() -> tuple[str, ...]:
    """Return the names of the presets, as `Scene.random(weather=...)` and `cadet-gen --weather` take them."""
    return tuple(_cadet.weather_names())


def check_weather(name: object) -> str:
    """Return `name` if it names a preset.

    Raises:
        CadetError: it does not; the message lists those that exist.
    """
    names = weather_names()
    if not is_one_of(name, names):
        raise CadetError(f"unknown weather {shown(name)}; known: {', '.join(names)}")
    return str(name)


def air_of(name: str) -> Air:
    """Return what a preset has in its air, for `apply(points_velo, **air_of("dense_fog")._asdict())`.

    Raises:
        CadetError: no preset of that name.
    """
    return Air(*_cadet.weather_air(check_weather(name)))


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
    rain and snow move them along their rays by the noise of a weaker echo. Scattered points stand where fog, a drop or
    a flake gave the return, between the sensor and the point, with that return's intensity. Lost points are left out:
    those that drops, flakes or water leave below the detection threshold. Fog alone loses none. Intensities are not
    rounded to 0.01.

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
