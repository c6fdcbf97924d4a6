"""How full the paper policy's streets are: 1.4 cars and 0.49 pedestrians labeled in a frame."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

import cadet
from cadet import LabelConfig, ResetPolicy
from cadet.formats.kitti.from_sample import labels_of
from cadet.sensors.sample import Wanted
from cadet.simulation.episode import Episode

EPISODES, SAMPLES = 30, 7


@pytest.mark.timeout(600)
def test_labels_a_frame_are_the_papers() -> None:
    """A quarter of the image with a quarter of the pixel limits. Means differ by 0.17 and 0.12 from draw to draw."""
    policy = replace(ResetPolicy.paper(), label=LabelConfig(min_height_px=3.75, dontcare_min_pixels=0.5))
    policy = policy.with_each_rig(lambda rig: replace(rig, camera=rig.camera.resized(310, 94)))
    counts: Counter[str] = Counter()
    for number in range(EPISODES):
        episode = Episode(policy, 8, number, wanted=Wanted(maps=False))
        for sample in range(SAMPLES):
            counts.update(label.type for label in labels_of(episode.next_sample(sample)))
    num_frames = EPISODES * SAMPLES
    assert set(counts) <= {"Car", "Pedestrian", "DontCare"}
    assert abs(counts["Car"] / num_frames - 1.4) < 0.35
    assert abs(counts["Pedestrian"] / num_frames - 0.49) < 0.25


def test_the_towns_of_the_paper_are_used_where_they_are_handed_over() -> None:
    town = Path(__file__).parents[4] / "shared" / "maps" / "Town02.xodr"
    if not town.is_file():
        pytest.skip("needs CARLA's Town02 in ../shared/maps")
    # Its gaps between lanes are of sidewalks and shoulders, of which nobody has to be warned.
    scene = cadet.Scene.random(seed=1, policy="paper", map=town, weather="clear_noon")
    frame = scene.capture()
    assert frame.meta is not None
    assert (frame.meta["map"], frame.meta["rig"]) == ("Town02.xodr", "paper")
