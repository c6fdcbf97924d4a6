"""Maps of other programs: read, or refused by line and road; and what frames are taken of them."""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import CadetError, ResetPolicy, RoadMap, Scene
from cadet.formats.kitti.from_sample import meta_of
from cadet.simulation.episode import Episode
from fuzz.road_text import map_of, road

RIG = cadet.Rig(camera=cadet.Camera.kitti().resized(124, 38), lidar=cadet.Lidar.vlp16())
STREET = map_of(road(1, length_m=300.0))
LEVEL = STREET.replace('b="0.01"', 'b="0"')


def read(tmp_path: Path, text: str) -> tuple[Scene, list[str]]:
    """Build a scene of a map; returns what was warned of."""
    path = tmp_path / "m.xodr"
    path.write_text(text)
    # Warnings are said once of the same text.
    with warnings.catch_warnings(record=True) as caught, pytest.MonkeyPatch.context() as patch:
        patch.setattr("cadet._util.notices._said", set())
        warnings.simplefilter("always")
        scene = Scene.empty(map=path, rig=RIG)
    return scene, [str(warning.message) for warning in caught]


def episode_of(text: str, **changes: Any) -> Episode:
    return Episode(replace(ResetPolicy.kitti(), maps=(RoadMap("m.xodr", text),), **changes), 0, 0)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<OpenDRIVE>", '<OpenDRIVE xmlns="http://code.asam.net/simulation/standard/opendrive_schema">'),
        ('revMinor="6"', 'revMinor="8"'),
        ('<header revMajor="1" revMinor="6"/>', ""),
        ("<planView>", '<link/><type s="0" type="town"><speed max="30" unit="mph"/></type><planView>'),
        ("<planView>", '<link><predecessor/><successor/></link><type s="0"><speed max="no limit"/></type><planView>'),
        ("<planView>", '<userData code="x"><vector travelDir="undirected"/></userData><planView>'),
        ('<elevationProfile><elevation s="0" a="0" b="0.01" c="0" d="0"/></elevationProfile>', ""),
        ('<laneSection s="0">', "<laneSection>"),
        ('<laneSection s="0">', '<laneSection s="-0.001">'),
        ("<laneSection", '<laneOffset s="100" a="1"/><laneOffset s="0" a="0"/><laneSection'),
        ('<lane id="-2"', '<lane id="-3"'),
        ("<line/>", '<spiral curvStart="0" curvEnd="0"/>'),
        ("<line/>", '<paramPoly3 aU="0" bU="300" cU="0" dU="0" aV="0" bV="0" cV="10" dV="0"/>'),
        ('junction="-1"', 'junction=""'),
        ('id="1"', 'id="Straße A"'),
    ],
)
def test_dialects_of_other_programs_are_read(tmp_path: Path, old: str, new: str) -> None:
    assert old in STREET
    scene, _ = read(tmp_path, STREET.replace(old, new, 1))
    (height_m,), *_ = scene.cast_rays([[150.0, -1.6, 30.0]], [[0.0, 0.0, -1.0]])
    assert 20.0 < height_m < 40.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<line/>", '\n<spiral curvEnd="0.5"/>', "m.xodr:5: road 1: <spiral> without curvStart"),
        ("<line/>", "<arc/>", "m.xodr:4: road 1: <arc> without curvature"),
        ("<line/>", "", "m.xodr:4: road 1: <geometry> without <line>, <arc>, <spiral>, <poly3> or <paramPoly3>"),
        (' hdg="0"', "", "m.xodr:4: road 1: <geometry> without hdg"),
        ('id="1" length="300.0"', 'id="1"', "m.xodr:3: road 1: <road> without length"),
        ('a="3.2"', 'a="3,2"', 'm.xodr:8: road 1: <width a>: expected a number from -1e9 to 1e9, got "3,2"'),
        *(
            ("</lane>", f'<{tag} sOffset="0" type="solid" width="{width}"/></lane>', "expected at most 20 m, got")
            for tag in ("roadMark", "line")
            for width in ("1e8", "2147483648", "30000", "inf")
        ),
    ],
)
def test_what_cant_be_built_is_refused_by_line_and_road(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in STREET
    with pytest.raises(CadetError) as refused:
        read(tmp_path, STREET.replace(old, new, 1))
    assert message in str(refused.value)


def test_a_tenth_of_a_millimeter_that_cant_be_built_is_passed_over(tmp_path: Path) -> None:
    piece = '<geometry s="300" x="300" y="0" hdg="0" length="0.0001"><spiral curvEnd="0.5"/></geometry></planView>'
    scene, said = read(tmp_path, STREET.replace("</planView>", piece))
    assert said == ["m.xodr:5: road 1: <spiral> without curvStart: a piece of 0.0001 m passed over"]
    assert scene.num_triangles == read(tmp_path, STREET)[0].num_triangles


@pytest.mark.parametrize(("low_m", "high_m"), [(0, 10), (-6, 0), (0, 2), (0, 0.5)])
def test_roads_that_cross_at_two_heights_have_two_surfaces_or_are_named(
    tmp_path: Path, low_m: float, high_m: float
) -> None:
    def at(height_m: float, text: str) -> str:
        return text.replace('a="0" b="0.01"', f'a="{height_m}" b="0"')

    below = at(low_m, road(1, x=-100.0, length_m=200.0))
    above = at(high_m, road(2, length_m=200.0).replace('y="0.0" hdg="0"', f'y="-100" hdg="{math.pi / 2}"'))
    scene, said = read(tmp_path, map_of(below + above))
    heights = f"m.xodr: roads 2 and 1 cross at heights {high_m} and {low_m} m: a bridge needs 3.5 m "
    assert [line.startswith(heights) for line in said] == [True] * (high_m == 2)
    if high_m - low_m > 3.5:
        from_m = np.array([high_m + 30.0, high_m - 2.0])
        hits = scene.cast_rays([[1.0, 1.0, z] for z in from_m], [[0.0, 0.0, -1.0]] * 2)
        np.testing.assert_allclose(from_m - hits.range_m, [high_m, low_m], atol=0.12)


def test_a_maps_place_on_the_earth_is_kept() -> None:
    projection = "+proj=utm +zone=32 +ellps=WGS84"
    header = f'<header revMajor="1" revMinor="4"><geoReference><![CDATA[{projection}]]></geoReference>'
    placed = re.sub(r"<header[^>]*/>", header + '<offset x="5" y="6" z="7" hdg="0.5"/></header>', STREET)
    meta = meta_of(episode_of(placed).next_sample(0))
    assert meta["map_geo_reference"] == {"projection": projection, "offset_m": [5, 6, 7], "heading_rad": 0.5}
    assert "map_geo_reference" not in meta_of(episode_of(STREET).next_sample(0))


def test_a_far_map_gives_the_frames_of_the_same_map_at_the_origin() -> None:
    def town(x: float, y: float) -> str:
        return map_of(road(1, x=x - 200.0, y=y, length_m=400.0) + road(2, x=x - 200.0, y=y + 40.0, length_m=400.0))

    near = episode_of(town(0.0, 0.0)).next_sample(0)
    for x, y in [(523000.0, 911000.0), (603000.0, 5793000.0), (-25000.0, 0.0)]:
        with pytest.warns(cadet.CadetWarning, match=f"relative to x = {x:.0f}, y = {y:.0f} m of the map"):
            far = episode_of(town(x, y)).next_sample(0)
        assert far.map_offset_m == (x, y)
        np.testing.assert_allclose(far.world_from_ego, near.world_from_ego, atol=1e-6)
        np.testing.assert_allclose(far.plane, near.plane, atol=1e-6)
        assert [s.bbox for s in far._sightings() or ()] == [s.bbox for s in near._sightings() or ()]
    assert meta_of(far)["map_offset_m"] == (-25000.0, 0.0)
    assert "map_offset_m" not in meta_of(near)


@pytest.mark.parametrize("length_m", [10.0, 20.0, 40.0, 120.0])
def test_an_ego_at_its_roads_end_gets_a_new_world(length_m: float) -> None:
    episode = episode_of(map_of(road(1, length_m=length_m)), label=cadet.LabelConfig(min_height_px=1.0))
    samples = [episode.next_sample(number) for number in range(5)]
    places = {(sample.origin["attempt"], *np.round(sample.world_from_ego[:2, 3], 2)) for sample in samples}
    assert len(places) == 5


def test_a_map_that_is_too_short_to_drive_is_refused_at_once() -> None:
    message = (
        r"^m\.xodr: too short to drive: no way along its driving lanes is longer than 5\.0 m, expected 8 m or more$"
    )
    with pytest.raises(CadetError, match=message):
        episode_of(map_of(road(1, length_m=5.0))).next_sample(0)


def test_a_sequence_says_that_the_ego_stands_at_its_roads_end() -> None:
    episode = episode_of(map_of(road(1, length_m=60.0)), time_step_s=5.0)
    with pytest.warns(cadet.CadetWarning, match=r"^m\.xodr: the ego came to the end of its road and stands there"):
        _ = [episode.next_sample(number) for number in range(6)]


def test_a_road_of_no_length_is_passed_over(tmp_path: Path) -> None:
    _, said = read(tmp_path, map_of(road(1) + road(2, length_m=0.0)))
    assert "m.xodr:12: road 2: <road> of length 0: passed over, with the links that lead over it" in said


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<osm/>", "m.xodr: not OpenDRIVE: expected the element <OpenDRIVE> first, got osm"),
        ("hello", "m.xodr:1: not readable as XML: "),
        ('<?xml version="1.0"?><!DOCTYPE html><html/>', "m.xodr:1: not readable as XML: "),
        ("<!-- <OpenDRIVE/> -->", "m.xodr:1: not readable as XML: "),
        ('<OpenDRIVE>\n<road id="1">\n</OpenDRIVE>', "m.xodr:3: not readable as XML: "),
    ],
)
def test_other_formats_are_told_apart(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(CadetError, match=f"^{re.escape(message)}"):
        read(tmp_path, text)


def test_left_hand_maps_are_said_to_be(tmp_path: Path) -> None:
    _, said = read(tmp_path, STREET.replace('junction="-1"', 'junction="-1" rule="LHT"'))
    assert said == [
        'm.xodr: left-hand traffic (rule="LHT"): all keep left, but low beams, signs, poles of lights and steering '
        "wheels are those of right-hand traffic"
    ]


def test_left_hand_traffic_in_user_data_alone_is_told(tmp_path: Path) -> None:
    """RoadRunner's maps of OpenDRIVE 1.4."""

    def with_directions(right: str, left: str) -> str:
        user_data = '<userData><vectorLane travelDir="{}"/></userData></lane>'
        text = re.sub('(id="-1".*?)</lane>', rf"\1{user_data.format(right)}", STREET)
        return re.sub('( id="1" type.*?)</lane>', rf"\1{user_data.format(left)}", text)

    assert not any("travelDir" in line for line in read(tmp_path, with_directions("forward", "backward"))[1])
    _, said = read(tmp_path, with_directions("backward", "forward"))
    assert any(line.startswith("m.xodr: its <vectorLane travelDir> say that traffic keeps left") for line in said)
