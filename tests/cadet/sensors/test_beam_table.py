"""LIDARs of one's own: TOML there and back, every kind of mistake in one line, beams as the table says."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cadet import BeamTable, CadetError, EncoderFiring, Laser, Lidar, ListedFiring, MissingFileError, UniformFiring
from cadet.cli import run_cadet
from cadet.sensors.firing import Firing
from cadet.sensors.lidar import LIDAR_PRESETS

TEXT = """\
name = "mine"
min_range_m = 0.5
max_range_m = 60.0

# Three lasers.
rings = [
    { elevation_deg = 10.0, height_m = 0.01, azimuth_offset_deg = 0.05 },
    { elevation_deg = 0.0, gain = 0.5, range_offset_m = -0.02 },
    { elevation_deg = -12.5, blind_deg = [[0.0, 20.5], [340, 360]] },
]

[firing]
pattern = "encoder"
ticks_per_turn = 3600
ticks_per_firing = 1.5
firings = 2400
"""


def test_a_file_says_what_its_table_says(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(TEXT)
    table = BeamTable.read(path)
    assert table == BeamTable(
        name="mine",
        rings=(
            Laser(elevation_deg=10.0, height_m=0.01, azimuth_offset_deg=0.05),
            Laser(elevation_deg=0.0, gain=0.5, range_offset_m=-0.02),
            Laser(elevation_deg=-12.5, blind_deg=((0.0, 20.5), (340, 360))),
        ),
        firing=EncoderFiring(ticks_per_turn=3600, ticks_per_firing=1.5, firings=2400),
        min_range_m=0.5,
        max_range_m=60.0,
        range_noise_m=0.0078,
    )
    assert BeamTable.from_toml(table.to_toml()) == table


FIRINGS = st.one_of(
    st.builds(UniformFiring, columns=st.integers(1, 1000)),
    st.builds(
        EncoderFiring,
        ticks_per_turn=st.just(4000),
        ticks_per_firing=st.floats(1.0, 3.0),
        firings=st.integers(1, 1000),
        phase_ticks=st.floats(0.0, 2.0),
    ),
    st.lists(st.floats(0.0, 359.0), min_size=1, max_size=20, unique=True).map(
        lambda azimuths: ListedFiring(azimuths_deg=tuple(sorted(azimuths)))
    ),
)


@settings(max_examples=60, deadline=None)
@given(
    elevations=st.lists(st.floats(-80.0, 80.0), min_size=1, max_size=12, unique=True),
    height_m=st.floats(-1.0, 1.0),
    gain=st.floats(0.0, 10.0),
    firing=FIRINGS,
    ranges=st.tuples(st.floats(0.0, 10.0), st.floats(10.5, 500.0)),
)
def test_toml_keeps_every_bit(
    elevations: list[float], height_m: float, gain: float, firing: Firing, ranges: tuple[float, float]
) -> None:
    lasers = tuple(Laser(elevation_deg=e, height_m=height_m, gain=gain) for e in sorted(elevations, reverse=True))
    table = BeamTable(name="any", rings=lasers, firing=firing, min_range_m=ranges[0], max_range_m=ranges[1])
    assert BeamTable.from_toml(table.to_toml()) == table


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("max_range_m", "max_range", "mine.toml:3: max_range: unknown key; known: name, rings, firing, min_range_m,"),
        ('name = "mine"\n', "", "mine.toml: name: missing key"),
        ('"mine"', '"my lidar"', "mine.toml:1: name: expected 1 to 64 letters, digits, '_', '.' or '-', got 'my"),
        ("min_range_m = 0.5", "min_range_m = nan", "mine.toml:2: lidar.min_range_m: expected a number from 0 to"),
        ("max_range_m = 60.0", "max_range_m = 0.1", "mine.toml:3: lidar.max_range_m: expected above min_range_m = 0.5"),
        ("min_range_m = 0.5", "min_range_m = true", "mine.toml:2: lidar.min_range_m: expected a number from 0 to"),
        ("gain = 0.5", "gain = inf", "mine.toml:8: rings[1].gain: expected a number from 0 to 100, got inf"),
        ("-0.02", "1.5", "mine.toml:8: rings[1].range_offset_m: expected a number from -1 to 1, got 1.5"),
        ("-0.02", "nan", "mine.toml:8: rings[1].range_offset_m: expected a number from -1 to 1, got nan"),
        ("gain = 0.5", "gian = 0.5", "mine.toml:8: rings[1].gian: unknown key; known: elevation_deg, height_m,"),
        ("elevation_deg = 0.0,", "", "mine.toml: rings[1].elevation_deg: missing key"),
        ("= -12.5", "= 0.0", "mine.toml:9: rings[2].elevation_deg: expected below 0, that of the ring before, got 0"),
        ("= -12.5", "= -91", "mine.toml:9: rings[2].elevation_deg: expected a number from -89 to 89, got -91"),
        ("0.01", '"low"', "mine.toml:7: rings[0].height_m: expected a number from -10 to 10, got 'low'"),
        ("20.5", "-20.5", "mine.toml:9: rings[2].blind_deg: expected a number from 0 to 360, got -20.5"),
        ("[0.0, 20.5]", "[30, 20.5]", "mine.toml:9: rings[2].blind_deg: expected azimuths that rise, got 30 to 20.5"),
        ("[[0.0, 20.5], [340, 360]]", "5", "mine.toml:9: rings[2].blind_deg: expected pairs of azimuths such as"),
        (
            '"encoder"',
            '"spiral"',
            "mine.toml:13: firing.pattern: expected one of uniform, encoder, listed, raster, rosette, table, got",
        ),
        ('pattern = "encoder"\n', "", "mine.toml: firing: missing key 'pattern'"),
        ("ticks_per_turn", "columns", "mine.toml:14: firing.columns: unknown key; known: ticks_per_turn,"),
        ("firings = 2400\n", "", "mine.toml: firing.firings: missing key"),
        ("firings = 2400", "firings = 2.5", "mine.toml:16: firing.firings: expected a whole number from 1 to 65535"),
        ("= 1.5", "= 0.5", "mine.toml:15: firing.ticks_per_firing: expected a number from 1 to 1e+09, got 0.5"),
        (
            "[firing]",
            "[firing",
            "mine.toml: invalid TOML: Expected ']' at the end of a table declaration (at line 12, column 8)",
        ),
    ],
)
def test_a_mistake_is_one_line_with_file_line_and_key(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert TEXT.count(old) >= 1
    path = tmp_path / "mine.toml"
    path.write_text(TEXT.replace(old, new, 1))
    with pytest.raises(CadetError) as caught:
        BeamTable.read(path)
    assert str(caught.value).startswith(f"{tmp_path}/{message}")
    assert "\n" not in str(caught.value)


def test_a_missing_or_binary_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"nowhere.toml: no such file"):
        Lidar.read(tmp_path / "nowhere.toml")
    path = tmp_path / "binary.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(CadetError, match=r"/binary\.toml: .*'utf-8'"):
        Lidar.read(path)


ENDLESS = "1" + "0" * 400


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "max_range_m = 60.0",
            f"max_range_m = {ENDLESS}",
            r"mine\.toml:3: max_range_m: a whole number of 401 digits",
        ),
        (
            "gain = 0.5",
            f"gain = {ENDLESS}",
            r"mine\.toml:8: rings\[1\]\.gain: a whole number of 401 digits",
        ),
        ("= 1.5", f"= {ENDLESS}", r"mine\.toml:15: firing\.ticks_per_firing: a whole number of"),
        ("[[0.0, 20.5], [340, 360]]", f"[{'[1, 2], ' * 400}]", r"mine\.toml:9: .*at most 360 sectors, got 400"),
        ("rings = [", "rings = [" + "{ elevation_deg = 9 },\n" * 5000, "rings: expected 1 to 4096 lasers, got 500"),
        (
            "rings = [",
            "rings = [" + "{ elevation_deg = 9 },\n" * 1_000_000,
            r"mine\.toml: \d+ letters, .*a LIDAR's file\?",
        ),
    ],
    ids=["range", "gain", "ticks", "sectors", "rings", "a million rings"],
)
def test_endless_numbers_and_lists_are_refused_at_once(old: str, new: str, message: str) -> None:
    started = time.monotonic()
    with pytest.raises(CadetError, match=message) as caught:
        BeamTable.from_toml(TEXT.replace(old, new, 1), file="mine.toml")
    assert time.monotonic() - started < 5.0 and len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ListedFiring(azimuths_deg=(0.0, 2.0, 1.0)), "expected rising numbers below 360, got 1.0 after 2.0"),
        (lambda: ListedFiring(azimuths_deg=(0.0, 360.0)), "expected rising numbers below 360, got 360.0 after 360.0"),
        (lambda: ListedFiring(azimuths_deg=()), "expected a list of 1 to 65535 numbers"),
        (
            lambda: BeamTable(name="x", rings=(), firing=UniformFiring(columns=4)),
            "rings: expected 1 to 4096 lasers, got 0",
        ),
        (
            lambda: BeamTable(
                name="x",
                rings=tuple(Laser(elevation_deg=40.0 - 0.02 * k) for k in range(4000)),
                firing=UniformFiring(columns=60_000),
            ),
            "4000 rings of 60000 columns: more than 8388608 beams",
        ),
    ],
)
def test_nonsense_is_refused(make: Any, message: str) -> None:
    with pytest.raises(CadetError) as caught:
        make()
    assert message in str(caught.value)


def cadet(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int | str | None:
    monkeypatch.setattr(sys, "argv", ["cadet", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        run_cadet()
    return ended.value.code


class TestOnTheCore:
    @pytest.mark.parametrize("name", LIDAR_PRESETS)
    def test_presets_come_back_from_toml_with_the_same_beams(self, name: str, tmp_path: Path) -> None:
        preset = Lidar(name)
        path = tmp_path / "again.toml"
        path.write_text(preset.to_toml())
        again = Lidar.read(path)
        assert again.beam_table() == preset.beam_table()
        for ours, theirs in zip(again.rays()[:2], preset.rays()[:2], strict=True):
            # Files hold a billionth of a degree.
            np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-9)

    def test_beams_are_where_the_table_says(self) -> None:
        lidar = Lidar.custom(BeamTable.from_toml(TEXT))
        origins, directions, ring, column = lidar.rays()
        assert len(ring) == 3 * 2400
        azimuth_deg = 1.5 * column * 0.1 + np.array([0.05, 0.0, 0.0])[ring]
        elevation_deg = np.array([10.0, 0.0, -12.5])[ring]
        np.testing.assert_array_equal(origins, np.outer(np.array([0.01, 0.0, 0.0])[ring], [0.0, 0.0, 1.0]))
        expected = np.stack(
            [
                np.cos(np.radians(elevation_deg)) * np.cos(np.radians(azimuth_deg)),
                np.cos(np.radians(elevation_deg)) * np.sin(np.radians(azimuth_deg)),
                np.sin(np.radians(elevation_deg)),
            ],
            axis=1,
        )
        np.testing.assert_allclose(directions, expected, rtol=0.0, atol=1e-12)

    def test_what_only_the_core_can_see_is_refused_too(self, tmp_path: Path) -> None:
        path = tmp_path / "mine.toml"
        path.write_text(TEXT.replace("firings = 2400", "firings = 2401"))
        with pytest.raises(CadetError, match=r"/mine\.toml: .*last firing is 3600.*below 3600"):
            Lidar.read(path)
        path.write_text(TEXT.replace("azimuth_offset_deg = 0.05", "azimuth_offset_deg = 0.25"))
        with pytest.raises(CadetError, match=r"/mine\.toml: azimuth offset is"):
            Lidar.read(path)

    def test_names_and_files(self, tmp_path: Path) -> None:
        assert Lidar.named("vlp16") == Lidar.vlp16()
        (tmp_path / "mine.toml").write_text(TEXT)
        assert Lidar.named(tmp_path / "mine.toml").name == "mine"
        with pytest.raises(CadetError, match=r"unknown lidar 'vlp32'; known: .*or the path of a file"):
            Lidar.named("vlp32")
        with pytest.raises(CadetError, match=r"Lidar\.name: expected the table's, 'mine', got 'yours'"):
            Lidar("yours", table=BeamTable.from_toml(TEXT))

    def test_the_command_prints_a_sensor(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
    ) -> None:
        assert cadet(monkeypatch, "lidar", "vlp16") == 0
        assert BeamTable.from_toml(capsys.readouterr().out) == Lidar.vlp16().beam_table()
        (tmp_path / "bad.toml").write_text(TEXT.replace("gain", "gian"))
        assert cadet(monkeypatch, "lidar", tmp_path / "bad.toml") == 2
        assert capsys.readouterr().err.startswith(f"cadet: {tmp_path}/bad.toml:8: rings[1].gian: unknown key")


def test_a_manifest_has_the_same_numbers_however_they_were_written() -> None:
    table = Lidar.vlp16().beam_table()
    whole = replace(table, min_range_m=1, rate_hz=10, start_azimuth_deg=180)
    assert json.dumps(whole.to_dict()) == json.dumps(table.to_dict())
