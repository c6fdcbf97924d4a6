"""Where a LIDAR's lasers point when they fire: the azimuths of a turn, or a path of beams that do not spin."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any

from cadet import _cadet
from cadet._util.checks import Limits, as_path, check_fields, check_number, is_one_of, make_plain, shown
from cadet._util.plain_tables import check_keys_of
from cadet._util.summary import summary
from cadet.errors import CadetError, FileFormatError

_COLUMNS_OF_FILE = ("time_s", "azimuth_deg", "elevation_deg")


def _check_columns(name: str, columns: object, limit: str = "columns") -> None:
    least, most = _cadet.limits()[limit]
    check_number("firing", name, columns, int(least), int(most), whole=True)


def _check_pairs(firing: object, *names: str) -> None:
    for name in names:
        pair = getattr(firing, name)
        if not isinstance(pair, tuple) or len(pair) != 2:
            raise CadetError(f"firing.{name}: expected two numbers, got {shown(pair)}")
    check_fields(firing, "firing")


@dataclass(frozen=True, kw_only=True)
class UniformFiring:
    """Equal steps of azimuth, the first column forward.

    Raises:
        CadetError: a number outside its range.
    """

    columns: int
    """Firings a turn."""

    def __post_init__(self) -> None:
        _check_columns("columns", self.columns)
        make_plain(self)


@dataclass(frozen=True, kw_only=True)
class EncoderFiring:
    """Even firings: column j at ticks_per_firing * j + phase_ticks of an encoder, its points at the nearest whole tick.

    Raises:
        CadetError: a number outside its range.
    """

    ticks_per_turn: Annotated[int, Limits(1, 1_000_000_000)]
    """4000 for ticks of 0.09 degrees."""
    ticks_per_firing: Annotated[float, Limits(1, 1e9)]
    """Mean ticks from one firing to the next."""
    firings: int
    """Firings a turn: the last must fall before the turn's end."""
    phase_ticks: Annotated[float, Limits(0, 1e9)] = 0.0
    """Where the first firing falls."""

    def __post_init__(self) -> None:
        check_fields(self, "firing")
        _check_columns("firings", self.firings)
        make_plain(self)


@dataclass(frozen=True, kw_only=True)
class ListedFiring:
    """Any azimuths.

    Raises:
        CadetError: azimuths that do not rise within one turn.
    """

    azimuths_deg: Annotated[tuple[float, ...], Limits(0, 360)]
    """Rising, from 0 to below 360, counter-clockwise from forward."""

    def __repr__(self) -> str:
        return summary(self, f"{len(self.azimuths_deg)} azimuths")

    def __post_init__(self) -> None:
        azimuths = self.azimuths_deg
        if not isinstance(azimuths, tuple) or not 1 <= len(azimuths) <= 65535:
            raise CadetError("firing.azimuths_deg: expected a list of 1 to 65535 numbers")
        check_fields(self, "firing")
        for before, after in zip(azimuths, (*azimuths[1:], 360.0), strict=True):
            if after <= before:
                raise CadetError(f"firing.azimuths_deg: expected rising numbers below 360, got {after} after {before}")
        make_plain(self)


@dataclass(frozen=True, kw_only=True)
class RasterFiring:
    """Lines from one side to the other, evenly through 1 / `BeamTable.rate_hz`, centered on the image's instant.

    Raises:
        CadetError: a number outside its range, or too many firings.
    """

    lines: int
    """Number of lines."""
    columns: int
    """Firings of a line."""
    azimuth_span_deg: Annotated[tuple[float, float], Limits(-180, 180)]
    """Of a line's first and last firing, counter-clockwise from forward: (60.0, -60.0) from the left to the right."""
    elevation_span_deg: Annotated[tuple[float, float], Limits(-89, 89)]
    """Of the first and the last line; those of the lasers are added."""

    def __post_init__(self) -> None:
        _check_pairs(self, "azimuth_span_deg", "elevation_span_deg")
        _check_columns("lines", self.lines, "firings")
        _check_columns("columns", self.columns, "firings")
        _check_columns("lines x columns", self.lines * self.columns, "firings")
        make_plain(self)


@dataclass(frozen=True, kw_only=True)
class RosetteFiring:
    """What two turning prisms draw around straight ahead, as in Livox' Mid-40; each scan goes on from the one before.

    Either prism deflects the beam by an angle, and both deflections add up: the paraxial approximation of Risley prisms
    (Brazeal et al., "A Rigorous Observation Model for the Risley Prism-Based Livox Mid-40 Lidar Sensor", 2021).

    Raises:
        CadetError: a number outside its range.
    """

    firings: int
    """Firings of a scan, evenly through 1 / `BeamTable.rate_hz`."""
    deflections_deg: Annotated[tuple[float, float], Limits(-80, 80)]
    """Of either prism: the field of view is a cone of their sum to each side."""
    prism_rates_hz: Annotated[tuple[float, float], Limits(-10_000, 10_000)]
    """Turns a second of either prism, opposite signs for opposite ways."""

    def __post_init__(self) -> None:
        _check_pairs(self, "deflections_deg", "prism_rates_hz")
        if sum(map(abs, self.deflections_deg)) > 80.0:
            raise CadetError(f"firing.deflections_deg: expected a sum of at most 80, got {shown(self.deflections_deg)}")
        _check_columns("firings", self.firings, "firings")
        make_plain(self)


@dataclass(frozen=True, kw_only=True)
class TableFiring:
    """Any directions at any times, the same in every scan.

    Raises:
        CadetError: times that fall, or a number outside its range.
    """

    aims: tuple[tuple[float, float, float], ...]
    """Of each firing, seconds from the image's instant, which must not fall (-10 to 10), degrees counter-clockwise from
    forward (-360 to 360) and degrees over the horizon (-89 to 89); those of the lasers are added."""

    def __repr__(self) -> str:
        return summary(self, f"{len(self.aims)} firings")

    def __post_init__(self) -> None:
        if not isinstance(self.aims, tuple):
            raise CadetError(f"firing.aims: expected a list such as [[0.0, 10.0, -2.0]], got {shown(self.aims)}")
        _check_columns("number of aims", len(self.aims), "firings")
        earliest_s = -10.0
        for number, aim in enumerate(self.aims):
            place = f"aims[{number}]"
            if not isinstance(aim, tuple) or len(aim) != 3:
                raise CadetError(f"firing.{place}: expected time, azimuth and elevation, got {shown(aim)}")
            check_number("firing", f"{place} time", aim[0], earliest_s, 10.0)
            check_number("firing", f"{place} azimuth", aim[1], -360.0, 360.0)
            check_number("firing", f"{place} elevation", aim[2], -89.0, 89.0)
            earliest_s = float(aim[0])
        make_plain(self)

    @classmethod
    def read(cls, path: str | Path) -> TableFiring:
        """Return the firings of a CSV file with the columns `time_s`, `azimuth_deg`, `elevation_deg`.

        Raises:
            CadetError: naming the file, the line and the reason.
        """
        file = as_path("path", path)
        try:
            with file.open(newline="", encoding="utf-8") as opened:
                rows = list(csv.reader(opened))
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise FileFormatError(str(error), str(file)) from None
        if not rows or tuple(cell.strip() for cell in rows[0]) != _COLUMNS_OF_FILE:
            raise FileFormatError(f"expected the first line to be {','.join(_COLUMNS_OF_FILE)}", str(file), 1)
        aims = []
        for line, row in enumerate(rows[1:], start=2):
            try:
                time_s, azimuth_deg, elevation_deg = map(float, row)
            except ValueError:
                raise FileFormatError(f"expected three numbers, got {shown(','.join(row))}", str(file), line) from None
            aims.append((time_s, azimuth_deg, elevation_deg))
        try:
            return cls(aims=tuple(aims))
        except CadetError as error:
            raise FileFormatError(str(error), str(file)) from None


TURNING = (UniformFiring, EncoderFiring, ListedFiring)
"""The patterns of LIDARs that spin."""
Firing = UniformFiring | EncoderFiring | ListedFiring | RasterFiring | RosetteFiring | TableFiring
FIRINGS: dict[str, type[Firing]] = {
    "uniform": UniformFiring,
    "encoder": EncoderFiring,
    "listed": ListedFiring,
    "raster": RasterFiring,
    "rosette": RosetteFiring,
    "table": TableFiring,
}
"""By the names that files call them."""


def num_columns_of(firing: Firing) -> int:
    """Return how often all lasers fire in a scan."""
    if isinstance(firing, RasterFiring):
        return firing.lines * firing.columns
    if isinstance(firing, UniformFiring):
        return firing.columns
    if isinstance(firing, EncoderFiring | RosetteFiring):
        return firing.firings
    return len(firing.aims if isinstance(firing, TableFiring) else firing.azimuths_deg)


def pattern_of(firing: Firing) -> str:
    """Return the name of a pattern."""
    return next(name for name, cls in FIRINGS.items() if isinstance(firing, cls))


def firing_of_fields(values: Mapping[str, Any]) -> Firing:
    """Return the pattern that has just these fields."""
    cls = next(cls for cls in FIRINGS.values() if {f.name for f in fields(cls)} == values.keys())
    return cls(**values)


def as_tuples(value: Any) -> Any:
    """Return a value of a file with tuples in place of lists."""
    return tuple(map(as_tuples, value)) if isinstance(value, list) else value


def firing_of_table(values: object, folder: Path) -> Firing:
    """Return the pattern of a file's table; `file` of a `table` is looked for in the folder.

    Raises:
        CadetError: an unknown pattern, or numbers out of range.
    """
    if not isinstance(values, Mapping):
        raise CadetError(f"firing: expected a table, got {shown(values)}")
    if "pattern" not in values:
        raise CadetError("firing: missing key 'pattern'")
    if not is_one_of(values["pattern"], FIRINGS):
        raise CadetError(f"firing.pattern: expected one of {', '.join(FIRINGS)}, got {shown(values['pattern'])}")
    cls = FIRINGS[values["pattern"]]
    rest = {key: as_tuples(value) for key, value in values.items() if key != "pattern"}
    if cls is TableFiring and rest.keys() == {"file"}:
        if not isinstance(rest["file"], str):
            raise CadetError(f"firing.file: expected a path, got {shown(rest['file'])}")
        return TableFiring.read(folder / rest["file"])
    check_keys_of(cls, rest, "firing")
    return cls(**rest)
