"""LIDARs: presets, custom sensors, and how they take a scan."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.checks import check_flag, check_kind, check_number, is_one_of, known_names, make_plain, shown
from cadet._util.summary import summary
from cadet._util.toml_file import NamedFile
from cadet.errors import CadetError
from cadet.sensors.beam_table import BeamTable, LidarFile

RETURN_MODES = tuple(_cadet.Lidar.return_modes())
HOW = ("single_origin", "rolling", "returns", "divergence_mrad")
"""How a scan is taken, besides where the beams go."""
_FILES = {path.stem: path for path in sorted((Path(__file__).parent / "presets" / "lidars").glob("*.toml"))}
LIDAR_PRESETS = (*_cadet.Lidar.presets(), *_FILES)
"""The sensors that the core makes, then those that are data: a file is all that one more takes."""


@dataclass(frozen=True)
class Lidar(LidarFile, NamedFile):
    """A LIDAR's beams, by preset or by a custom table, and how it takes a scan (docs/scan.md).

    Args:
        name: one of `LIDAR_PRESETS`, or the table's name.
        single_origin: all lasers leave one point, where the HDL-64E's sit at different heights.
        table: a sensor that is not a preset; `Lidar.custom` and `Lidar.read` give it its name.
        rolling: the car and all actors move during the turn, which looks forward at the image's instant
            (`BeamTable.spin`, `rate_hz`, `start_azimuth_deg`); points stay in the frame of their own firing, at
            `Scan.time_s`.
        returns: which of the echoes of one pulse are reported: "strongest", "last", "first", "dual" (the strongest and
            the last) or "triple" (the three strongest), each with its `Scan.echo`.
        divergence_mrad: how far a beam opens (the full cone), so that it meets several surfaces at depth edges; 0 for
            beams that meet surfaces as lines do; drops and flakes then see the sensor's own 2 mrad. The HDL-64E's is 2
            to 3.

    Raises:
        CadetError: an unknown preset, a table of another name or that makes no sensor, or a setting out of range.
    """

    _KIND = "lidar"

    name: str = "hdl64e_kitti"
    single_origin: bool = False
    table: BeamTable | None = None
    rolling: bool = False
    returns: str = "strongest"
    divergence_mrad: float = 0.0

    def __post_init__(self) -> None:
        for name in ("single_origin", "rolling"):
            check_flag("Lidar", name, getattr(self, name))
        if not is_one_of(self.returns, RETURN_MODES):
            raise CadetError(f"Lidar.returns: expected one of {', '.join(RETURN_MODES)}, got {shown(self.returns)}")
        check_number("Lidar", "divergence_mrad", self.divergence_mrad, *_cadet.limits()["divergence_mrad"])
        make_plain(self)
        if self.table is None and is_one_of(self.name, _FILES):
            object.__setattr__(self, "table", _shipped(self.name))
        if self.table is not None:
            check_kind("Lidar", "table", self.table, BeamTable)
            if not is_one_of(self.name, (self.table.name,)):
                raise CadetError(f"Lidar.name: expected the table's, {self.table.name!r}, got {shown(self.name)}")
            # What the table's own checks cannot see is refused here rather than in the middle of a run.
            self._to_native()
        elif not is_one_of(self.name, LIDAR_PRESETS):
            raise CadetError(f"unknown lidar {shown(self.name)}; {known_names(self.name, LIDAR_PRESETS)}")

    def __repr__(self) -> str:
        changed = {f.name: getattr(self, f.name) for f in fields(self)[1:] if getattr(self, f.name) != f.default}
        if self._is_shipped():
            del changed["table"]
        return summary(self, name=self.name, **changed)

    @classmethod
    def hdl64e_kitti(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """The Velodyne of KITTI: 64 lasers, each with its own elevation and height, 137,728 beams a turn."""
        return cls("hdl64e_kitti", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def hdl64e_uniform(
        cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0
    ) -> Lidar:
        """KITTI's elevations from one point in 2,083 uniform columns: 133,312 beams, the benchmark's scan."""
        return cls("hdl64e_uniform", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def cadet(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """The 2019 paper's LIDAR: 40 beams from +7 to -16 degrees."""
        return cls("cadet", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def hdl32e(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """Velodyne's HDL-32E: 32 lasers from +10.67 to -30.67 degrees, 2,170 columns a turn."""
        return cls("hdl32e", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def vlp16(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """Velodyne's VLP-16: 16 lasers from +15 to -15 degrees, 1,808 columns a turn."""
        return cls("vlp16", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def os1_64(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """A sensor like Ouster's OS1-64: 64 lasers from +22.5 to -22.5 degrees, 1,024 columns a turn."""
        return cls("os1_64", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def os1_128(cls, *, rolling: bool = False, returns: str = "strongest", divergence_mrad: float = 0.0) -> Lidar:
        """A sensor like Ouster's OS1-128: 128 lasers from +22.5 to -22.5 degrees, 2,048 columns a turn."""
        return cls("os1_128", rolling=rolling, returns=returns, divergence_mrad=divergence_mrad)

    @classmethod
    def rs_m1(cls, *, rolling: bool = False, returns: str = "strongest") -> Lidar:
        """A sensor like RoboSense's RS-LiDAR-M1: a raster of 120 x 25 degrees in five columns, 78,750 beams."""
        return cls("rs_m1", rolling=rolling, returns=returns)

    @classmethod
    def livox_mid40(cls, *, rolling: bool = False, returns: str = "strongest") -> Lidar:
        """Livox's Mid-40: a rosette in a cone of 38.4 degrees, 10,000 beams that go on from scan to scan."""
        return cls("livox_mid40", rolling=rolling, returns=returns)

    @classmethod
    def custom(cls, table: BeamTable) -> Lidar:
        """A custom sensor.

        Raises:
            CadetError: no table, or one that makes no sensor.
        """
        check_kind("Lidar", "table", table, BeamTable)
        return cls(table.name, table=table)

    @classmethod
    def _presets(cls) -> Mapping[str, Callable[[], Lidar]]:
        return {name: partial(cls, name) for name in LIDAR_PRESETS}

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> Lidar:
        how = {key: table[key] for key in HOW if key in table}
        beams = {key: value for key, value in table.items() if key not in how}
        if beams.keys() == {"name"}:
            return cls(beams["name"], **how)
        made = BeamTable._of_table(beams, folder, place)
        return cls(made.name, table=made, **how)

    def _table(self) -> dict[str, Any]:
        how = {key: getattr(self, key) for key in HOW if getattr(self, key) != getattr(Lidar, key)}
        beams = {"name": self.name} if self.table is None or self._is_shipped() else self.table._table()
        return {**how, **beams}

    def beam_table(self) -> BeamTable:
        """Return every laser and number of the sensor, presets' too."""
        return BeamTable._from_native(self._to_native().table())

    def rays(
        self, *, time_s: float = 0.0
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
        """Return every beam of a scan, in the order of an ideal scan's rows.

        Args:
            time_s: the scan's instant, which a rosette depends on: seconds since the scene's start.

        Returns:
            origins_velo (B, 3) meters, directions_velo (B, 3) of unit length, ring (B,) from the top, column (B,).
        """
        check_number("", "time_s", time_s, -1e9, 1e9)
        return self._to_native().rays(time_s=float(time_s))

    def range_m(self) -> list[float]:
        """Return the nearest and the farthest range, meters."""
        beams = self._to_native().table()
        return [beams["min_range_m"], beams["max_range_m"]]

    def to_dict(self) -> dict[str, Any]:
        """Return the sensor in plain values, for a manifest."""
        return {
            "lidar": self.name if self.table is None or self._is_shipped() else self.table.to_dict(),
            "single_origin": self.single_origin,
            "rolling": self.rolling,
            "returns": self.returns,
            "divergence_mrad": float(self.divergence_mrad),
        }

    def _to_native(self) -> _cadet.Lidar:
        """Return the core's LIDAR; the last few made are kept, as each holds tables of its beams."""
        return _native_of(self)

    def _is_shipped(self) -> bool:
        """Tell whether the table is the one that its name stands for."""
        return self.name in _FILES and self.table == _shipped(self.name)

    def _make_native(self) -> _cadet.Lidar:
        native = _cadet.Lidar.preset(self.name) if self.table is None else _cadet.Lidar.from_table(self.table)
        native = native.single_origin() if self.single_origin else native
        return native.scanning(rolling=self.rolling, returns=self.returns, divergence_mrad=float(self.divergence_mrad))


@cache
def _shipped(name: str) -> BeamTable:
    table = BeamTable.read(_FILES[name])
    if table.name != name:
        raise CadetError(f"{_FILES[name].name}: name: expected {name!r}, got {table.name!r}")
    return table


@lru_cache(maxsize=8)
def _native_of(lidar: Lidar) -> _cadet.Lidar:
    return lidar._make_native()
