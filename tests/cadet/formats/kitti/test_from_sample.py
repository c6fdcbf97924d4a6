"""KITTI's view of a sample: its labels' lines, marks for "unknown", the order of objects, and rounding."""

from __future__ import annotations

import numpy as np
import pytest

from cadet import Camera, Lidar, Rig, Sample, Scene
from cadet.formats.kitti import frame_from_sample
from cadet.formats.kitti.from_sample import _rounded, labels_of
from cadet.sensors.sample import Wanted
from cadet.simulation.episode import request

RIG = Rig(camera=Camera.kitti().resized(310, 94), lidar=Lidar.vlp16())


@pytest.fixture(scope="module")
def sample() -> Sample:
    """Take a sample of a car 15 m ahead and of one that is too far for a label."""
    scene = Scene.empty(rig=RIG, weather="snow")
    scene.add("car", x_m=110.0, y_m=8.0, yaw_rad=0.0)
    scene.add("car", x_m=15.0, y_m=0.0, yaw_rad=0.0)
    native = scene._native.capture(request(RIG, 0, Wanted.all_of(["image_3"])))
    return Sample(native, RIG, {"seed": 3})


def test_objects_have_all_their_numbers_and_regions_have_marks_for_unknown(sample: Sample) -> None:
    car, region = labels_of(sample)
    seen = next(one for one in sample._sightings() or [] if one.is_labeled)
    assert car.to_line() == " ".join(
        ["Car", f"{seen.truncation:.2f}", str(seen.occlusion_level), f"{seen.observation_angle:.2f}"]
        + [f"{value:.2f}" for value in (*seen.bbox, *reversed(seen.size_lwh), *seen.location_cam, seen.rotation_y)]
    )
    assert car.location_cam[2] == pytest.approx(15.0 - 0.27, abs=0.5)
    assert region.type == "DontCare"
    fields = region.to_line().split()
    assert fields[1:4] == ["-1", "-1", "-10"] and fields[8:] == ["-1"] * 3 + ["-1000"] * 3 + ["-10"]


def test_a_frame_is_a_view_of_its_sample(sample: Sample) -> None:
    frame = frame_from_sample(sample)
    assert list(frame.images) == ["image_2", "image_3"] and list(frame.scans) == ["velodyne"]
    np.testing.assert_array_equal(frame.images["image_2"], frame.image)
    np.testing.assert_array_equal(frame.images["image_3"], sample.image("image_3"))
    assert not np.array_equal(frame.images["image_2"], frame.images["image_3"])
    assert sorted(agent.id for agent in frame.agents) == [1, 2]
    assert frame.meta is not None and frame.depth is not None
    assert (frame.meta["seed"], frame.meta["weather"], frame.meta["rig"]) == (3, "snow", "custom")
    assert {one["type"] for one in frame.meta["objects"]} == {"Car"}
    assert [one["actor_id"] for one in frame.meta["objects"]] == [2, 1], "labels first"


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.1234564, 0.123456),
        (0.1234566, 0.123457),
        # Halves go away from zero; decimal rounding would take these to the even digit.
        (2.5e-6, 3e-6),
        (-2.5e-6, -3e-6),
        (-2e-7, 0.0),
        (17.0, 17.0),
    ],
)
def test_numbers_of_a_meta_are_rounded_to_a_millionth(value: float, expected: float) -> None:
    assert _rounded(value) == expected and str(_rounded(value)) == str(expected)
