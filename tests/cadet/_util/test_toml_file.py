"""TOML in both directions: what an object writes is read as an equal one, whatever it holds."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

import cadet
from cadet import CadetError
from cadet._util.plain_tables import toml_of_table
from cadet.sensors.lidar import LIDAR_PRESETS
from cadet.sensors.rig import RIG_PRESETS
from cadet.worlds.policy import POLICIES

_FIRING = cadet.EncoderFiring(ticks_per_turn=4000, ticks_per_firing=1.5, firings=2000, phase_ticks=0.25)
_BEAMS = cadet.BeamTable(
    name="mine",
    rings=(cadet.Laser(elevation_deg=1 / 3, blind_deg=((0.0, 20.5),)), cadet.Laser(elevation_deg=-1e-7, gain=0.5)),
    firing=_FIRING,
)
_OWN = cadet.Lidar("mine", table=_BEAMS, rolling=True, returns="last", divergence_mrad=3.0)
_CROWDED = cadet.SceneConfig(num_cars=80, label=cadet.LabelConfig(occlusion_levels=(0.7, 0.4)), sun_azimuth_deg=0.1)


def _suite() -> cadet.Rig:
    """Return a rig whose frame begins beside the ego's, with sensors at thirds of meters."""
    pose = cadet.Pose.of_angles((1 / 3, -0.1, 1.7), roll_deg=1, pitch_deg=-2, yaw_deg=33.3)
    camera = cadet.Camera.kitti().resized(621, 188)
    rig = (
        cadet.Rig.kitti()
        .with_lidar(_OWN)
        .with_sensors(
            cadet.MountedLidar(name="side", lidar=cadet.Lidar.vlp16(rolling=True), pose=pose),
            cadet.MountedCamera(name="rear", camera=replace(camera, distortion=(0.1, 0.0, 0.0, 0.0, 0.0)), pose=pose),
        )
    )
    return replace(rig, origin_in_ego_m=(-1.385, 0.1, 0.0))


OBJECTS: dict[str, Any] = {
    **{f"lidar {name}": cadet.Lidar(name) for name in LIDAR_PRESETS},
    **{f"rig {name}": cadet.Rig.named(name) for name in RIG_PRESETS},
    **{f"policy {name}": cadet.ResetPolicy.named(name) for name in POLICIES},
    "beams": _BEAMS,
    "lidar of one's own": _OWN,
    "one origin": cadet.Lidar("hdl64e_kitti", single_origin=True),
    "camera": cadet.Camera.kitti(calibration="2011_10_03"),
    "rig of one's own": _suite(),
    "district": cadet.District.named("inner_city"),
    "nothing given": cadet.SceneConfig(),
    "scene": _CROWDED,
    "labels": cadet.LabelConfig(method="corners", max_depth_m=50.0),
    "rules": cadet.Rules((cadet.Level("Near", 40.0, max_occlusion=1.0),), (cadet.EvalClass("V", ("Car",), 0.5),)),  # type: ignore[arg-type]
    "sequence": cadet.ResetPolicy.kitti().as_sequence(hz=10, length_s=3).with_rig(_suite()),
    "simulation": cadet.Simulation(replace(cadet.ResetPolicy.paper(), sun_elevation_deg=(10.0, 20.0)), 7),
}


@pytest.mark.parametrize("name", OBJECTS)
def test_what_is_written_is_read_as_an_equal_object(name: str, tmp_path: Path) -> None:
    one = OBJECTS[name]
    text = one.to_toml()
    again = type(one).from_toml(text)
    assert again == one and again.to_toml() == text
    (tmp_path / "one.toml").write_text(text, encoding="utf-8")
    assert type(one).read(tmp_path / "one.toml") == one


def test_a_configuration_keeps_what_was_given() -> None:
    again = cadet.SceneConfig.from_toml(_CROWDED.to_toml())
    assert again.given == _CROWDED.given and again.label.given == {"occlusion_levels"}
    drawn = cadet.SceneConfig(num_cars=3, num_trams=2)
    assert again.over(drawn) == _CROWDED.over(drawn)


_PLAIN = st.booleans() | st.integers(-(2**63), 2**63) | st.floats(allow_nan=False) | st.text()
_TABLES = st.dictionaries(
    st.text(),
    st.recursive(_PLAIN, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4)),
    max_size=5,
)


@given(_TABLES)
def test_any_table_is_written_as_toml(table: dict[str, Any]) -> None:
    assert tomllib.loads(toml_of_table(table)) == table


def test_a_rig_names_lidars_of_files_beside_it(tmp_path: Path) -> None:
    rig = cadet.Rig.kitti().to_toml().replace('lidar = "hdl64e_kitti"', 'lidar = "own.toml"\nreturns = "strongest"')
    (tmp_path / "own.toml").write_text(_OWN.to_toml())
    (tmp_path / "rig.toml").write_text(rig)
    (tmp_path / "town.toml").write_text('rig = "rig.toml"\nrolling = false')
    assert cadet.Rig.named(tmp_path / "rig.toml").lidar == replace(_OWN, returns="strongest")
    ((found, _),) = cadet.Simulation.read(tmp_path / "town.toml").policy.rigs
    assert found.lidar == replace(_OWN, returns="strongest", rolling=False)
    (tmp_path / "own.toml").write_text(_OWN.to_toml().replace("gain", "gian"))
    with pytest.raises(CadetError, match=r"/rig\.toml: lidar\[0\]\.lidar: .*/own\.toml:\d+: rings\[1\]\.gian: unknown"):
        cadet.Rig.read(tmp_path / "rig.toml")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("roll_pitch_yaw_deg", "roll_deg", r"lidar\[0\]\.roll_deg: unknown key; known: name, lidar"),
        ('lidar = "hdl64e_kitti"', "lidar = 3", r"lidar\[0\]\.lidar: unknown lidar 3; known: hdl64e_kitti"),
        (
            "position_in_ego_m = [",
            "position_m = [0, 0, 0]\nposition_in_ego_m = [",
            r"lidar\[0\]\.position_m: expected one",
        ),
        ("width = 1242", "", r"camera\[0\]\.width: missing key"),
        ("fx = 721.5377", 'fx = "wide"', r"camera\[0\]\.fx: expected a number, got 'wide'"),
        ("fx = 721.5377", "fx = 0", r"camera\[0\]: Camera\.fx: expected a number from 1"),
        ("[camera.extrinsics]", "[camera.extrinsic]", r"camera\[0\]\.extrinsic: unknown key"),
    ],
)
def test_what_is_wrong_with_a_rig_is_said_by_key(old: str, new: str, message: str) -> None:
    text = cadet.Rig.kitti().to_toml()
    assert old in text
    with pytest.raises(CadetError, match=rf"^mine\.toml: {message}"):
        cadet.Rig.from_toml(text.replace(old, new, 1), file="mine.toml")


def test_maps_and_assets_are_files_that_toml_names() -> None:
    with pytest.raises(CadetError, match="name their files in it"):
        replace(cadet.ResetPolicy.kitti(), maps=(cadet.RoadMap("town", "<OpenDRIVE/>"),)).to_toml()
