"""KITTI's view of a sample that is made by hand: marks for "unknown", the order of lines, and rounding."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

import fake_native
from cadet import Rig, Sample
from cadet.kitti import frame_from_sample
from cadet.kitti.from_sample import _rounded, labels_of

pytestmark = pytest.mark.usefixtures("fake_core")


def make_sample() -> Sample:
    scene = fake_native.Scene((0, 0, 0), cast(Any, Rig.kitti().to_native()), "snow", None)
    native = scene.capture(fake_native.Request(0, maps=True, pixels=True, cameras=[1], lidars=[]))
    native.sightings = [fake_native.Sighting(7, is_labeled=True), fake_native.Sighting(2, is_labeled=False)]
    return Sample(cast(Any, native), Rig.kitti(), {"seed": 3})


def test_objects_have_all_their_numbers_and_regions_have_marks_for_unknown() -> None:
    car, region = labels_of(make_sample())
    assert car.to_line() == "Car 0.00 0 0.10 10.00 5.00 20.00 9.00 1.50 1.60 3.90 1.00 1.60 20.00 0.15"
    assert region.to_line() == "DontCare -1 -1 -10 1.00 2.00 3.00 4.00 -1 -1 -1 -1000 -1000 -1000 -10"


def test_a_frame_is_a_view_of_its_sample() -> None:
    sample = make_sample()
    frame = frame_from_sample(sample)
    assert list(frame.images) == ["image_2", "image_3"] and list(frame.scans) == ["velodyne"]
    np.testing.assert_array_equal(frame.images["image_2"], frame.image)
    np.testing.assert_array_equal(frame.images["image_3"], sample.image("image_3"))
    assert [agent.visible_share for agent in frame.agents] == [0.5]
    assert frame.meta is not None and frame.depth is not None
    assert (frame.meta["seed"], frame.meta["weather"], frame.meta["rig"]) == (3, "snow", "kitti")
    assert [one["actor_id"] for one in frame.meta["objects"]] == [7, 2]
    assert [one["type"] for one in frame.meta["objects"]] == ["Car", "Car"]


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
