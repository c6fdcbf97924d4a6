"""A LIDAR's beams in numbers: its lasers, where they point and what they reach; as a TOML file, read and written."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, TypeVar

from cadet._util.checks import Limits, check_fields, check_number, is_one_of, make_plain, shown
from cadet._util.plain_tables import check_keys_of, table_of_object
from cadet._util.summary import summary
from cadet._util.toml_file import TomlFile
from cadet.errors import CadetError, FileFormatError
from cadet.sensors.firing import (
    FIRINGS,
    TURNING,
    Firing,
    as_tuples,
    firing_of_fields,
    firing_of_table,
    num_columns_of,
    pattern_of,
)

L = TypeVar("L", bound="LidarFile")

_MAX_BEAMS = 1 << 23
_MAX_RINGS = 4096
_MAX_SECTORS = 360
_MAX_LETTERS = 1 << 22


@dataclass(frozen=True, kw_only=True)
class Laser:
    """One laser: a ring of the scan.

    Raises:
        CadetError: a number outside its range.
    """

    elevation_deg: Annotated[float, Limits(-89, 89)]
    """Of the beam over the horizon."""
    height_m: Annotated[float, Limits(-10, 10)] = 0.0
    """Where the beam leaves the sensor, over the origin of its frame."""
    left_m: Annotated[float, Limits(-0.5, 0.5)] = 0.0
    """How far to the left of the axis the laser sits, as it looks: its beams pass the axis at this distance."""
    azimuth_offset_deg: Annotated[float, Limits(-360, 360)] = 0.0
    """The laser fires this much counter-clockwise of its columns' azimuths."""
    gain: Annotated[float, Limits(0, 100)] = 1.0
    """Sensitivity of the receiver: below 1 it reports more zero intensities."""
    range_offset_m: Annotated[float, Limits(-1, 1)] = 0.0
    """By how much the laser measures too far: its points lie farther along their beams. Ideal scans have none."""
    focus_m: Annotated[float, Limits(0, 1000)] = 6.0
    """Of what comes from nearer than this, (range / focus)^3 of the power counts for detection."""
    blind_deg: tuple[tuple[float, float], ...] = ()
    """Azimuths (from, to) at which what carries the sensor is in the way: beams there never return."""

    def __post_init__(self) -> None:
        check_fields(self, "laser")
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


_NUMBERS = tuple(f.name for f in fields(Laser) if f.name != "blind_deg")
_PLAIN = (
    "min_range_m",
    "max_range_m",
    "range_noise_m",
    "detection_range_m",
    "beam_mrad",
    "pulse_ns",
    "halo_share",
    "halo_mrad",
    "spin",
    "rate_hz",
    "start_azimuth_deg",
)
"""The fields of a table that are plain values."""
SPINS = ("cw", "ccw")


class LidarFile(TomlFile):
    """A `TomlFile` whose messages name the line, too, where it is known."""

    @classmethod
    def from_toml(cls: type[L], text: str | bytes, *, file: str = "TOML", folder: str | Path = ".") -> L:
        """Return what the text of a TOML file says (docs/lidars.md).

        Raises:
            CadetError: anything that is wrong with it, in one line with `file`, key and reason; text too long for a
                LIDAR, as reading endless rings takes minutes.
        """
        if isinstance(text, str | bytes) and len(text) > _MAX_LETTERS:
            most = f"a sensor of {_MAX_RINGS} rings takes less than {_MAX_LETTERS}"
            raise FileFormatError(f"{len(text)} letters, {most}: is this a LIDAR's file?", file)
        try:
            return super().from_toml(text, file=file, folder=folder)
        except FileFormatError as error:
            line = _line_of(error.reason, text.decode(errors="replace") if isinstance(text, bytes) else text)
            if error.file != file or error.line is not None or line is None:
                raise
            raise FileFormatError(error.reason, file, line) from None


@dataclass(frozen=True, kw_only=True)
class BeamTable(LidarFile):
    """A LIDAR: lasers that fire together, pointed by a head that spins or along a path.

    Raises:
        CadetError: a number outside its range, rings that are not in the order of their elevations, or a number of
            spinning LIDARs for one that does not spin.
    """

    name: str
    """Letters, digits, `_`, `.` and `-`."""
    rings: tuple[Laser, ...]
    """From the highest elevation to the lowest, the order of the rings in a scan's file; any if it does not spin."""
    firing: Firing
    """Where they point when all of them fire."""
    min_range_m: Annotated[float, Limits(0, 1000)] = 1.45
    """Nearer returns are not kept."""
    max_range_m: Annotated[float, Limits(0, 10_000)] = 80.0
    """Returns as far as this are not kept."""
    range_noise_m: Annotated[float, Limits(0, 10)] = 0.0078
    """Standard deviation of the range."""
    detection_range_m: Annotated[float, Limits(0.1, 10_000)] = 79.0
    """Where a target of 10 % that faces the sensor is detected half of the time, as data sheets state it. The default
    is fitted to KITTI's cars."""
    beam_mrad: Annotated[float, Limits(0.01, 20)] = 2.0
    """Full cone of a beam, in which drops and flakes are met; `Lidar.divergence_mrad` also splits beams at edges."""
    pulse_ns: Annotated[float, Limits(0.1, 100)] = 5.0
    """Half-power width of a pulse: echoes within half the way that light goes in it are one."""
    halo_share: Annotated[float, Limits(0, 0.1)] = 0.0
    """Share of a pulse that the optics scatter about the beam, so that retroreflectors bloom: beams that pass beside a
    sign return it too. KITTI's sensor shows none; with 1e-4 signs bloom to 70 m. For sensors that spin."""
    halo_mrad: Annotated[float, Limits(0, 100)] = 10.0
    """Half the cone of that halo."""
    spin: str = "cw"
    """Which way it turns, seen from above: one of `SPINS`, clockwise or counter-clockwise."""
    rate_hz: Annotated[float, Limits(1, 100)] = 10.0
    """Turns a second; scans a second of a raster and a rosette."""
    start_azimuth_deg: Annotated[float, Limits(0, 360)] = 180.0
    """Where a turn begins and ends, counter-clockwise from forward; the beam looks forward at the image's instant."""

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
        if not isinstance(self.firing, tuple(FIRINGS.values())):
            raise CadetError(f"firing: expected a firing pattern, got {shown(self.firing)}")
        if isinstance(self.firing, TURNING):
            _check_order(self.rings)
        if len(self.rings) * self.num_columns > _MAX_BEAMS:
            raise CadetError(f"{len(self.rings)} rings of {self.num_columns} columns: more than {_MAX_BEAMS} beams")
        check_fields(self, "lidar")
        if not is_one_of(self.spin, SPINS):
            raise CadetError(f"lidar.spin: expected one of {', '.join(SPINS)}, got {shown(self.spin)}")
        if self.max_range_m <= self.min_range_m:
            raise CadetError(
                f"lidar.max_range_m: expected above min_range_m = {self.min_range_m:g}, got {self.max_range_m:g}"
            )
        if not isinstance(self.firing, TURNING):
            _check_path(self)
        make_plain(self)

    @property
    def num_columns(self) -> int:
        """Firings of a scan."""
        return num_columns_of(self.firing)

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> BeamTable:
        check_keys_of(BeamTable, table)
        rings = table["rings"]
        if not isinstance(rings, list) or not all(isinstance(ring, Mapping) for ring in rings):
            raise CadetError("rings: expected a list of tables such as { elevation_deg = 2.0, height_m = 0.0 }")
        if len(rings) > _MAX_RINGS:
            raise CadetError(f"rings: expected 1 to {_MAX_RINGS} lasers, got {len(rings)}")
        lasers = []
        for number, ring in enumerate(rings):
            owner = f"rings[{number}]"
            check_keys_of(Laser, ring, owner)
            try:
                lasers.append(Laser(**{key: as_tuples(value) for key, value in ring.items()}))
            except CadetError as error:
                raise CadetError(str(error).replace("laser.", f"{owner}.", 1)) from None
        return cls(**{**table, "rings": tuple(lasers), "firing": firing_of_table(table["firing"], folder)})

    def _table(self) -> dict[str, Any]:
        rings = [_ring(laser) for laser in self.rings]
        firing = {"pattern": pattern_of(self.firing), **table_of_object(self.firing)}
        return {"name": self.name, **{key: getattr(self, key) for key in _PLAIN}, "rings": rings, "firing": firing}

    @classmethod
    def _from_native(cls, table: Mapping[str, Any]) -> BeamTable:
        """Return the table of a LIDAR of the core, which gives it in plain values."""
        rings = tuple(Laser(**_with_tuples(laser)) for laser in table["rings"])
        return cls(**{**table, "rings": rings, "firing": firing_of_fields(_with_tuples(table["firing"]))})

    def to_dict(self) -> dict[str, Any]:
        """Return the table in plain values, for a manifest: a list for each number of the lasers."""
        firing = {key: list(v) if isinstance(v, tuple) else v for key, v in asdict(self.firing).items()}
        return {
            "name": self.name,
            **{key: [float(getattr(laser, key)) for laser in self.rings] for key in _NUMBERS},
            "blind_deg": [[[float(a), float(b)] for a, b in laser.blind_deg] for laser in self.rings],
            "firing": {"pattern": pattern_of(self.firing), **firing},
            **{key: v if isinstance(v := getattr(self, key), str) else float(v) for key in _PLAIN},
        }


def _check_order(rings: tuple[Laser, ...]) -> None:
    for number, (upper, lower) in enumerate(pairwise(rings), start=1):
        if lower.elevation_deg >= upper.elevation_deg:
            raise CadetError(
                f"rings[{number}].elevation_deg: expected below {upper.elevation_deg:g}, that of the ring before, "
                f"got {lower.elevation_deg:g}"
            )


def _check_path(table: BeamTable) -> None:
    """Refuse what only a LIDAR that spins has."""
    usual = {f.name: f.default for f in fields(BeamTable)}
    for key in ("spin", "start_azimuth_deg", "halo_share"):
        if getattr(table, key) != usual[key]:
            raise CadetError(f"lidar.{key}: expected none for a LIDAR that does not spin, got {getattr(table, key)}")
    for number, laser in enumerate(table.rings):
        if laser.left_m != 0.0:
            raise CadetError(f"rings[{number}].left_m: expected 0 for a LIDAR that does not spin, got {laser.left_m:g}")


def _with_tuples(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: as_tuples(value) for key, value in values.items()}


def _ring(laser: Laser) -> dict[str, Any]:
    """Return a laser's numbers that are not the default, its height among them all the same."""
    values = table_of_object(laser)
    usual = {f.name: f.default for f in fields(Laser) if f.name != "height_m"}
    return {key: value for key, value in values.items() if getattr(laser, key) != usual.get(key)}


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
