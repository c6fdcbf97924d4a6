"""Generated frames that several tests look at: made once a session."""

from __future__ import annotations

from dataclasses import replace

import pytest

import cadet
from scans.sensed import Sensed, sense


@pytest.fixture(scope="session")
def street_frames() -> list[Sensed]:
    """Frames of ten suburbs, three each, the ego driving on between them; labels hold exact boxes."""
    policy = replace(cadet.ResetPolicy.kitti(), label=cadet.LabelConfig(boxes="exact"))
    frames = []
    for seed in range(10):
        scene = cadet.Scene.random(seed=seed, weather="clear_noon", policy=policy)
        for _ in range(3):
            frames.append(sense(scene))
            scene.step(2.0)
    return frames
