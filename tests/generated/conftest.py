"""Generated frames that several tests look at: made once a session."""

from __future__ import annotations

import pytest

import cadet
from sensed import Sensed, sense


@pytest.fixture(scope="session")
def street_frames() -> list[Sensed]:
    """Frames of ten suburbs, three each, the ego driving on between them."""
    frames = []
    for seed in range(10):
        scene = cadet.Scene.random(seed=seed, weather="clear_noon")
        for _ in range(3):
            frames.append(sense(scene))
            scene.step(2.0)
    return frames
