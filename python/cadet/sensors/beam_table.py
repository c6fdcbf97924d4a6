"""A LIDAR's beams in numbers: its lasers, when they fire and what they reach; as a TOML file, read and written."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

from cadet import _cadet
from cadet._util.checks import as_path, check_number, make_plain, shown, shown_key
from cadet._util.plain_text import toml_from_text
from cadet._util.summary import summary
from cadet._util.user_files import read_settings
from cadet.errors import CadetError

T = TypeVar("T")

_MAX_BEAMS = 1 << 23
_MAX_RINGS = 4096
_MAX_SECTORS = 360
_MAX_LETTERS = 1 << 22


def _check_columns(name: str, columns: object) -> None:
    least, most = _cadet.limits()["columns"]
    check_number("firing", name, columns, int(least), int(most), whole=True)


@dataclass(frozen=True, kw_only=True)
class Laser:
    """One laser: a ring of the scan.

    Raises:
        CadetError: a number outside its range.
    """

    elevation_deg: float
    """Of the beam over the horizon."""
    height_m: float = 0.0
    """Where the beam leaves the sensor, over the origin of its frame."""
    left_m: float = 0.0
    """How far to the left of the axis the laser sits, as it looks: its beams pass the axis at this distance."""
    azimuth_offset_deg: float = 0.0
    """The laser fires this much counter-clockwise of its columns' azimuths."""
    gain: float = 1.0
    """Sensitivity of the receiver: below 1 it reports more zero intensities."""
    range_offset_m: float = 0.0
    """By how much the laser measures too far: its points lie farther along their beams. Ideal scans have none."""
    focus_m: float = 0.0
    """Of what comes from surfaces nearer than this, (range / focus)^3 of the power counts for detection."""
    blind_deg: tuple[tuple[float, float], ...] = ()
    """Azimuths (from, to) at which what carries the sensor is in the way: beams there never return."""

    def __post_init__(self) -> None:
        check_number("laser", "elevation_deg", self.elevation_deg, -89, 89)
        check_number("laser", "height_m", self.height_m, -10, 10)
        check_number("laser", "left_m", self.left_m, -0.5, 0.5)
        check_number("laser", "azimuth_offset_deg", self.azimuth_offset_deg, -360, 360)
        check_number("laser", "gain", self.gain, 0, 100)
        check_number("laser", "range_offset_m", self.range_offset_m, -1, 1)
        check_number("laser", "focus_m", self.focus_m, 0, 1000)
        sectors = self.blind_deg
        if not isinstance(sectors, tuple) or not all(isinstance(s, tuple) and len(s) == 2 for s in sectors):
            raise CadetError(
                f"laser.blind_deg: expected pairs of azimuths such as [[170.0, 190.0]], got {shown(sectors)}"
            )
        if len(sectors) > _MAX_SECTORS:
            raise CadetError(f"laser.blind_deg: expected at most {_MAX_SECTORS} sectors, got {len(sectors)}")
        for sector in sectors:
            for azimuth in sector:
                check_number("laser", "blind_deg", azimuth, 0, 360)
            if sector[0] > sector[1]:
                raise CadetError(f"laser.blind_deg: expected azimuths that rise, got {sector[0]:g} to {sector[1]:g}")
        make_plain(self)


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

    ticks_per_turn: int
    """4000 for ticks of 0.09 degrees."""
    ticks_per_firing: float
    """Mean ticks from one firing to the next."""
    firings: int
    """Firings a turn: the last must fall before the turn's end."""
    phase_ticks: float = 0.0
    """Where the first firing falls."""

    def __post_init__(self) -> None:
        check_number("firing", "ticks_per_turn", self.ticks_per_turn, 1, 1_000_000_000, whole=True)
        check_number("firing", "ticks_per_firing", self.ticks_per_firing, 1, 1e9)
        _check_columns("firings", self.firings)
        check_number("firing", "phase_ticks", self.phase_ticks, 0, 1e9)
        make_plain(self)


@dataclass(frozen=True, kw_only=True)
class ListedFiring:
    """Any azimuths.

    Raises:
        CadetError: azimuths that do not rise within one turn.
    """

    azimuths_deg: tuple[float, ...]
    """Rising, from 0 to below 360, counter-clockwise from forward."""

    def __repr__(self) -> str:
        return summary(self, f"{len(self.azimuths_deg)} azimuths")

    def __post_init__(self) -> None:
        azimuths = self.azimuths_deg
        if not isinstance(azimuths, tuple) or not 1 <= len(azimuths) <= 65535:
            raise CadetError("firing.azimuths_deg: expected a list of 1 to 65535 numbers")
        for azimuth in azimuths:
            check_number("firing", "azimuths_deg", azimuth, 0, 360)
        for before, after in zip(azimuths, (*azimuths[1:], 360.0), strict=True):
            if after <= before:
                raise CadetError(f"firing.azimuths_deg: expected rising numbers below 360, got {after} after {before}")
        make_plain(self)


_NUMBERS = tuple(f.name for f in fields(Laser) if f.name != "blind_deg")
_RANGES = ("min_range_m", "max_range_m", "range_noise_m")

Firing = UniformFiring | EncoderFiring | ListedFiring
_PATTERNS: dict[str, type[Firing]] = {"uniform": UniformFiring, "encoder": EncoderFiring, "listed": ListedFiring}


@dataclass(frozen=True, kw_only=True)
class BeamTable:
    """A turning LIDAR.

    Raises:
        CadetError: a number outside its range, or rings that are not in the order of their elevations.
    """

    name: str
    """Letters, digits, `_`, `.` and `-`."""
    rings: tuple[Laser, ...]
    """From the highest elevation to the lowest: the order of the rings in a scan's file."""
    firing: Firing
    """When all of them fire."""
    min_range_m: float = 1.45
    """Nearer returns are not kept."""
    max_range_m: float = 80.0
    """Returns as far as this are not kept."""
    range_noise_m: float = 0.0078
    """Standard deviation of the range."""

    def __repr__(self) -> str:
        return summary(
            self,
            f"{len(self.rings)} rings",
            name=self.name,
            firing=self.firing,
            min_range_m=self.min_range_m,
            max_range_m=self.max_range_m,
        )

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not re.fullmatch(r"[A-Za-z0-9_.-]{1,64}", self.name):
            raise CadetError(f"name: expected 1 to 64 letters, digits, '_', '.' or '-', got {shown(self.name)}")
        if not isinstance(self.rings, tuple) or not all(isinstance(laser, Laser) for laser in self.rings):
            raise CadetError("rings: expected lasers")
        if not 1 <= len(self.rings) <= _MAX_RINGS:
            raise CadetError(f"rings: expected 1 to {_MAX_RINGS} lasers, got {len(self.rings)}")
        if not isinstance(self.firing, (UniformFiring, EncoderFiring, ListedFiring)):
            raise CadetError(f"firing: expected a firing pattern, got {shown(self.firing)}")
        for number, (upper, lower) in enumerate(zip(self.rings, self.rings[1:], strict=False), start=1):
            if lower.elevation_deg >= upper.elevation_deg:
                raise CadetError(
                    f"rings[{number}].elevation_deg: expected below {upper.elevation_deg:g}, that of the ring before, "
                    f"got {lower.elevation_deg:g}"
                )
        if len(self.rings) * self.num_columns > _MAX_BEAMS:
            raise CadetError(f"{len(self.rings)} rings of {self.num_columns} columns: more than {_MAX_BEAMS} beams")
        check_number("lidar", "min_range_m", self.min_range_m, 0, 1000)
        check_number("lidar", "max_range_m", self.max_range_m, 0, 10_000)
        check_number("lidar", "range_noise_m", self.range_noise_m, 0, 10)
        if self.max_range_m <= self.min_range_m:
            raise CadetError(
                f"lidar.max_range_m: expected above min_range_m = {self.min_range_m:g}, got {self.max_range_m:g}"
            )
        make_plain(self)

    @property
    def num_columns(self) -> int:
        """Firings a turn."""
        firing = self.firing
        if isinstance(firing, UniformFiring):
            return firing.columns
        return firing.firings if isinstance(firing, EncoderFiring) else len(firing.azimuths_deg)

    @classmethod
    def read(cls, path: str | Path) -> BeamTable:
        """Read a TOML file.

        Raises:
            MissingFileError: there is no such file.
            CadetError: anything that is wrong with it: one line with the file, its line where known, key and reason.
        """
        path = as_path("path", path)
        data = read_settings(path)
        try:
            return cls.from_toml(data.decode("utf-8"), file=path.name)
        except UnicodeDecodeError as error:
            raise CadetError(f"{path.name}: {error}") from None

    @classmethod
    def from_toml(cls, text: str, file: str = "lidar.toml") -> BeamTable:
        """Read TOML text; `file` names it in messages.

        Raises:
            CadetError: as `read`.
        """
        # Reading endless rings takes minutes.
        if len(text) > _MAX_LETTERS:
            most = f"a sensor of {_MAX_RINGS} rings takes less than {_MAX_LETTERS}"
            raise CadetError(f"{file}: {len(text)} letters, {most}: is this a LIDAR's file?")
        values = toml_from_text(text, file)
        try:
            return _table(values)
        except CadetError as error:
            line = _line_of(str(error), text)
            raise CadetError(f"{file}{'' if line is None else f':{line}'}: {error}") from None

    def to_toml(self) -> str:
        """Return the table as TOML; `from_toml` reads back an equal one."""
        lines = [f'name = "{self.name}"']
        lines += [f"{key} = {_number(getattr(self, key))}" for key in _RANGES]
        lines += ["", "# From the highest ring to the lowest.", "rings = ["]
        for laser in self.rings:
            given = (key for key in _NUMBERS if key == "height_m" or getattr(laser, key) != getattr(Laser, key, None))
            parts = [f"{key} = {_number(getattr(laser, key))}" for key in given]
            if laser.blind_deg:
                sectors = ", ".join(f"[{_number(a)}, {_number(b)}]" for a, b in laser.blind_deg)
                parts.append(f"blind_deg = [{sectors}]")
            lines.append(f"    {{ {', '.join(parts)} }},")
        lines += ["]", "", "[firing]", f'pattern = "{_pattern_of(self.firing)}"']
        for key, value in asdict(self.firing).items():
            lines.append(f"{key} = {[float(v) for v in value] if isinstance(value, tuple) else _number(value)}")
        return "\n".join(lines) + "\n"

    @classmethod
    def from_native(cls, table: _cadet.BeamTable) -> BeamTable:
        """Return the table of a LIDAR of the core."""
        kind = next(kind for kind in _PATTERNS.values() if kind.__name__ == type(table.firing).__name__)
        return cls(
            name=table.name,
            rings=tuple(Laser(**_values_of(Laser, laser)) for laser in table.rings),
            firing=kind(**_values_of(kind, table.firing)),
            **{key: getattr(table, key) for key in _RANGES},
        )

    def to_native(self) -> _cadet.BeamTable:
        """Return the table as the core takes it."""
        kind = getattr(_cadet, type(self.firing).__name__)
        return _cadet.BeamTable(
            name=self.name,
            rings=[_cadet.Laser(**asdict(laser)) for laser in self.rings],
            firing=kind(**asdict(self.firing)),
            **{key: getattr(self, key) for key in _RANGES},
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the table in plain values, for a manifest: a list for each number of the lasers."""
        firing = {key: list(v) if isinstance(v, tuple) else v for key, v in asdict(self.firing).items()}
        return {
            "name": self.name,
            **{key: [float(getattr(laser, key)) for laser in self.rings] for key in _NUMBERS},
            "blind_deg": [[[float(a), float(b)] for a, b in laser.blind_deg] for laser in self.rings],
            "firing": {"pattern": _pattern_of(self.firing), **firing},
            **{key: float(getattr(self, key)) for key in _RANGES},
        }


def _values_of(cls: type[Any], native: object) -> dict[str, Any]:
    """Return what the core's object holds for the fields of a class here."""
    return {f.name: _as_tuples(getattr(native, f.name)) for f in fields(cls)}


def _pattern_of(firing: Firing) -> str:
    return next(name for name, cls in _PATTERNS.items() if isinstance(firing, cls))


def _as_tuples(value: Any) -> Any:
    return tuple(map(_as_tuples, value)) if isinstance(value, list) else value


def _plain_firing(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in values.items()}


def _number(value: float) -> str:
    return str(int(value)) if isinstance(value, int) else repr(float(value))


def _table(values: Mapping[str, Any]) -> BeamTable:
    _check_keys("", values, BeamTable)
    rings = values["rings"]
    if not isinstance(rings, list) or not all(isinstance(ring, Mapping) for ring in rings):
        raise CadetError("rings: expected a list of tables such as { elevation_deg = 2.0, height_m = 0.0 }")
    if len(rings) > _MAX_RINGS:
        raise CadetError(f"rings: expected 1 to {_MAX_RINGS} lasers, got {len(rings)}")
    lasers = []
    for number, ring in enumerate(rings):
        owner = f"rings[{number}]"
        _check_keys(f"{owner}.", ring, Laser)
        try:
            lasers.append(Laser(**{key: _as_tuples(value) for key, value in ring.items()}))
        except CadetError as error:
            raise CadetError(str(error).replace("laser.", f"{owner}.", 1)) from None
    firing = values["firing"]
    if not isinstance(firing, Mapping):
        raise CadetError(f"firing: expected a table, got {shown(firing)}")
    if "pattern" not in firing:
        raise CadetError("firing: missing key 'pattern'")
    cls = _PATTERNS.get(firing["pattern"]) if isinstance(firing["pattern"], str) else None
    if cls is None:
        raise CadetError(f"firing.pattern: expected one of {', '.join(_PATTERNS)}, got {shown(firing['pattern'])}")
    rest = _plain_firing(firing)
    del rest["pattern"]
    _check_keys("firing.", rest, cls)
    return BeamTable(**{**values, "rings": tuple(lasers), "firing": cls(**rest)})


def _check_keys(owner: str, values: Mapping[str, Any], cls: type[Any]) -> None:
    known = {f.name: f.default for f in fields(cls)}
    for key in values:
        if key not in known:
            raise CadetError(f"{owner}{shown_key(key)}: unknown key; known: {', '.join(known)}")
    for key, default in known.items():
        # Dataclass fields without a default hold a marker of the library's own.
        if key not in values and not isinstance(default, (int, float, str, tuple)):
            raise CadetError(f"{owner}{key}: missing key")


def _line_of(message: str, text: str) -> int | None:
    """Return the line that a message about a key means; None where it cannot be told."""
    found = re.match(r"(?:rings\[(\d+)\]\.|firing\.|lidar\.)?(\w+)", message)
    if found is None:
        return None
    lines = [line.split("#", 1)[0] for line in text.splitlines()]
    if found[1] is not None:
        key, wanted = "elevation_deg", int(found[1])
        starts = [n for n, line in enumerate(lines, 1) for _ in re.finditer(rf"\b{key}\s*=", line)]
        # Lasers that lack the key would shift the count.
        return starts[wanted] if len(starts) > wanted and "missing" not in message else None
    return next((n for n, line in enumerate(lines, 1) if re.match(rf"\s*{found[2]}\s*=", line)), None)
